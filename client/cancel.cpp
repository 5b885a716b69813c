#include "client/commands.h"
#include "client/delivery.h"
#include "client/json_output.h"
#include "client/options.h"
#include "client/server_option.h"
#include "common/base/status_macros.h"

namespace shutterline::client {
namespace {

class CancelCommand : public Command {
 public:
  void Declare(CLI::App& app) override {
    AddJobArgument(app, job_);
    server_.Declare(app);
    AddJsonOption(app, json_);
    AddExamples(app, {"shutterline cancel 0f8fad5b-d9cb-469f-a165-70867728950e --server farm:7400"},
                "A job that has ended stays as it is. Finished frames can still be fetched.");
  }

  absl::Status Check() override { return server_.Check(); }

  absl::StatusOr<ExitCode> Run(Console& console) override {
    SL_ASSIGN_OR_RETURN(const auto connection, server_.Connect(console, nullptr));
    v1::ControlRequest request;
    request.set_job_id(job_);
    request.set_action(v1::ControlRequest::ACTION_CANCEL);
    SL_ASSIGN_OR_RETURN(const v1::Job job,
                        connection->Repeat<v1::Job>("cancel the job", [&](auto* context, auto* reply) {
                          return connection->jobs().Control(context, request, reply);
                        }));
    if (json_) {
      Print(ToJson(job), console.out);
    } else {
      console.out << DescribeEnd(job) << "\n";
    }
    return ExitCode::kSuccess;
  }

 private:
  std::string job_;
  ServerOption server_;
  bool json_ = false;
};

}  // namespace

std::unique_ptr<Command> MakeCancelCommand() {
  return std::make_unique<CancelCommand>();
}

}  // namespace shutterline::client
