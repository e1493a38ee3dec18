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

/// Content of an inventory, indexed for look-up.
using Holdings = std::map<StreamKey, SeqSet>;

/// Facts queued for one destination, at most at the rate of the link. The facts that the estimate
/// needs most go first (increments and ranges, loops, coarse points, refinements), the oldest first
/// within a class.
class SendQueue {
 public:
  explicit SendQueue(const ExchangeSettings& settings);

  /// @param asked true: was requested and uses credit; false: is sent unasked, because it is new
  void add(const FactPtr& fact, bool asked);

  void grant(double bytes) { credit_bytes_ = bytes; }

  /// The destination is out of reach: the queue is emptied, because it will request what it lacks.
  void clear() { waiting_.clear(); }

  /// Facts that may be sent now; they leave the queue.
  [[nodiscard]] std::vector<FactPtr> take(Time now);

  /// Processes an inventory of the destination: facts it holds need not be sent. The fraction of
  /// the sent facts that arrived gives the capacity of the link.
  void confirm(const Holdings& holdings, Time now);

  /// Whether it was sent less than `s` ago.
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

  /// Class of kind, time, key.
  using Order = std::tuple<int, std::int64_t, FactKey>;

  void fill_bucket(Time now);
  void adapt(std::size_t came, std::size_t lost, Time now);

  ExchangeSettings settings_;
  std::map<Order, Waiting> waiting_;
  std::map<FactKey, Sent> unconfirmed_;
  double credit_bytes_ = 0.0;
  double tokens_bytes_ = 0.0;
  double rate_Bps_ = 0.0;
  bool was_full_ = false;  ///< facts waited for the rate limit since the last confirmation
  std::optional<Time> filled_, confirmed_;
};

}  // namespace rali::fleet
