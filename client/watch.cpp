#include <absl/synchronization/mutex.h>

#include <optional>

#include "client/commands.h"
#include "client/delivery.h"
#include "client/frame_preview.h"
#include "client/interrupt.h"
#include "client/job_watch.h"
#include "client/json_output.h"
#include "client/options.h"
#include "client/server_option.h"
#include "common/base/status_macros.h"
#include "common/job/tile.h"

namespace shutterline::client {
namespace {

class WatchCommand : public Command {
 public:
  void Declare(CLI::App& app) override {
    AddJobArgument(app, job_);
    server_.Declare(app);
    app.add_flag("--json", json_, "Print each event as a line of JSON, as it comes");
    AddQuietOption(app, quiet_);
    app.add_flag("--no-preview", no_preview_,
                 "No picture of the frame as it fills, which is drawn where standard\nerror is a terminal of "
                 "true colour ($COLORTERM)");
    AddExamples(app, {"shutterline watch 0f8fad5b-d9cb-469f-a165-70867728950e --server farm:7400"},
                "Ends with the job: 0 if it succeeded, 3 if some of its frames were finished, else 1.\n"
                "A dropped connection is taken up again; Ctrl-C ends the watching, not the job.");
  }

  absl::Status Check() override { return server_.Check(); }

  absl::StatusOr<ExitCode> Run(Console& console) override {
    Interrupt interrupt;
    const SignalInterrupt signals(interrupt);
    SL_ASSIGN_OR_RETURN(const auto connection, server_.Connect(console, &interrupt, quiet_));
    const ProgressStyle style = ChooseStyle(console, quiet_ || json_);
    Progress progress(style, console.err);
    absl::Mutex drawing;  // The preview draws from a thread of its own.
    std::unique_ptr<FramePreview> preview;
    if (style == ProgressStyle::kBar && !no_preview_) {
      SL_ASSIGN_OR_RETURN(preview, StartPreview(*connection, [&](std::vector<std::string> rows) {
                            absl::MutexLock lock(&drawing);
                            progress.SetPicture(std::move(rows));
                          }));
    }
    const absl::StatusOr<v1::Job> job = WatchJob(*connection, job_, [&](const v1::JobEvent& event) {
      if (event.has_job()) {
        absl::MutexLock lock(&drawing);
        progress.Update(FactsOf(event.job()));
      }
      if (event.has_frame() && preview != nullptr) preview->Show(event.frame().frame());
      if (json_) PrintEvent(event, console.out);
      return absl::OkStatus();
    });
    if (preview != nullptr) preview->Finish(/*hurry=*/!job.ok());
    SL_RETURN_IF_ERROR(job.status());
    progress.Finish();
    const Delivery delivery{*job, {}, {}};
    if (!json_ && !quiet_) console.out << DescribeEnd(*job) << "\n";
    return delivery.Code();
  }

 private:
  /// None where there is no room for it.
  absl::StatusOr<std::unique_ptr<FramePreview>> StartPreview(
      Connection& connection, std::function<void(std::vector<std::string>)> on_picture) const {
    const std::optional<FramePreview::Size> size = PreviewSize();
    if (!size) return nullptr;
    v1::JobRef request;
    request.set_job_id(job_);
    SL_ASSIGN_OR_RETURN(const v1::Job job,
                        connection.Repeat<v1::Job>("get the job", [&](auto* context, auto* reply) {
                          return connection.jobs().Get(context, request, reply);
                        }));
    const TileGrid grid{job.spec().render().width(), job.spec().render().height()};
    if (grid.width < 1 || grid.height < 1) return nullptr;
    const bool coarse = job.spec().order() == v1::TILE_ORDER_COARSE;
    return std::make_unique<FramePreview>(connection, job_, grid, coarse, *size, std::move(on_picture));
  }

  static void PrintEvent(const v1::JobEvent& event, std::ostream& out) {
    Json json{{"seq", event.seq()}};
    if (event.has_job()) json["job"] = ToJson(event.job());
    if (event.has_frame()) json["frame"] = ToJson(event.frame());
    Print(json, out, /*one_line=*/true);
  }

  std::string job_;
  ServerOption server_;
  bool json_ = false, quiet_ = false, no_preview_ = false;
};

}  // namespace

std::unique_ptr<Command> MakeWatchCommand() {
  return std::make_unique<WatchCommand>();
}

}  // namespace shutterline::client
