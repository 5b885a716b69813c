#include "client/commands.h"
#include "client/control.h"
#include "client/parse.h"
#include "common/base/status_macros.h"

namespace shutterline::client {
namespace {

class PriorityCommand : public ControlCommand {
 public:
  PriorityCommand() : ControlCommand(v1::ControlRequest::ACTION_SET_PRIORITY, "set the job's priority") {}
  void Declare(CLI::App& app) override {
    ControlCommand::Declare(app);
    AddValue(app, "PRIORITY", "", "", "From -1000 to 1000; jobs of a higher one are served first",
             [this](const std::string& text) {
               SL_ASSIGN_OR_RETURN(const int64_t priority, ParseWhole(text, -1000, 1000));
               request().set_priority(int32_t(priority));
               return absl::OkStatus();
             })
        ->required();
    AddExamples(app, {"shutterline priority 0f8fad5b-d9cb-469f-a165-70867728950e 10 --server farm:7400"},
                "Tiles that workers have begun are not taken from them.");
  }
};

}  // namespace

std::unique_ptr<Command> MakePriorityCommand() {
  return std::make_unique<PriorityCommand>();
}

}  // namespace shutterline::client
