#include <chrono>
#include <thread>

#include "rali/cli/commands/live.hpp"
#include "rali/cli/view/ask_vehicle.hpp"
#include "rali/cli/view/status_text.hpp"

namespace rali::cli {
namespace {

class StatusCommand final : public Command {
 public:
  [[nodiscard]] std::string name() const override { return "status"; }

  [[nodiscard]] std::string summary() const override { return "show a live fleet in the terminal"; }

  [[nodiscard]] std::vector<std::string> examples() const override {
    return {"rali status", "rali status http://10.77.0.2:8765 --watch"};
  }

  [[nodiscard]] std::string exit_codes() const override {
    return "0 done, 1 the anchor is lost or an error is reported, 2 refused, 4 no answer";
  }

  [[nodiscard]] Positional positional() override {
    return {"URL", "view of any vehicle (default http://127.0.0.1:8765)", &urls_, 0, 1, {}};
  }

  [[nodiscard]] std::vector<Option> options() override {
    return {{"--watch", "", "once a second, until Ctrl-C", &watch_, false, {}},
            {"--token",
             "TOKEN",
             "of a vehicle on another machine (or the variable RALI_TOKEN)",
             &token_,
             false,
             {}}};
  }

  [[nodiscard]] bool json() const override { return true; }

  [[nodiscard]] Result<int> run(Session& session) override {
    while (true) {
      const Result<int> code = once(session);
      if (!code || !watch_) return code;
      for (int i = 0; i < 10 && !stop_requested(); ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
      }
      if (stop_requested()) return code;
    }
  }

 private:
  [[nodiscard]] Result<int> once(Session& session) {
    const Result<std::string> state =
        ask_vehicle(urls_.empty() ? kViewAddress : urls_.front(), token_, "/state");
    if (!state) return tl::make_unexpected(state.error());
    const Result<FleetStatus> status = read_status(*state);
    if (!status) return tl::make_unexpected(status.error());
    if (session.options.json) {
      session.result(*state + '\n');
    } else {
      // On a terminal the text is overwritten; in a file the blocks are appended.
      if (watch_ && session.live()) session.result("\x1b[H\x1b[2J");
      session.result(status->text);
      if (watch_ && !session.live()) session.result("\n");
    }
    return status->alarm ? kExitBelowAsked : kExitDone;
  }

  std::vector<std::string> urls_;
  std::string token_;
  bool watch_ = false;
};

}  // namespace

std::unique_ptr<Command> make_status_command() { return std::make_unique<StatusCommand>(); }

}  // namespace rali::cli
