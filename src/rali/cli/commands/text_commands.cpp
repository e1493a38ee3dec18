#include "rali/cli/commands/commands.hpp"
#include "rali/cli/completion.hpp"
#include "rali/cli/help.hpp"
#include "rali/cli/man_page.hpp"
#include "rali/config/load_fleet.hpp"

namespace rali::cli {
namespace {

class CompletionCommand final : public Command {
 public:
  [[nodiscard]] std::string name() const override { return "completion"; }

  [[nodiscard]] std::string summary() const override {
    return "print the completion script of a shell";
  }

  [[nodiscard]] std::vector<std::string> examples() const override {
    return {"source <(rali completion bash)",
            "rali completion fish > ~/.config/fish/completions/rali.fish"};
  }

  [[nodiscard]] std::string exit_codes() const override { return "0 done, 2 no such shell"; }

  [[nodiscard]] Positional positional() override {
    return {"SHELL", "bash, zsh or fish", &shells_, 1, 1, {"bash", "zsh", "fish"}};
  }

  [[nodiscard]] std::vector<Option> options() override { return {}; }

  [[nodiscard]] Result<int> run(Session& session) override {
    session.result(completion_script(shells_.front(), all_commands()));
    return kExitDone;
  }

 private:
  std::vector<std::string> shells_;
};

/// Prints a page that is made from the program's own tables.
class PageCommand final : public Command {
 public:
  PageCommand(std::string name, std::string summary, std::string (*page)())
      : name_(std::move(name)), summary_(std::move(summary)), page_(page) {}

  [[nodiscard]] std::string name() const override { return name_; }

  [[nodiscard]] std::string summary() const override { return summary_; }

  [[nodiscard]] std::vector<std::string> examples() const override {
    return {"rali " + name_, "rali " + name_ + " > page.md"};
  }

  [[nodiscard]] std::string exit_codes() const override { return "0 done"; }

  [[nodiscard]] Positional positional() override { return {"", "", nullptr, 0, 0, {}}; }

  [[nodiscard]] std::vector<Option> options() override { return {}; }

  [[nodiscard]] bool hidden() const override { return true; }

  [[nodiscard]] Result<int> run(Session& session) override {
    session.result(page_());
    return kExitDone;
  }

 private:
  std::string name_, summary_;
  std::string (*page_)();
};

class HelpSettingsCommand final : public Command {
 public:
  [[nodiscard]] std::string name() const override { return "help-settings"; }

  [[nodiscard]] std::string summary() const override {
    return "print the public settings by symptom";
  }

  [[nodiscard]] std::vector<std::string> examples() const override {
    return {"rali help-settings", "rali help-settings --all"};
  }

  [[nodiscard]] std::string exit_codes() const override { return "0 done"; }

  [[nodiscard]] Positional positional() override { return {"", "", nullptr, 0, 0, {}}; }

  [[nodiscard]] std::vector<Option> options() override {
    return {{"--all", "", "all settings, the unstable ones too", &all_, false, {}}};
  }

  [[nodiscard]] bool hidden() const override { return true; }

  [[nodiscard]] Result<int> run(Session& session) override {
    session.result(config::settings_manual(all_ ? config::SettingsShown::kAll
                                                : config::SettingsShown::kPublic));
    return kExitDone;
  }

 private:
  bool all_ = false;
};

std::string cli_page() { return cli_manual(all_commands()); }

std::string manual_page() { return man_page(all_commands()); }

}  // namespace

std::unique_ptr<Command> make_completion_command() { return std::make_unique<CompletionCommand>(); }

std::unique_ptr<Command> make_help_settings_command() {
  return std::make_unique<HelpSettingsCommand>();
}

std::unique_ptr<Command> make_help_man_command() {
  return std::make_unique<PageCommand>("help-man", "print the manual page rali(1)", manual_page);
}

std::unique_ptr<Command> make_help_cli_command() {
  return std::make_unique<PageCommand>("help-cli", "print docs/reference/cli.md", cli_page);
}

}  // namespace rali::cli
