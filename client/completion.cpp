#include "client/completion_script.h"

#include <memory>
#include <string>
#include <vector>

#include "client/commands.h"

namespace shutterline::client {
namespace {

class CompletionCommandLine : public Command {
 public:
  void Declare(CLI::App& app) override {
    AddValue(app, "SHELL", "", "", "The shell: bash or zsh",
             [this](const std::string& text) {
               if (text != "bash" && text != "zsh") return absl::InvalidArgumentError("must be bash or zsh");
               shell_ = text;
               return absl::OkStatus();
             })
        ->required()
        ->option_text("bash|zsh");
    AddExamples(app, {"shutterline completion bash", "shutterline completion zsh"},
                "bash: source <(shutterline completion bash), in ~/.bashrc\n"
                "zsh:  source <(shutterline completion zsh), in ~/.zshrc after compinit\n"
                "An installed Shutterline has both in place already.");
  }

  absl::StatusOr<ExitCode> Run(Console& console) override {
    std::vector<std::unique_ptr<Command>> commands;
    const std::unique_ptr<CLI::App> app = MakeParser(CommandTable(), commands);
    console.out << (shell_ == "zsh" ? ZshCompletion(*app) : BashCompletion(*app));
    return ExitCode::kSuccess;
  }

 private:
  std::string shell_;
};

}  // namespace

std::unique_ptr<Command> MakeCompletionCommand() {
  return std::make_unique<CompletionCommandLine>();
}

}  // namespace shutterline::client
