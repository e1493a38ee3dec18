#include "rali/cli/commands/info.hpp"

#include "rali/inspect/info.hpp"

namespace rali::cli {
namespace {

class InfoCommand final : public Command {
 public:
  [[nodiscard]] std::string name() const override { return "info"; }

  [[nodiscard]] std::string summary() const override { return "what is in this file"; }

  [[nodiscard]] std::vector<std::string> examples() const override {
    return {"rali info run1.bag", "rali info scans/ --json"};
  }

  [[nodiscard]] std::string exit_codes() const override {
    return "0 done, 2 not readable, 3 the file is damaged";
  }

  [[nodiscard]] bool json() const override { return true; }

  [[nodiscard]] Positional positional() override {
    return {"FILE", "recording, folder of scans, or point cloud", &files_, 1, 1, {}};
  }

  [[nodiscard]] std::vector<Option> options() override { return {}; }

  [[nodiscard]] Result<int> run(Session& session) override {
    const auto info = inspect::look_into(files_.front());
    if (!info) return tl::make_unexpected(info.error());
    session.result(session.options.json ? inspect::info_json(*info) : inspect::info_text(*info));
    return info->damaged ? kExitGaps : kExitDone;
  }

 private:
  std::vector<std::string> files_;
};

}  // namespace

std::unique_ptr<Command> make_info_command() { return std::make_unique<InfoCommand>(); }

}  // namespace rali::cli
