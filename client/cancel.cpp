#include "client/commands.h"
#include "client/control.h"

namespace shutterline::client {
namespace {

class CancelCommand : public ControlCommand {
 public:
  CancelCommand() : ControlCommand(v1::ControlRequest::ACTION_CANCEL, "cancel the job") {}
  void Declare(CLI::App& app) override {
    ControlCommand::Declare(app);
    AddExamples(app, {"shutterline cancel 0f8fad5b-d9cb-469f-a165-70867728950e --server farm:7400"},
                "A job that has ended stays as it is. Finished frames can still be fetched.");
  }
};

}  // namespace

std::unique_ptr<Command> MakeCancelCommand() {
  return std::make_unique<CancelCommand>();
}

}  // namespace shutterline::client
