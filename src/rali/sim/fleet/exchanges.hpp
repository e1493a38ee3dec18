#pragma once

#include <cstdint>
#include <vector>

namespace rali::sim {

/// Schedule of exchanges: every pair of antennas, or of vehicles in both directions, once per
/// period, evenly spread over it as for radios that share a channel.
class ExchangePlan {
 public:
  struct Exchange {
    int from = 0, to = 0;
    int from_antenna = 0, to_antenna = 0;
  };

  /// Each antenna of each vehicle with each antenna of every other vehicle, lower vehicle first.
  [[nodiscard]] static ExchangePlan of_antennas(int vehicles, int antennas, double rate_hz);
  /// Each vehicle to each other one.
  [[nodiscard]] static ExchangePlan of_links(int vehicles, double rate_hz);

  /// Time of the next exchange, infinite if there is none.
  [[nodiscard]] double next_s() const;

  [[nodiscard]] Exchange take();

 private:
  ExchangePlan(std::vector<Exchange> exchanges, double rate_hz);

  std::vector<Exchange> exchanges_;
  double rate_hz_;
  std::int64_t count_ = 0;
};

}  // namespace rali::sim
