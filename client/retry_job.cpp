#include "client/commands.h"
#include "client/control.h"

namespace shutterline::client {
namespace {

class RetryCommand : public ControlCommand {
 public:
  RetryCommand() : ControlCommand(v1::ControlRequest::ACTION_RETRY, "retry the job") {}
  void Declare(CLI::App& app) override {
    ControlCommand::Declare(app);
    AddExamples(app, {"shutterline retry 0f8fad5b-d9cb-469f-a165-70867728950e --server farm:7400"},
                "Of a partial job the tiles that are missing are rendered, and their frames written anew; of "
                "one that\n"
                "failed or was cancelled, the frames that are not finished. A job that has succeeded stays "
                "as it is.");
  }
};

}  // namespace

std::unique_ptr<Command> MakeRetryCommand() {
  return std::make_unique<RetryCommand>();
}

}  // namespace shutterline::client
