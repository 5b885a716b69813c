#include "client/commands.h"

namespace shutterline::client {

const std::vector<CommandEntry>& CommandTable() {
  static const auto* const table = new std::vector<CommandEntry>{
      {"render", "On this machine", "Render a scene here, without a server", MakeRenderCommand},
      {"info", "On this machine", "Tell what a scene contains", MakeInfoCommand},
      {"compare", "On this machine", "Measure how two pictures differ", MakeCompareCommand},
      {"completion", "On this machine", "Print a script that completes commands in a shell",
       MakeCompletionCommand},
      {"submit", "On a farm", "Give a scene to a server to render", MakeSubmitCommand},
      {"status", "On a farm", "Tell how a job stands", MakeStatusCommand},
      {"list", "On a farm", "List the server's jobs, latest first", MakeListCommand},
      {"watch", "On a farm", "Follow a job until it has ended", MakeWatchCommand},
      {"fetch", "On a farm", "Get a job's finished frames", MakeFetchCommand},
      {"logs", "On a farm", "Tell what happened to a job", MakeLogsCommand},
      {"cancel", "On a farm", "End a job; finished frames stay", MakeCancelCommand},
      {"pause", "On a farm", "Give no more tiles of a job to workers", MakePauseCommand},
      {"resume", "On a farm", "Let a paused job go on", MakeResumeCommand},
      {"retry", "On a farm", "Render again what a job lacks", MakeRetryCommand},
      {"priority", "On a farm", "Serve a job before or after others", MakePriorityCommand},
      {"remove", "On a farm", "Forget a job that has ended, and its frames", MakeRemoveCommand},
      {"trace", "On a farm", "Write which worker rendered which tile when", MakeTraceCommand},
      {"workers", "On a farm", "List the workers that are connected", MakeWorkersCommand},
  };
  return *table;
}

}  // namespace shutterline::client
