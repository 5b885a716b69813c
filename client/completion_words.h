#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace shutterline::client {

/// What a shell needs to know of one option or argument.
struct CompletionOption {
  std::vector<std::string> names;  ///< "-o", "--output"; empty for an argument.
  std::string description;         ///< In one line.
  std::string value;               ///< How its value is called, as "WxH"; empty for a flag.
  std::vector<std::string> words;  ///< Values that the help lists: line, reference, stochastic.
  bool file = false;               ///< Its value is a file's name.
};

/// One command, or the program itself.
struct CompletionCommand {
  std::string name, description;
  std::vector<CompletionOption> options, arguments;
};

/// The program's own options first, then its commands in the order of its help.
std::vector<CompletionCommand> CompletionCommands(const CLI::App& app);

}  // namespace shutterline::client
