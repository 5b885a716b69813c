#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace shutterline::client {

/// A script that makes a shell complete `app`'s commands, options and, where an option's help lists them,
/// its values; file names where a value or an argument is a file. All of it is read from the parser, so that
/// the script knows what the program knows.
std::string BashCompletion(
    const CLI::App& app);                        ///< For bash 4.4 and later, with or without bash-completion.
std::string ZshCompletion(const CLI::App& app);  ///< A function for zsh's `fpath`, also to be sourced.

}  // namespace shutterline::client
