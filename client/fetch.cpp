#include <absl/strings/str_cat.h>

#include <optional>

#include "client/commands.h"
#include "client/delivery.h"
#include "client/frame_range.h"
#include "client/human.h"
#include "client/interrupt.h"
#include "client/json_output.h"
#include "client/options.h"
#include "client/server_option.h"
#include "common/base/status_macros.h"
#include "proto/convert/job_spec.h"

namespace shutterline::client {
namespace {

class FetchCommand : public Command {
 public:
  void Declare(CLI::App& app) override {
    AddJobArgument(app, job_);
    server_.Declare(app);
    AddOutputOption(app, output_,
                    "Where frames go; #### stands for the frame's number.\nDefault: the scene's name with "
                    ".exr, in the working folder");
    AddValue(app, "--frame", "N", "all finished ones", "The one frame to fetch",
             [this](const std::string& t) {
               SL_ASSIGN_OR_RETURN(const FrameRange one, ParseFrame(t));
               frame_ = one.first;
               return absl::OkStatus();
             });
    app.add_flag("--png", png_, "Also write an 8-bit sRGB preview, x.png beside x.exr");
    AddJsonOption(app, json_);
    AddQuietOption(app, quiet_);
    AddExamples(app,
                {"shutterline fetch 0f8fad5b-d9cb-469f-a165-70867728950e -o fox.####.exr --server farm:7400",
                 "shutterline fetch 0f8fad5b-d9cb-469f-a165-70867728950e --frame 12 -o fox.exr"},
                "Goes on where an interrupted fetch ended, verifies digests, and puts files in place whole.\n"
                "Exit code 3 if some of the job's frames are not finished, 1 if none is.");
  }

  absl::Status Check() override { return server_.Check(); }

  absl::StatusOr<ExitCode> Run(Console& console) override {
    Interrupt interrupt;
    const SignalInterrupt signals(interrupt);
    SL_ASSIGN_OR_RETURN(const auto connection, server_.Connect(console, &interrupt, quiet_));
    v1::JobRef request;
    request.set_job_id(job_);
    SL_ASSIGN_OR_RETURN(const v1::Job job,
                        connection->Repeat<v1::Job>("get the job", [&](auto* context, auto* reply) {
                          return connection->jobs().Get(context, request, reply);
                        }));
    SL_ASSIGN_OR_RETURN(const JobSpec spec, convert::FromProto(job.spec(), AnyLimits()));
    if (frame_ && !spec.frames.IndexOf(*frame_)) {
      return absl::NotFoundError(absl::StrCat("fetch frame ", *frame_, ": the job has frames ",
                                              spec.frames.first, "-", spec.frames.last, "x",
                                              spec.frames.step));
    }
    if (!output_) {
      SL_ASSIGN_OR_RETURN(output_, OutputPath::Parse(DefaultOutput(spec.scene.root_name)));
    }
    SL_RETURN_IF_ERROR(CheckDestination(*output_));
    return frame_ ? FetchOne(*connection, console) : FetchAll(*connection, console, job, spec.frames);
  }

 private:
  /// What the server accepted once is not judged again.
  static JobLimits AnyLimits() {
    constexpr int64_t kAny = int64_t{1} << 62;
    return {kAny, kAny, kAny, kAny};
  }

  absl::StatusOr<ExitCode> FetchOne(Connection& connection, Console& console) const {
    SL_ASSIGN_OR_RETURN(const FetchedFrame fetched,
                        FetchFrame(connection, job_, *frame_, output_->FrameFile(*frame_, 1), png_));
    Json frames = Json::array();
    Tell(console, fetched, frames);
    if (json_) Print(Json{{"frames", frames}}, console.out);
    return ExitCode::kSuccess;
  }

  absl::StatusOr<ExitCode> FetchAll(Connection& connection, Console& console, const v1::Job& job,
                                    const FrameRange& range) const {
    Json frames = Json::array();
    int64_t fetched = 0;
    // The job says how many of its frames are finished, not which. More may become so meanwhile.
    for (int64_t i = 0; i < range.Count() && fetched < int64_t{job.frames_finished()}; ++i) {
      const int frame = range.Frame(i);
      const auto one = FetchFrame(connection, job_, frame, output_->FrameFile(frame, range.Count()), png_);
      if (absl::IsFailedPrecondition(one.status())) continue;
      if (!one.ok()) return one.status();
      ++fetched;
      Tell(console, *one, frames);
    }
    if (json_) Print(Json{{"frames", frames}}, console.out);
    if (fetched == range.Count()) return ExitCode::kSuccess;
    console.err << "shutterline: fetch job " << job_ << ": " << fetched << " of " << range.Count()
                << " frames are finished (the job is " << WordOf(job.state()) << ")\n";
    return fetched > 0 ? ExitCode::kPartial : ExitCode::kFailed;
  }

  void Tell(Console& console, const FetchedFrame& frame, Json& frames) const {
    frames.push_back(ToJson(frame));
    if (json_ || quiet_) return;
    console.out << Printable(frame.path) << "\n";
    if (!frame.preview.empty()) console.out << Printable(frame.preview) << "\n";
    console.out << std::flush;
  }

  std::string job_;
  ServerOption server_;
  std::optional<OutputPath> output_;
  std::optional<int> frame_;
  bool png_ = false, json_ = false, quiet_ = false;
};

}  // namespace

std::unique_ptr<Command> MakeFetchCommand() {
  return std::make_unique<FetchCommand>();
}

}  // namespace shutterline::client
