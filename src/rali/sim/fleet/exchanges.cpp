#include "rali/sim/fleet/exchanges.hpp"

#include <limits>
#include <utility>

namespace rali::sim {

ExchangePlan::ExchangePlan(std::vector<Exchange> exchanges, double rate_hz)
    : exchanges_(std::move(exchanges)), rate_hz_(rate_hz) {}

ExchangePlan ExchangePlan::of_antennas(int vehicles, int antennas, double rate_hz) {
  std::vector<Exchange> all;
  for (int a = 0; a < vehicles; ++a) {
    for (int b = a + 1; b < vehicles; ++b) {
      for (int i = 0; i < antennas; ++i) {
        for (int k = 0; k < antennas; ++k) all.push_back({a, b, i, k});
      }
    }
  }
  return {std::move(all), rate_hz};
}

ExchangePlan ExchangePlan::of_links(int vehicles, double rate_hz) {
  std::vector<Exchange> all;
  for (int a = 0; a < vehicles; ++a) {
    for (int b = 0; b < vehicles; ++b) {
      if (a != b) all.push_back({a, b, 0, 0});
    }
  }
  return {std::move(all), rate_hz};
}

double ExchangePlan::next_s() const {
  if (exchanges_.empty() || rate_hz_ <= 0.0) return std::numeric_limits<double>::infinity();
  // Half a slot late, so that no exchange happens at the very start.
  const double slots = static_cast<double>(exchanges_.size()) * rate_hz_;
  return (static_cast<double>(count_) + 0.5) / slots;
}

ExchangePlan::Exchange ExchangePlan::take() {
  return exchanges_[static_cast<std::size_t>(count_++) % exchanges_.size()];
}

}  // namespace rali::sim
