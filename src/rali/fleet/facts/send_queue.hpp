#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <tuple>
#include <vector>

#include "rali/base/time.hpp"
#include "rali/fleet/facts/exchange_settings.hpp"
#include "rali/fleet/facts/fact_store.hpp"

namespace rali::fleet {

/// What an inventory says, ready to be asked.
using Holdings = std::map<StreamKey, SeqSet>;

/// Facts that wait for one destination: what the estimate needs most first (increments and ranges,
/// loops, coarse points, refinements), the oldest first among equals, no faster than the link
/// takes them.
class SendQueue {
 public:
  explicit SendQueue(const ExchangeSettings& settings);

  /// @param asked true: was asked for and takes credit; false: is told unasked, because it is new
  void add(const FactPtr& fact, bool asked);

  void grant(double bytes) { credit_bytes_ = bytes; }

  /// The destination is out of reach: what waits is forgotten, it will ask.
  void clear() { waiting_.clear(); }

  /// What may go now; it leaves the queue.
  [[nodiscard]] std::vector<FactPtr> take(Time now);

  /// The destination told what it has: that need not be sent, and how much of what was sent came
  /// tells how much the link takes.
  void confirm(const Holdings& holdings, Time now);

  /// Was sent less than `s` ago.
  [[nodiscard]] bool just_sent(const FactKey& key, Time now, double s) const;

  [[nodiscard]] std::size_t size() const { return waiting_.size(); }

  [[nodiscard]] double rate_Bps() const { return rate_Bps_; }

 private:
  struct Waiting {
    FactPtr fact;
    bool asked = false;
  };

  struct Sent {
    Time t;
    std::size_t bytes = 0;
  };

  /// Class of kind, time, name.
  using Order = std::tuple<int, std::int64_t, FactKey>;

  void fill_bucket(Time now);
  void adapt(std::size_t came, std::size_t lost, Time now);

  ExchangeSettings settings_;
  std::map<Order, Waiting> waiting_;
  std::map<FactKey, Sent> unconfirmed_;
  double credit_bytes_ = 0.0;
  double tokens_bytes_ = 0.0;
  double rate_Bps_ = 0.0;
  bool was_full_ = false;  ///< something waited for the rate since the last confirmation
  std::optional<Time> filled_, confirmed_;
};

}  // namespace rali::fleet
