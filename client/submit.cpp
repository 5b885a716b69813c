#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>
#include <pwd.h>
#include <unistd.h>

#include <optional>

#include "client/commands.h"
#include "client/delivery.h"
#include "client/interrupt.h"
#include "client/job_submission.h"
#include "client/json_output.h"
#include "client/options.h"
#include "client/parse.h"
#include "client/report.h"
#include "client/server_option.h"
#include "common/base/ids.h"
#include "common/base/status_macros.h"
#include "common/job/describe_settings.h"

namespace shutterline::client {
namespace {

/// Who runs this program; a number where the system knows no name.
std::string LoginName() {
  const passwd* entry = getpwuid(geteuid());
  return entry == nullptr ? absl::StrCat(geteuid()) : entry->pw_name;
}

class SubmitCommand : public Command {
 public:
  void Declare(CLI::App& app) override {
    AddJobOptions(app, options_);
    DeclareWishes(app);
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
    if (wishes_.user().empty()) wishes_.set_user(LoginName());
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
    SceneReading scene(options_, &interrupt);
    SL_ASSIGN_OR_RETURN(const auto connection, server_.Connect(console, &interrupt, quiet_));
    Progress progress(ChooseStyle(console, quiet_), console.err);
    SL_ASSIGN_OR_RETURN(const Submission submission,
                        SubmitJob(*connection, options_, scene, wishes_, progress));
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
  void DeclareWishes(CLI::App& app) {
    auto* priority =
        AddValue(app, "--priority", "N", "0", "From -1000 to 1000; jobs of a higher one are served first",
                 [this](const std::string& text) {
                   SL_ASSIGN_OR_RETURN(const int64_t value, ParseWhole(text, -1000, 1000));
                   wishes_.set_priority(int32_t(value));
                   return absl::OkStatus();
                 });
    auto* user =
        AddValue(app, "--user", "NAME", "who you are", "On whose account; users get equal shares of the farm",
                 [this](const std::string& text) {
                   if (text.empty() || text.size() > 128) {
                     return absl::InvalidArgumentError("must have 1 to 128 bytes");
                   }
                   wishes_.set_user(text);
                   return absl::OkStatus();
                 });
    auto* after = AddValue(app, "--after", "JOB[,JOB...]", "", "Begin when these jobs have succeeded",
                           [this](const std::string& text) {
                             for (const absl::string_view id : absl::StrSplit(text, ',')) {
                               if (!IsUuid(id)) {
                                 return absl::InvalidArgumentError(
                                     "must be whole ids of jobs, as 'shutterline list' prints them");
                               }
                               wishes_.add_after(std::string(id));
                             }
                             return absl::OkStatus();
                           });
    auto* order =
        AddValue(app, "--order", "hilbert|center|coarse", "hilbert",
                 "Which tiles of a frame come first: neighbours after one another,\nwhich is fastest; from "
                 "the middle outwards; or all over the\nframe at once. For watching: pictures are the same",
                 [this](const std::string& text) {
                   const std::optional<TileOrder> parsed = ParseTileOrder(text);
                   if (!parsed) return absl::InvalidArgumentError("must be hilbert, center or coarse");
                   options_.order = *parsed;
                   return absl::OkStatus();
                 });
    for (CLI::Option* option : {priority, user, after, order}) option->group("Farm");
  }

  JobOptions options_;
  v1::SubmitRequest wishes_;  ///< What it asks for beside the specification.
  ServerOption server_;
  bool wait_ = false, json_ = false, quiet_ = false, stats_ = false;
};

}  // namespace

std::unique_ptr<Command> MakeSubmitCommand() {
  return std::make_unique<SubmitCommand>();
}

}  // namespace shutterline::client
