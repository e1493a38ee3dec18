#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "rali/cli/commands/live.hpp"
#include "rali/cli/view/ask_vehicle.hpp"

namespace rali::cli {
namespace {

tl::unexpected<Error> bad_words(std::string what, std::string remedy) {
  return fail(ErrorCode::kUsage, "rali operator", std::move(what), std::move(remedy));
}

class OperatorCommand final : public Command {
 public:
  [[nodiscard]] std::string name() const override { return "operator"; }

  [[nodiscard]] std::string summary() const override {
    return "order a live fleet: end-round, assume-lost VEHICLE, finish";
  }

  [[nodiscard]] std::vector<std::string> examples() const override {
    return {"rali operator end-round", "rali operator assume-lost v2 http://10.77.0.1:8765"};
  }

  [[nodiscard]] std::string exit_codes() const override {
    return "0 the vehicle has taken the order, 2 refused, 4 no answer";
  }

  [[nodiscard]] Positional positional() override {
    return {"ORDER",
            "end-round, assume-lost VEHICLE or finish; then the view of any vehicle "
            "(default http://127.0.0.1:8765)",
            &words_,
            1,
            3,
            {}};
  }

  [[nodiscard]] std::vector<Option> options() override {
    return {{"--token",
             "TOKEN",
             "of a vehicle on another machine (or the variable RALI_TOKEN)",
             &token_,
             false,
             {}}};
  }

  [[nodiscard]] Result<int> run(Session& session) override {
    if (Status status = read_words(); !status) return tl::make_unexpected(status.error());
    nlohmann::json order = {{"command", order_}};
    if (!vehicle_.empty()) order["vehicle"] = vehicle_;
    const Result<std::string> taken =
        ask_vehicle(url_, token_, "/operator",
                    order.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
    if (!taken) return tl::make_unexpected(taken.error());
    session.note(
        fmt::format("{} has taken the order. `rali status` shows what it does.", printable(url_)));
    return kExitDone;
  }

 private:
  [[nodiscard]] Status read_words() {
    order_ = words_.front();
    const bool names = order_ == "assume-lost";
    if (!names && order_ != "end-round" && order_ != "finish") {
      return bad_words(fmt::format("there is no order '{}'", printable(order_.substr(0, 40))),
                       "Orders are end-round, assume-lost VEHICLE and finish.");
    }
    std::size_t next = 1;
    if (names) {
      if (words_.size() < 2 || words_[1].find("://") != std::string::npos) {
        return bad_words("assume-lost needs the vehicle that is lost",
                         "Write: rali operator assume-lost v2");
      }
      vehicle_ = words_[next++];
    }
    if (next < words_.size()) url_ = words_[next++];
    if (next < words_.size()) {
      return bad_words(fmt::format("'{}' is too much", printable(words_[next].substr(0, 40))),
                       "Write: rali operator " + order_ + (names ? " v2" : "") + " [URL]");
    }
    return {};
  }

  std::vector<std::string> words_;
  std::string order_, vehicle_, url_ = kViewAddress, token_;
};

}  // namespace

std::unique_ptr<Command> make_operator_command() { return std::make_unique<OperatorCommand>(); }

}  // namespace rali::cli
