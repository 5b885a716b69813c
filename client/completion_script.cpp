#include "client/completion_script.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>
#include <absl/strings/str_replace.h>

#include <vector>

#include "client/completion_words.h"

namespace shutterline::client {
namespace {

/// "-o --output --size …"
std::string NamesOf(const std::vector<CompletionOption>& options) {
  std::vector<std::string> names;
  for (const CompletionOption& option : options) {
    names.insert(names.end(), option.names.begin(), option.names.end());
  }
  return absl::StrJoin(names, " ");
}

/// `text` in single quotes, as both shells read them.
std::string Quoted(absl::string_view text) {
  return absl::StrCat("'", absl::StrReplaceAll(text, {{"'", "'\\''"}}), "'");
}

/// The line of bash that completes the value of `option`; empty where anything may follow.
std::string BashValue(const CompletionOption& option) {
  if (option.file) return "_shutterline_files; return";
  if (option.words.empty()) return "return";
  return absl::StrCat("_shutterline_words ", Quoted(absl::StrJoin(option.words, " ")), "; return");
}

/// In zsh's _arguments, text may not hold ':' or brackets unescaped.
std::string ZshText(absl::string_view text) {
  return absl::StrReplaceAll(text, {{"\\", "\\\\"}, {":", "\\:"}, {"[", "\\["}, {"]", "\\]"}});
}

std::string ZshAction(const CompletionOption& option) {
  if (option.file) return "_files";
  return option.words.empty() ? "" : absl::StrCat("(", absl::StrJoin(option.words, " "), ")");
}

/// "'(-o --output)'{-o,--output}'[Where frames go]:PATH:_files'"
std::string ZshOption(const CompletionOption& option) {
  std::string spec;
  if (option.names.size() == 1) {
    spec = option.names[0];
  } else {
    spec = absl::StrCat("'(", absl::StrJoin(option.names, " "), ")'{", absl::StrJoin(option.names, ","), "}");
  }
  std::string rest = absl::StrCat("[", ZshText(option.description), "]");
  if (!option.value.empty()) absl::StrAppend(&rest, ":", ZshText(option.value), ":", ZshAction(option));
  return absl::StrCat(spec, Quoted(rest));
}

}  // namespace

std::string BashCompletion(const CLI::App& app) {
  const std::vector<CompletionCommand> commands = CompletionCommands(app);
  std::vector<std::string> names;
  for (size_t i = 1; i < commands.size(); ++i) names.push_back(commands[i].name);

  std::string values, words;
  for (size_t i = 1; i < commands.size(); ++i) {
    const CompletionCommand& command = commands[i];
    for (const CompletionOption& option : command.options) {
      if (option.value.empty()) continue;
      std::vector<std::string> patterns;
      for (const std::string& name : option.names) {
        patterns.push_back(absl::StrCat(command.name, ":", name));
      }
      absl::StrAppend(&values, "    ", absl::StrJoin(patterns, " | "), ") ", BashValue(option), " ;;\n");
    }
    std::string arguments = ":";  // Bash's word for doing nothing.
    for (const CompletionOption& argument : command.arguments) {
      if (argument.file) arguments = "_shutterline_files";
      if (!argument.words.empty()) {
        arguments = absl::StrCat("_shutterline_words ", Quoted(absl::StrJoin(argument.words, " ")));
      }
    }
    absl::StrAppend(&words, "    ", command.name, ") options=", Quoted(NamesOf(command.options)),
                    " arguments=", Quoted(arguments), " ;;\n");
  }
  return absl::StrCat(R"(# bash completion for shutterline; made by `shutterline completion bash`.
_shutterline_words() { mapfile -t COMPREPLY < <(compgen -W "$1" -- "${COMP_WORDS[COMP_CWORD]}"); }
_shutterline_files() {
  compopt -o filenames 2>/dev/null
  mapfile -t COMPREPLY < <(compgen -f -- "${COMP_WORDS[COMP_CWORD]}")
}
_shutterline() {
  local command="" options arguments i
  COMPREPLY=()
  for ((i = 1; i < COMP_CWORD; i++)); do
    case ${COMP_WORDS[i]} in
      -*) ;;
      *) command=${COMP_WORDS[i]}; break ;;
    esac
  done
  # The value of an option.
  case $command:${COMP_WORDS[COMP_CWORD-1]} in
)",
                      values, R"(  esac
  case $command in
    "") options=)",
                      Quoted(NamesOf(commands[0].options)), R"( arguments=)",
                      Quoted(absl::StrCat("_shutterline_words \"", absl::StrJoin(names, " "), "\"")), R"( ;;
)",
                      words, R"(    *) return ;;
  esac
  if [[ ${COMP_WORDS[COMP_CWORD]} == -* ]]; then _shutterline_words "$options"; else eval "$arguments"; fi
}
complete -F _shutterline shutterline
)");
}

std::string ZshCompletion(const CLI::App& app) {
  const std::vector<CompletionCommand> commands = CompletionCommands(app);
  std::string list, cases;
  for (size_t i = 1; i < commands.size(); ++i) {
    const CompletionCommand& command = commands[i];
    absl::StrAppend(&list, "    ", Quoted(absl::StrCat(command.name, ":", command.description)), "\n");
    absl::StrAppend(&cases, "    ", command.name, ")\n      _arguments -s");
    for (const CompletionOption& option : command.options) {
      absl::StrAppend(&cases, " \\\n        ", ZshOption(option));
    }
    for (const CompletionOption& argument : command.arguments) {
      absl::StrAppend(&cases, " \\\n        ",
                      Quoted(absl::StrCat(":", ZshText(argument.value), ":", ZshAction(argument))));
    }
    absl::StrAppend(&cases, "\n      ;;\n");
  }
  std::string own;
  for (const CompletionOption& option : commands[0].options) {
    absl::StrAppend(&own, " \\\n    ", ZshOption(option));
  }
  return absl::StrCat(R"(#compdef shutterline
# zsh completion for shutterline; made by `shutterline completion zsh`.
_shutterline() {
  local context state state_descr line
  typeset -A opt_args
  local -a commands=(
)",
                      list, R"(  )
  _arguments -C)",
                      own, R"( \
    '1:command:->command' '*::argument:->argument' && return
  case $state in
  command) _describe command commands ;;
  argument)
    case $words[1] in
)",
                      cases, R"(    esac
    ;;
  esac
}
if [[ ${funcstack[1]} == _shutterline ]]; then _shutterline "$@"; else compdef _shutterline shutterline; fi
)");
}

}  // namespace shutterline::client
