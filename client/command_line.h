#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

/// The frame that all commands share: one class per command, declared and run by RunCommandLine.
namespace shutterline::client {

/// What a command's process ends with.
enum class ExitCode {
  kSuccess = 0,
  kFailed = 1,   ///< Something that was asked for could not be done.
  kUsage = 2,    ///< The command line is not one that the program understands.
  kPartial = 3,  ///< Some frames were delivered, but not all.
};

/// Where a command speaks: facts to `out`, progress and errors to `err`.
struct Console {
  std::ostream& out;
  std::ostream& err;
  bool err_is_terminal = false;  ///< Progress may be drawn as a bar.
};

/// One command of the program: Declare Check? Run?, each at most once.
class Command {
 public:
  virtual ~Command() = default;

  /// Adds the command's arguments, options and examples to `app`. What they set lives in this object.
  virtual void Declare(CLI::App& app) = 0;
  /// What no option can know alone. An error is one of usage (exit code 2).
  virtual absl::Status Check() { return absl::OkStatus(); }
  /// Does it. An error is printed, and ends in exit code 1.
  virtual absl::StatusOr<ExitCode> Run(Console& console) = 0;
};

/// A row of the program's command table.
struct CommandEntry {
  const char* name;
  const char* group;    ///< Heading in the program's help.
  const char* summary;  ///< One sentence.
  std::function<std::unique_ptr<Command>()> make;
};

/// Parses `arguments` (without the program's name) against `table`, runs the command that they name and
/// returns the process's exit code. Every error goes to `console.err` as one line "shutterline: ...".
int RunCommandLine(const std::vector<std::string>& arguments, const std::vector<CommandEntry>& table,
                   Console& console);

/// The program's parser with every command of `table` declared; `commands` receives the commands, in
/// the table's order, and must live as long as the parser is used.
std::unique_ptr<CLI::App> MakeParser(const std::vector<CommandEntry>& table,
                                     std::vector<std::unique_ptr<Command>>& commands);

/// An option (or, without dashes, a positional argument) of one value. `read` turns the text into a
/// value; where it fails, so does the command line, with a message that names option, text and reason.
/// `value_name` and `default_text` are for the help; an empty default is not shown.
CLI::Option* AddValue(CLI::App& app, const std::string& names, const std::string& value_name,
                      const std::string& default_text, const std::string& description,
                      std::function<absl::Status(const std::string&)> read);

/// Shows `examples`, one command line each, at the end of the command's help.
void AddExamples(CLI::App& app, const std::vector<std::string>& examples,
                 const std::string& closing_words = "");

}  // namespace shutterline::client
