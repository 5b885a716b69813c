#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>

#include <iomanip>
#include <map>
#include <optional>

#include "client/commands.h"
#include "client/delivery.h"
#include "client/human.h"
#include "client/job_watch.h"
#include "client/json_output.h"
#include "client/options.h"
#include "client/server_option.h"
#include "client/stats_report.h"
#include "common/base/status_macros.h"
#include "common/job/describe_settings.h"
#include "proto/convert/job_spec.h"

namespace shutterline::client {
namespace {

void PrintRow(std::ostream& out, const char* key, const std::string& value) {
  if (!value.empty()) out << std::left << std::setw(11) << key << Printable(value) << "\n";
}

class StatusCommand : public Command {
 public:
  void Declare(CLI::App& app) override {
    AddJobArgument(app, job_);
    server_.Declare(app);
    AddJsonOption(app, json_);
    AddStatsOption(app, stats_);
    AddExamples(app,
                {"shutterline status 0f8fad5b-d9cb-469f-a165-70867728950e --server farm:7400",
                 "shutterline status 0f8fad5b-d9cb-469f-a165-70867728950e --stats --server farm:7400"},
                "Statistics are told of jobs that have ended, failed and cancelled ones included.");
  }

  absl::Status Check() override { return server_.Check(); }

  absl::StatusOr<ExitCode> Run(Console& console) override {
    SL_ASSIGN_OR_RETURN(const auto connection, server_.Connect(console, nullptr));
    v1::JobRef request;
    request.set_job_id(job_);
    SL_ASSIGN_OR_RETURN(const v1::Job job,
                        connection->Repeat<v1::Job>("get the job", [&](auto* context, auto* reply) {
                          return connection->jobs().Get(context, request, reply);
                        }));
    std::optional<StatsReport> stats;
    if (stats_) {
      SL_ASSIGN_OR_RETURN(stats, Statistics(*connection, job));
    }
    if (json_) {
      Json json = ToJson(job);
      if (stats) json["stats"] = ToJson(*stats);
      Print(json, console.out);
    } else {
      PrintJob(job, console.out);
      if (stats) PrintStats(*stats, console.out);
    }
    return ExitCode::kSuccess;
  }

 private:
  /// What the finished frames of a job took; FAILED_PRECONDITION before its end.
  static absl::StatusOr<StatsReport> Statistics(Connection& connection, const v1::Job& job) {
    if (!HasEnded(job.state())) {
      return absl::FailedPreconditionError(absl::StrCat("job ", job.id(), " is ", WordOf(job.state()),
                                                        ": --stats tells of jobs that have ended"));
    }
    SL_ASSIGN_OR_RETURN(const RenderSettings settings,
                        convert::FromProto(job.spec().render(), "spec.render"));
    std::map<int, v1::FrameStatus> finished;
    SL_RETURN_IF_ERROR(WatchJob(connection, job.id(), [&](const v1::JobEvent& event) {
                         if (event.has_frame() && event.frame().state() == v1::FRAME_STATE_FINISHED) {
                           finished[event.frame().frame()] = event.frame();
                         }
                         return absl::OkStatus();
                       }).status());
    return MakeStatsReport(DescribeSettings(settings), finished);
  }

  static void PrintJob(const v1::Job& job, std::ostream& out) {
    const ProgressFacts facts = FactsOf(job);
    const v1::JobSpec& spec = job.spec();
    PrintRow(out, "job", job.id());
    PrintRow(out, "name", spec.name());
    PrintRow(out, "scene", spec.scene().root_name());
    PrintRow(out, "state",
             facts.note.empty() ? facts.state : absl::StrCat(facts.state, " (", facts.note, ")"));
    PrintRow(out, "error", job.error());
    if (job.priority() != 0) PrintRow(out, "priority", absl::StrCat(job.priority()));
    PrintRow(out, "user", job.user());
    for (const std::string& id : job.waits_for()) PrintRow(out, "waits for", id);
    PrintRow(out, "frames", absl::StrCat(job.frames_finished(), " of ", job.frames_total(), " finished"));
    PrintRow(out, "tiles", absl::StrCat(job.tiles_done(), " of ", job.tiles_total(), " done"));
    PrintRow(out, "size", absl::StrCat(spec.render().width(), "x", spec.render().height()));
    if (spec.order() > v1::TILE_ORDER_HILBERT) PrintRow(out, "order", WordOf(spec.order()));
    PrintRow(out, "submitted", TimeText(job.submitted()));
    PrintRow(out, "ended", TimeText(job.ended()));
    PrintRow(out, "workers", HasEnded(job.state()) ? "" : absl::StrCat(job.workers(), " connected"));
    if (job.mismatched_tiles() > 0) {
      PrintRow(out, "warning",
               absl::StrCat(job.mismatched_tiles(), " tiles were rendered twice with different pixels"));
    }
    PrintQuarantined(job, out);
  }

  /// Each tile in a line of its own, and below it what went wrong, each time.
  static void PrintQuarantined(const v1::Job& job, std::ostream& out) {
    for (const v1::QuarantinedTile& tile : job.quarantined()) {
      PrintRow(out, "missing", absl::StrCat("frame ", tile.frame(), ", tile ", tile.tile()));
      for (const v1::TileTrouble& trouble : tile.evidence()) {
        PrintRow(out, "",
                 absl::StrCat(TimeText(trouble.time()), "  ", trouble.worker_name(), " (",
                              trouble.worker_uuid(), "): ", trouble.reason()));
        for (const absl::string_view line : absl::StrSplit(trouble.log_tail(), '\n', absl::SkipEmpty())) {
          PrintRow(out, "", absl::StrCat("  ", line));
        }
      }
    }
    const uint64_t more = job.tiles_quarantined() - uint64_t(job.quarantined_size());
    if (more > 0) PrintRow(out, "missing", absl::StrCat(more, " more tiles"));
  }

  std::string job_;
  ServerOption server_;
  bool json_ = false, stats_ = false;
};

}  // namespace

std::unique_ptr<Command> MakeStatusCommand() {
  return std::make_unique<StatusCommand>();
}

}  // namespace shutterline::client
