#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "client/commands.h"
#include "client/completion_script.h"
#include "client/completion_words.h"
#include "tests/client/temp_folder.h"
#include "tests/support/process.h"

namespace shutterline::client::completion_test {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using Lines = std::vector<std::string>;

class Completion : public testing::Test {
 protected:
  Completion() : app_(MakeParser(CommandTable(), commands_)) {}

  std::string Write(const std::string& name, const std::string& text) {
    folder_.Write(name, text);
    return folder_.File(name);
  }

  /// Runs a script in a shell; its output by lines. A failure of it fails the test.
  Lines Run(const std::string& shell, const std::string& script) {
    const auto process = Process::Start({shell, Write("script", script)}, folder_.File("shell"));
    EXPECT_EQ(process->Wait(), 0) << process->Errors() << script;
    EXPECT_EQ(process->Errors(), "");
    Lines lines;
    std::istringstream out(process->Output());
    for (std::string line; std::getline(out, line);) lines.push_back(line);
    return lines;
  }

  /// What bash offers for the last of `words`, after "shutterline".
  Lines Offered(const Lines& words) {
    std::string script = BashCompletion(*app_) + "COMP_WORDS=(shutterline";
    for (const std::string& word : words) script += " '" + word + "'";
    script += "); COMP_CWORD=" + std::to_string(words.size()) +
              "; _shutterline; ((${#COMPREPLY[@]})) && printf '%s\\n' \"${COMPREPLY[@]}\"; exit 0\n";
    return Run("/bin/bash", script);
  }

  std::vector<std::unique_ptr<Command>> commands_;
  std::unique_ptr<CLI::App> app_;
  TempFolder folder_;
};

TEST_F(Completion, BashOffersEveryCommandAndEveryOption) {
  Lines names;
  for (const CommandEntry& entry : CommandTable()) names.push_back(entry.name);
  EXPECT_EQ(Offered({""}), names);
  EXPECT_THAT(Offered({"--"}), testing::UnorderedElementsAre("--help", "--version"));
  for (const CommandEntry& entry : CommandTable()) {
    const Lines offered = Offered({entry.name, "-"});
    size_t options = 0;
    for (const CLI::Option* option : app_->get_subcommand(entry.name)->get_options()) {
      if (option->get_positional()) continue;
      for (const std::string& name : option->get_snames()) {
        EXPECT_THAT(offered, Contains("-" + name)) << entry.name;
        ++options;
      }
      for (const std::string& name : option->get_lnames()) {
        EXPECT_THAT(offered, Contains("--" + name)) << entry.name;
        ++options;
      }
    }
    EXPECT_EQ(offered.size(), options) << entry.name;
  }
}

TEST_F(Completion, BashOffersValuesAndFilesWhereTheyFit) {
  EXPECT_THAT(Offered({"render", "--resolver", ""}), ElementsAre("slice", "paper"));
  EXPECT_THAT(Offered({"submit", "a.glb", "--compression", "z"}), ElementsAre("zip"));
  EXPECT_THAT(Offered({"render", "--pattern", "r"}), ElementsAre("rgls"));
  EXPECT_THAT(Offered({"completion", ""}), ElementsAre("bash", "zsh"));
  EXPECT_THAT(Offered({"inf"}), ElementsAre("info"));
  EXPECT_THAT(Offered({"nonsense", ""}), IsEmpty());
  // A size and a job are anybody's guess, but no file.
  const std::string file = Write("a scene.glb", "");
  const std::string start = file.substr(0, file.size() - 6);
  EXPECT_THAT(Offered({"render", "--size", start}), IsEmpty());
  EXPECT_THAT(Offered({"status", start}), IsEmpty());
  for (const Lines& words : {Lines{"render", start}, Lines{"render", "--png", start}, Lines{"compare", start},
                             Lines{"render", "-o", start}, Lines{"render", "--environment", start}}) {
    EXPECT_THAT(Offered(words), ElementsAre(file)) << words[1];
  }
}

TEST_F(Completion, ZshIsToldOfEveryCommandAndEveryOption) {
  const std::string script = ZshCompletion(*app_);
  for (const CompletionCommand& command : CompletionCommands(*app_)) {
    if (!command.name.empty() && command.name != "shutterline") {
      EXPECT_THAT(script, HasSubstr("'" + command.name + ":"));
    }
    for (const CompletionOption& option : command.options) {
      for (const std::string& name : option.names) EXPECT_THAT(script, HasSubstr(name)) << command.name;
    }
  }
  if (access("/bin/zsh", X_OK) != 0) GTEST_SKIP() << "zsh is not installed: nobody has parsed the function";
  EXPECT_THAT(Run("/bin/zsh", "setopt no_exec\n" + script), IsEmpty());
}

TEST_F(Completion, HostileTextStaysText) {
  CLI::App app("hostile", "shutterline");
  CLI::App* sub = app.add_subcommand("cmd", "it's `touch x` $(touch x): [y]");
  std::string value;
  sub->add_option("--opt", value, "it's \"$(touch x)\" [a:b] \\")->option_text("on|o'ff|$(touch x)");
  const std::string canary = folder_.File("x");
  Run("/bin/bash",
      BashCompletion(app) + "COMP_WORDS=(shutterline cmd --opt ''); COMP_CWORD=3; _shutterline\n");
  EXPECT_FALSE(std::filesystem::exists(canary));
  EXPECT_FALSE(std::filesystem::exists("x"));
}

TEST(CompletionWords, OnlyLiteralValuesAreOffered) {
  std::vector<std::unique_ptr<Command>> commands;
  const auto app = MakeParser(CommandTable(), commands);
  bool curve = false, filter = false, output = false;
  for (const CompletionCommand& command : CompletionCommands(*app)) {
    for (const CompletionOption& option : command.options) {
      if (option.names.back() == "--shutter-curve") {
        curve = true;
        EXPECT_THAT(option.words, ElementsAre("box", "triangle", "trapezoid", "decay"));
      }
      if (option.names.back() == "--filter") {
        filter = true;
        EXPECT_THAT(option.words, ElementsAre("box", "triangle", "gaussian", "blackman-harris"));
      }
      if (option.names.back() == "--output") {
        output = true;
        EXPECT_TRUE(option.file) << option.value;
        EXPECT_THAT(option.names, ElementsAre("-o", "--output"));
      }
      EXPECT_THAT(option.description, Not(HasSubstr("\n")));
    }
  }
  EXPECT_TRUE(curve && filter && output);
}

}  // namespace
}  // namespace shutterline::client::completion_test
