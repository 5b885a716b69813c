#include "client/template_file.h"

#include <absl/strings/ascii.h>
#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>

#include <algorithm>
#include <fstream>
#include <optional>
#include <set>

#include "common/base/status_macros.h"

namespace shutterline::client {
namespace {

constexpr size_t kMaxTemplateBytes = 64 << 10;

/// Whether one of the words sets the option: "--size=64x64", "--size" or, where it has a short name, "-o…".
bool Gives(const std::vector<std::string>& words, const CLI::Option& option) {
  return std::any_of(words.begin(), words.end(), [&](const std::string& word) {
    for (const std::string& name : option.get_lnames()) {
      if (word == absl::StrCat("--", name) || absl::StartsWith(word, absl::StrCat("--", name, "=")))
        return true;
    }
    return std::any_of(option.get_snames().begin(), option.get_snames().end(), [&](const std::string& name) {
      return absl::StartsWith(word, absl::StrCat("-", name));
    });
  });
}

/// The template that the words name; the last counts, as for no other option: the parser refuses a second
/// one.
std::optional<std::string> TemplateNamed(const std::vector<std::string>& words) {
  std::optional<std::string> path;
  for (size_t i = 0; i < words.size(); ++i) {
    if (words[i] == kTemplateOption && i + 1 < words.size()) path = words[i + 1];
    const std::string with_value = absl::StrCat(kTemplateOption, "=");
    if (absl::StartsWith(words[i], with_value)) path = words[i].substr(with_value.size());
  }
  return path;
}

struct Line {
  int number = 0;
  std::string name, value;
};

absl::StatusOr<std::string> ReadText(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::string text(kMaxTemplateBytes + 1, '\0');
  in.read(text.data(), std::streamsize(text.size()));
  // A folder opens and cannot be read.
  if (!in && !in.eof()) return absl::NotFoundError("cannot be read");
  text.resize(size_t(in.gcount()));
  if (text.size() > kMaxTemplateBytes) {
    return absl::InvalidArgumentError(absl::StrCat("has more than ", kMaxTemplateBytes, " bytes"));
  }
  if (text.find('\0') != std::string::npos) return absl::InvalidArgumentError("is no text");
  return text;
}

/// Not the configuration reader of the library of options: that one takes the numbers in "fox.####.exr" for a
/// comment, and passes over lines that it does not understand.
absl::StatusOr<std::vector<Line>> ParseLines(absl::string_view text) {
  std::vector<Line> lines;
  int number = 0;
  for (absl::string_view line : absl::StrSplit(text, '\n')) {
    ++number;
    line = absl::StripAsciiWhitespace(line);
    if (line.empty() || line.front() == '#') continue;
    const size_t equals = line.find('=');
    const absl::string_view name = absl::StripAsciiWhitespace(line.substr(0, equals));
    if (equals == absl::string_view::npos || name.empty()) {
      return absl::InvalidArgumentError(absl::StrCat("line ", number, ": must be NAME = VALUE"));
    }
    absl::string_view value = absl::StripAsciiWhitespace(line.substr(equals + 1));
    if (value.size() > 1 && value.front() == '"' && value.back() == '"')
      value = value.substr(1, value.size() - 2);
    lines.push_back({number, std::string(name), std::string(value)});
  }
  return lines;
}

/// The word that says what the line says; none where it says no ("float = false").
absl::StatusOr<std::optional<std::string>> WordOf(const Line& line, const CLI::Option& option) {
  if (option.get_items_expected_max() > 0) return absl::StrCat("--", line.name, "=", line.value);
  if (line.value == "true") return absl::StrCat("--", line.name);
  if (line.value == "false") return std::nullopt;
  return absl::InvalidArgumentError(absl::StrCat("line ", line.number, ": '", line.name, "' is '", line.value,
                                                 "', but must be true or false"));
}

absl::StatusOr<std::vector<std::string>> WordsOf(const std::vector<Line>& lines, const CLI::App& command,
                                                 const std::vector<std::string>& given) {
  std::vector<std::string> words;
  std::set<std::string> seen;
  for (const Line& line : lines) {
    const std::string name = absl::StrCat("--", line.name);
    const CLI::Option* option = command.get_option_no_throw(name);
    if (option == nullptr || name == kTemplateOption || name == "--help") {
      return absl::InvalidArgumentError(absl::StrCat("line ", line.number, ": '", line.name,
                                                     "' is no option that a template for '",
                                                     command.get_name(), "' may hold"));
    }
    if (!seen.insert(line.name).second) {
      return absl::InvalidArgumentError(
          absl::StrCat("line ", line.number, ": '", line.name, "' is there twice"));
    }
    absl::StatusOr<std::optional<std::string>> word = WordOf(line, *option);
    if (!word.ok()) return word.status();
    const std::set<CLI::Option*> excluded = option->get_excludes();
    const bool overruled =
        Gives(given, *option) ||
        std::any_of(excluded.begin(), excluded.end(), [&](auto* other) { return Gives(given, *other); });
    if (*word && !overruled) words.push_back(**std::move(word));
  }
  return words;
}

}  // namespace

absl::StatusOr<std::vector<std::string>> ExpandTemplate(const CLI::App& command,
                                                        const std::vector<std::string>& words) {
  const std::optional<std::string> path = TemplateNamed(words);
  if (!path) return words;
  const auto expand = [&]() -> absl::StatusOr<std::vector<std::string>> {
    SL_ASSIGN_OR_RETURN(const std::string text, ReadText(*path));
    SL_ASSIGN_OR_RETURN(const std::vector<Line> lines, ParseLines(text));
    return WordsOf(lines, command, words);
  };
  absl::StatusOr<std::vector<std::string>> expanded = expand();
  if (!expanded.ok()) {
    return absl::Status(expanded.status().code(),
                        absl::StrCat(kTemplateOption, " '", *path, "': ", expanded.status().message()));
  }
  expanded->insert(expanded->end(), words.begin(), words.end());
  return expanded;
}

}  // namespace shutterline::client
