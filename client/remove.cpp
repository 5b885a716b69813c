#include "client/commands.h"
#include "client/control.h"

namespace shutterline::client {
namespace {

class RemoveCommand : public ControlCommand {
 public:
  RemoveCommand() : ControlCommand(v1::ControlRequest::ACTION_REMOVE, "remove the job") {}
  void Declare(CLI::App& app) override {
    ControlCommand::Declare(app);
    AddExamples(
        app, {"shutterline remove 0f8fad5b-d9cb-469f-a165-70867728950e --server farm:7400"},
        "The server forgets the job, with its frames and its log, and makes room. It must have ended, and\n"
        "no other job wait for it. Prints how it had ended; fetch before what is to be kept.");
  }
};

}  // namespace

std::unique_ptr<Command> MakeRemoveCommand() {
  return std::make_unique<RemoveCommand>();
}

}  // namespace shutterline::client
