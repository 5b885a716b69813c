#include <absl/strings/str_cat.h>

#include <optional>

#include "client/commands.h"
#include "client/delivery.h"
#include "client/interrupt.h"
#include "client/job_submission.h"
#include "client/json_output.h"
#include "client/options.h"
#include "client/report.h"
#include "client/server_option.h"
#include "common/base/status_macros.h"
#include "common/job/describe_settings.h"

namespace shutterline::client {
namespace {

class SubmitCommand : public Command {
 public:
  void Declare(CLI::App& app) override {
    AddJobOptions(app, options_);
    server_.Declare(app);
    app.add_flag("--wait", wait_, "Follow the job to its end and fetch its frames into -o")->group("Output");
    AddJsonOption(app, json_);
    AddQuietOption(app, quiet_);
    AddStatsOption(app, stats_);
    AddExamples(app,
                {"shutterline submit fox.glb --frames 1-48 --server farm:7400",
                 "shutterline submit fox.glb --frames 1-48 --wait -o fox.####.exr --png --server farm:7400"},
                "Without --wait, prints the job's id and leaves: see watch and fetch. Files that the server\n"
                "has already are not uploaded again.");
  }

  absl::Status Check() override {
    SL_RETURN_IF_ERROR(server_.Check());
    if (!wait_ && options_.output) {
      return absl::InvalidArgumentError("--output needs --wait; without it, use 'shutterline fetch'");
    }
    if (!wait_ && options_.png) {
      return absl::InvalidArgumentError("--png needs --wait; without it, use 'shutterline fetch --png'");
    }
    if (!wait_ && stats_) {
      return absl::InvalidArgumentError("--stats needs --wait; without it, use 'shutterline status --stats'");
    }
    return CheckJobOptions(options_);
  }

  absl::StatusOr<ExitCode> Run(Console& console) override {
    std::optional<Destination> destination;
    if (options_.output) {
      destination = Destination{*options_.output, options_.png};
    } else if (wait_) {
      SL_ASSIGN_OR_RETURN(OutputPath output, OutputPath::Parse(DefaultOutput(options_.scene)));
      destination = Destination{output, options_.png};
    }
    if (destination) SL_RETURN_IF_ERROR(CheckDestination(destination->output));

    Interrupt interrupt;
    const SignalInterrupt signals(interrupt);
    SL_ASSIGN_OR_RETURN(const auto connection, server_.Connect(console, &interrupt, quiet_));
    Progress progress(ChooseStyle(console, quiet_), console.err);
    SL_ASSIGN_OR_RETURN(const Submission submission, SubmitJob(*connection, options_, progress));
    const std::string& id = submission.job.id();
    if (!wait_) {
      if (json_) {
        Print(Json{{"job", ToJson(submission.job)}, {"upload", ToJson(submission.upload)}}, console.out);
      } else {
        console.out << id << "\n";
      }
      return ExitCode::kSuccess;
    }

    progress.Note(absl::StrCat("job ", id));
    absl::StatusOr<Delivery> delivery = Deliver(*connection, id, options_.frames, &*destination, progress);
    if (!delivery.ok()) {
      return Annotate(delivery.status(), absl::StrCat("job ", id, " is left to the server"));
    }
    ReportOptions report{json_, quiet_, std::nullopt};
    if (stats_) report.stats_of = DescribeSettings(options_.settings);
    return Report(console, *delivery, submission.upload, report);
  }

 private:
  JobOptions options_;
  ServerOption server_;
  bool wait_ = false, json_ = false, quiet_ = false, stats_ = false;
};

}  // namespace

std::unique_ptr<Command> MakeSubmitCommand() {
  return std::make_unique<SubmitCommand>();
}

}  // namespace shutterline::client
