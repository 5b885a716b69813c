#pragma once

#include <memory>
#include <vector>

#include "client/command_line.h"

namespace shutterline::client {

// One file per command.
std::unique_ptr<Command> MakeRenderCommand();
std::unique_ptr<Command> MakeSubmitCommand();
std::unique_ptr<Command> MakeStatusCommand();
std::unique_ptr<Command> MakeListCommand();
std::unique_ptr<Command> MakeWatchCommand();
std::unique_ptr<Command> MakeFetchCommand();
std::unique_ptr<Command> MakeLogsCommand();
std::unique_ptr<Command> MakeCancelCommand();
std::unique_ptr<Command> MakeTraceCommand();
std::unique_ptr<Command> MakePauseCommand();
std::unique_ptr<Command> MakeResumeCommand();
std::unique_ptr<Command> MakeRetryCommand();
std::unique_ptr<Command> MakePriorityCommand();
std::unique_ptr<Command> MakeRemoveCommand();
std::unique_ptr<Command> MakeWorkersCommand();
std::unique_ptr<Command> MakeInfoCommand();
std::unique_ptr<Command> MakeCompareCommand();
std::unique_ptr<Command> MakeCompletionCommand();

/// Every command of the program `shutterline`, in the order of its help.
const std::vector<CommandEntry>& CommandTable();

}  // namespace shutterline::client
