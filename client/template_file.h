#pragma once

#include <absl/status/statusor.h>

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace shutterline::client {

/// Option that names a template.
inline constexpr char kTemplateOption[] = "--template";

/// A template is a small text file of options that many jobs share, one a line, as in
///
///     # dailies.conf
///     size = 1920x1080
///     aov = depth,normal
///     float = true
///
/// Lines that begin with # and empty ones say nothing; a value may stand in double quotes.
///
/// `words` are a command's arguments without its name. Where they name a template, its options come back in
/// front of them, less those that `words` give themselves or exclude: the command line has the last word.
/// Where they name none, they come back as they are. `command` has its options declared.
///
/// Errors name the file and the option: NOT_FOUND where it cannot be read, INVALID_ARGUMENT where it names
/// what is no option of the command, or one twice. What the values are worth is judged by whoever parses the
/// words.
absl::StatusOr<std::vector<std::string>> ExpandTemplate(const CLI::App& command,
                                                        const std::vector<std::string>& words);

}  // namespace shutterline::client
