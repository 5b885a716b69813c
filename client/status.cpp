#include <absl/strings/str_cat.h>

#include <iomanip>

#include "client/commands.h"
#include "client/delivery.h"
#include "client/human.h"
#include "client/job_watch.h"
#include "client/json_output.h"
#include "client/options.h"
#include "client/server_option.h"
#include "common/base/status_macros.h"

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
    AddExamples(app, {"shutterline status 0f8fad5b-d9cb-469f-a165-70867728950e --server farm:7400"});
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
    if (json_) {
      Print(ToJson(job), console.out);
    } else {
      PrintJob(job, console.out);
    }
    return ExitCode::kSuccess;
  }

 private:
  static void PrintJob(const v1::Job& job, std::ostream& out) {
    const ProgressFacts facts = FactsOf(job);
    const v1::JobSpec& spec = job.spec();
    PrintRow(out, "job", job.id());
    PrintRow(out, "name", spec.name());
    PrintRow(out, "scene", spec.scene().root_name());
    PrintRow(out, "state",
             facts.note.empty() ? facts.state : absl::StrCat(facts.state, " (", facts.note, ")"));
    PrintRow(out, "error", job.error());
    PrintRow(out, "frames", absl::StrCat(job.frames_finished(), " of ", job.frames_total(), " finished"));
    PrintRow(out, "tiles", absl::StrCat(job.tiles_done(), " of ", job.tiles_total(), " done"));
    PrintRow(out, "size", absl::StrCat(spec.render().width(), "x", spec.render().height()));
    PrintRow(out, "submitted", TimeText(job.submitted()));
    PrintRow(out, "ended", TimeText(job.ended()));
    PrintRow(out, "workers", HasEnded(job.state()) ? "" : absl::StrCat(job.workers(), " connected"));
    if (job.mismatched_tiles() > 0) {
      PrintRow(out, "warning",
               absl::StrCat(job.mismatched_tiles(), " tiles were rendered twice with different pixels"));
    }
  }

  std::string job_;
  ServerOption server_;
  bool json_ = false;
};

}  // namespace

std::unique_ptr<Command> MakeStatusCommand() {
  return std::make_unique<StatusCommand>();
}

}  // namespace shutterline::client
