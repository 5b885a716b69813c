#include "client/commands.h"
#include "client/control.h"

namespace shutterline::client {
namespace {

class PauseCommand : public ControlCommand {
 public:
  PauseCommand() : ControlCommand(v1::ControlRequest::ACTION_PAUSE, "pause the job") {}
  void Declare(CLI::App& app) override {
    ControlCommand::Declare(app);
    AddExamples(app, {"shutterline pause 0f8fad5b-d9cb-469f-a165-70867728950e --server farm:7400"},
                "Workers get no more tiles of it until it is resumed. What is done stays done; see resume.");
  }
};

class ResumeCommand : public ControlCommand {
 public:
  ResumeCommand() : ControlCommand(v1::ControlRequest::ACTION_RESUME, "resume the job") {}
  void Declare(CLI::App& app) override {
    ControlCommand::Declare(app);
    AddExamples(app, {"shutterline resume 0f8fad5b-d9cb-469f-a165-70867728950e --server farm:7400"},
                "A job that is not paused stays as it is.");
  }
};

}  // namespace

std::unique_ptr<Command> MakePauseCommand() {
  return std::make_unique<PauseCommand>();
}

std::unique_ptr<Command> MakeResumeCommand() {
  return std::make_unique<ResumeCommand>();
}

}  // namespace shutterline::client
