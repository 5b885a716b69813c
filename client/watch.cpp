#include "client/commands.h"
#include "client/delivery.h"
#include "client/interrupt.h"
#include "client/job_watch.h"
#include "client/json_output.h"
#include "client/options.h"
#include "client/server_option.h"
#include "common/base/status_macros.h"

namespace shutterline::client {
namespace {

class WatchCommand : public Command {
 public:
  void Declare(CLI::App& app) override {
    AddJobArgument(app, job_);
    server_.Declare(app);
    app.add_flag("--json", json_, "Print each event as a line of JSON, as it comes");
    AddQuietOption(app, quiet_);
    AddExamples(app, {"shutterline watch 0f8fad5b-d9cb-469f-a165-70867728950e --server farm:7400"},
                "Ends with the job: 0 if it succeeded, 3 if some of its frames were finished, else 1.\n"
                "A dropped connection is taken up again; Ctrl-C ends the watching, not the job.");
  }

  absl::Status Check() override { return server_.Check(); }

  absl::StatusOr<ExitCode> Run(Console& console) override {
    Interrupt interrupt;
    const SignalInterrupt signals(interrupt);
    SL_ASSIGN_OR_RETURN(const auto connection, server_.Connect(console, &interrupt, quiet_));
    Progress progress(ChooseStyle(console, quiet_ || json_), console.err);
    SL_ASSIGN_OR_RETURN(const v1::Job job, WatchJob(*connection, job_, [&](const v1::JobEvent& event) {
                          if (event.has_job()) progress.Update(FactsOf(event.job()));
                          if (json_) PrintEvent(event, console.out);
                          return absl::OkStatus();
                        }));
    progress.Finish();
    const Delivery delivery{job, {}, {}};
    if (!json_ && !quiet_) console.out << DescribeEnd(job) << "\n";
    return delivery.Code();
  }

 private:
  static void PrintEvent(const v1::JobEvent& event, std::ostream& out) {
    Json json{{"seq", event.seq()}};
    if (event.has_job()) json["job"] = ToJson(event.job());
    if (event.has_frame()) json["frame"] = ToJson(event.frame());
    Print(json, out, /*one_line=*/true);
  }

  std::string job_;
  ServerOption server_;
  bool json_ = false, quiet_ = false;
};

}  // namespace

std::unique_ptr<Command> MakeWatchCommand() {
  return std::make_unique<WatchCommand>();
}

}  // namespace shutterline::client
