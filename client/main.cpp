#include <unistd.h>

#include <csignal>
#include <iostream>
#include <string>
#include <vector>

#include "client/command_line.h"
#include "client/commands.h"
#include "common/base/lock_order.h"

int main(int argc, char** argv) {
  shutterline::TrustLockOrder();
  // A reader that goes away (`shutterline list | head`) is an error of writing, not a reason to die.
  std::signal(SIGPIPE, SIG_IGN);
  shutterline::client::Console console{std::cout, std::cerr, isatty(STDERR_FILENO) == 1};
  return shutterline::client::RunCommandLine(std::vector<std::string>(argv + 1, argv + argc),
                                             shutterline::client::CommandTable(), console);
}
