#include <chrono>
#include <cstdio>
#include <thread>

#include <fmt/format.h>

#include "rali/cli/commands/live.hpp"
#include "rali/cli/commands/report.hpp"
#include "rali/cli/view/ask_vehicle.hpp"
#include "rali/cli/view/point_times.hpp"
#include "rali/cli/view/results_view.hpp"
#include "rali/report/read_run.hpp"

namespace rali::cli {
namespace {

class ViewCommand final : public Command {
 public:
  [[nodiscard]] std::string name() const override { return "view"; }

  [[nodiscard]] std::string summary() const override {
    return "open results in the browser: map in 3-D, trajectories, timeline";
  }

  [[nodiscard]] std::vector<std::string> examples() const override {
    return {"rali view out", "rali view http://10.77.0.1:8765"};
  }

  [[nodiscard]] std::string exit_codes() const override {
    return "0 stopped by Ctrl-C or by --check, 2 no results, 4 the port is in use, no answer";
  }

  [[nodiscard]] Positional positional() override {
    return {"OUT", "output folder of rali map, or the address of a live view", &inputs_, 1, 1, {}};
  }

  [[nodiscard]] std::vector<Option> options() override {
    return {
        {"--port", "N", "of the page; 0: any free one", &port_, false, {}},
        {"--bind", "ADDRESS", "0.0.0.0: for other machines too, with --token", &bind_, true, {}},
        {"--token",
         "TOKEN",
         "asked of other machines; of a live view: its own",
         &token_,
         false,
         {}},
        {"--check", "", "print the address and end: does the page open?", &check_, true, {}}};
  }

  [[nodiscard]] Result<int> run(Session& session) override {
    const std::string& input = inputs_.front();
    return input.find("://") != std::string::npos ? show_live(input, session)
                                                  : show_results(input, session);
  }

 private:
  /// The page is served by the vehicle itself.
  [[nodiscard]] Result<int> show_live(const std::string& url, Session& session) const {
    const Result<std::string> state = ask_vehicle(url, token_, "/state");
    if (!state) return tl::make_unexpected(state.error());
    session.result(printable(url) + '\n');
    session.note("The vehicle answers. Open this address in a browser.");
    return kExitDone;
  }

  [[nodiscard]] Result<int> show_results(const std::string& folder, Session& session) {
    warn_of_old_names(inputs_, session);
    const Result<report::RunData> run = report::read_run(folder);
    if (!run) return tl::make_unexpected(run.error());
    for (const std::string& file : run->unreadable) session.warning(printable(file) + '.');
    if (port_ < 0 || port_ > 65535) {
      return fail(ErrorCode::kUsage, "rali view", "--port is no number from 0 to 65535");
    }
    view::ViewOptions options;
    options.bind = bind_;
    options.port = static_cast<std::uint16_t>(port_);
    options.token = token_;
    const Result<std::unique_ptr<view::ViewServer>> server = view::start_view_server(options);
    if (!server) return tl::make_unexpected(server.error());
    publish_results(*run, first_seen_s(folder, *run), **server);
    const std::string host = bind_ == "0.0.0.0" ? "127.0.0.1" : bind_;
    session.result(fmt::format("http://{}:{}{}\n", host, (*server)->port(),
                               token_.empty() ? "" : "/?token=" + token_));
    std::fflush(stdout);
    if (check_) return kExitDone;
    session.note("Open this address in a browser. Ctrl-C ends.");
    while (!stop_requested()) std::this_thread::sleep_for(std::chrono::milliseconds(100));
    return kExitDone;
  }

  std::vector<std::string> inputs_;
  std::string bind_ = "127.0.0.1", token_;
  int port_ = 8765;
  bool check_ = false;
};

}  // namespace

std::unique_ptr<Command> make_view_command() { return std::make_unique<ViewCommand>(); }

}  // namespace rali::cli
