#include "client/command_line.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <utility>

#include "client/human.h"
#include "client/template_file.h"
#include "common/base/build_id.h"

namespace shutterline::client {
namespace {

constexpr int kOptionColumn = 34;

void PrintError(Console& console, absl::string_view message) {
  console.err << "shutterline: " << Printable(message) << "\n" << std::flush;
}

/// The command that was named, for "see shutterline render --help".
std::string HelpHint(const CLI::App& app) {
  const auto chosen = app.get_subcommands();
  return chosen.empty() ? "shutterline --help"
                        : absl::StrCat("shutterline ", chosen.front()->get_name(), " --help");
}

}  // namespace

std::unique_ptr<CLI::App> MakeParser(const std::vector<CommandEntry>& table,
                                     std::vector<std::unique_ptr<Command>>& commands) {
  auto app = std::make_unique<CLI::App>(
      "Shutterline renders glTF scenes with analytic motion blur, on this machine or on a farm.",
      "shutterline");
  app->get_formatter()->column_width(kOptionColumn);
  app->get_formatter()->label("SUBCOMMAND", "COMMAND");
  app->set_version_flag("--version", absl::StrCat("shutterline ", kBuildId), "Print the version and exit");
  app->require_subcommand(1);
  app->set_help_flag("-h,--help", "Print this help and exit");
  app->footer(
      "Exit codes: 0 success, 1 failed, 2 usage, 3 partial (some frames, but not all).\n"
      "shutterline COMMAND --help explains each command by example.");
  for (const CommandEntry& entry : table) {
    CLI::App* sub = app->add_subcommand(entry.name, entry.summary);
    sub->group(entry.group);
    commands.push_back(entry.make());
    commands.back()->Declare(*sub);
  }
  return app;
}

int RunCommandLine(const std::vector<std::string>& arguments, const std::vector<CommandEntry>& table,
                   Console& console) {
  std::vector<std::unique_ptr<Command>> commands;
  const std::unique_ptr<CLI::App> app = MakeParser(table, commands);
  if (arguments.empty()) {
    console.err << app->help();
    return static_cast<int>(ExitCode::kUsage);
  }
  std::vector<std::string> words = arguments;
  const std::vector<const CLI::App*> named = std::as_const(*app).get_subcommands(
      [&](const CLI::App* a) { return a->get_name() == arguments.front(); });
  if (!named.empty()) {
    absl::StatusOr<std::vector<std::string>> expanded =
        ExpandTemplate(*named.front(), {arguments.begin() + 1, arguments.end()});
    if (!expanded.ok()) {
      PrintError(console, expanded.status().message());
      return static_cast<int>(ExitCode::kUsage);
    }
    words = *std::move(expanded);
    words.insert(words.begin(), arguments.front());
  }
  try {
    // CLI11 takes them from the end.
    app->parse(std::vector<std::string>(words.rbegin(), words.rend()));
  } catch (const CLI::CallForHelp&) {
    console.out << app->help();  // Of the command that was named, if one was.
    return static_cast<int>(ExitCode::kSuccess);
  } catch (const CLI::CallForVersion& version) {
    console.out << version.what() << "\n";
    return static_cast<int>(ExitCode::kSuccess);
  } catch (const CLI::ParseError& error) {
    PrintError(console, absl::StrCat(error.what(), " (see ", HelpHint(*app), ")"));
    return static_cast<int>(ExitCode::kUsage);
  }

  const CLI::App* chosen = app->get_subcommands().front();
  const auto entry = std::find_if(table.begin(), table.end(),
                                  [&](const CommandEntry& e) { return e.name == chosen->get_name(); });
  Command& command = *commands[static_cast<size_t>(entry - table.begin())];
  if (const absl::Status usage = command.Check(); !usage.ok()) {
    PrintError(console, absl::StrCat(usage.message(), " (see ", HelpHint(*app), ")"));
    return static_cast<int>(ExitCode::kUsage);
  }
  absl::StatusOr<ExitCode> code = command.Run(console);
  console.out << std::flush;
  if (code.ok() && !console.out) code = absl::DataLossError("standard output could not be written");
  if (!code.ok()) {
    PrintError(console, code.status().message());
    return static_cast<int>(ExitCode::kFailed);
  }
  return static_cast<int>(*code);
}

CLI::Option* AddValue(CLI::App& app, const std::string& names, const std::string& value_name,
                      const std::string& default_text, const std::string& description,
                      std::function<absl::Status(const std::string&)> read) {
  // The longest name is the one to speak of: "-o,--output" is "--output".
  const size_t comma = names.rfind(',');
  const std::string name = comma == std::string::npos ? names : names.substr(comma + 1);
  const bool positional = name.front() != '-';
  CLI::Option* option = app.add_option_function<std::string>(
      names,
      [name, read = std::move(read)](const std::string& text) {
        const absl::Status status = read(text);
        if (!status.ok()) {
          throw CLI::ValidationError(absl::StrCat(name, " '", text, "': ", std::string(status.message())));
        }
      },
      description);
  std::string text = positional ? "" : value_name;
  if (!default_text.empty()) absl::StrAppend(&text, " [", default_text, "]");
  option->option_text(text.empty() ? " " : text);
  return option;
}

void AddExamples(CLI::App& app, const std::vector<std::string>& examples, const std::string& closing_words) {
  std::string text = examples.size() == 1 ? "Example:" : "Examples:";
  for (const std::string& example : examples) absl::StrAppend(&text, "\n  ", example);
  if (!closing_words.empty()) absl::StrAppend(&text, "\n\n", closing_words);
  app.footer(text);
}

}  // namespace shutterline::client
