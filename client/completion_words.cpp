#include "client/completion_words.h"

#include <absl/strings/ascii.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_replace.h>
#include <absl/strings/str_split.h>
#include <absl/strings/string_view.h>

#include <algorithm>

namespace shutterline::client {
namespace {

/// A value to be typed as it is, like "2h2v", and not the name of one, like "NAME" or "T:A,...".
bool IsLiteral(absl::string_view word) {
  return !word.empty() && std::all_of(word.begin(), word.end(), [](char c) {
    return absl::ascii_islower(c) || absl::ascii_isdigit(c) || c == '-';
  });
}

bool NamesFile(absl::string_view value) {
  for (const absl::string_view word : {"FILE", "DIR", "PATH", "SCENE"}) {
    if (value == word) return true;
  }
  // As in "OUT.png", but not "T:A,...".
  const size_t dot = value.find('.');
  return dot != 0 && dot != value.npos && dot + 1 < value.size() && absl::ascii_islower(value[dot + 1]);
}

CompletionOption Describe(const CLI::Option& option) {
  CompletionOption described;
  for (const std::string& name : option.get_snames()) described.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) described.names.push_back("--" + name);
  described.description = absl::StrReplaceAll(option.get_description(), {{"\n", " "}});
  std::string listed;
  if (option.get_positional()) {
    described.value = option.get_name(true);
    listed = option.get_option_text();
    // `compare` calls its two pictures A and B.
    described.file = described.value.size() == 1 || NamesFile(described.value);
  } else if (option.get_items_expected_max() > 0) {
    // "WxH [1024x768]": the name of the value, and its default.
    const std::string text =
        option.get_option_text().empty() ? option.get_type_name() : option.get_option_text();
    described.value = std::string(absl::StripAsciiWhitespace(text.substr(0, text.find(" ["))));
    if (described.value.empty()) described.value = "VALUE";
    described.file = NamesFile(described.value);
    listed = described.value;
  } else {
    return described;
  }
  for (const absl::string_view word : absl::StrSplit(listed, '|')) {
    if (IsLiteral(word)) described.words.emplace_back(word);
  }
  return described;
}

CompletionCommand Describe(const CLI::App& app) {
  CompletionCommand command{app.get_name(), app.get_description(), {}, {}};
  for (const CLI::Option* option : app.get_options()) {
    (option->get_positional() ? command.arguments : command.options).push_back(Describe(*option));
  }
  return command;
}

}  // namespace

std::vector<CompletionCommand> CompletionCommands(const CLI::App& app) {
  std::vector<CompletionCommand> commands = {Describe(app)};
  for (const CLI::App* sub : app.get_subcommands([](const CLI::App*) { return true; })) {
    commands.push_back(Describe(*sub));
  }
  return commands;
}

}  // namespace shutterline::client
