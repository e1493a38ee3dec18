#pragma once

#include <map>
#include <optional>
#include <vector>

#include "rali/base/time.hpp"
#include "rali/fleet/facts/exchange_settings.hpp"
#include "rali/fleet/facts/fact_store.hpp"
#include "rali/fleet/facts/send_queue.hpp"

namespace rali::fleet {

/// Another vehicle of which facts can be requested.
struct Holder {
  VehicleId vehicle;
  const Holdings* holdings = nullptr;
};

/// Time a link takes to answer (estimated as TCP estimates its timeout, RFC 6298).
class Patience {
 public:
  explicit Patience(const ExchangeSettings& settings) : settings_(settings) {}

  void sample(double s);
  [[nodiscard]] double s() const;

 private:
  ExchangeSettings settings_;
  std::optional<double> mean_s_;
  double deviation_s_ = 0.0;
};

/// The facts a vehicle knows to exist and lacks: whom it asked for each, and when.
class WantList {
 public:
  explicit WantList(const ExchangeSettings& settings) : settings_(settings) {}

  /// Finds what is missing: gaps below the end of each stream, and facts that others list.
  /// `withheld` are points that are not wanted now. Bounded: the first few hundred of each stream,
  /// fewer if there are many streams.
  void refresh(const FactStore& store, const std::vector<Holder>& holders, const Holdings& withheld,
               Time now);

  /// Requests to send now, marked as asked. They go to the author if it is in reach, else to the
  /// holder with the best link; after two requests without answer, to another holder.
  [[nodiscard]] std::map<VehicleId, std::vector<Want>> ask(const FactStore& store,
                                                           const std::vector<Holder>& holders,
                                                           Time now);

  /// A fact arrived: updates the response time of its request and the mean fact size.
  void came(const Fact& fact, VehicleId from, Time now);

  /// Not available now.
  void drop(const FactKey& key) { missing_.erase(key); }

  [[nodiscard]] std::size_t size() const { return missing_.size(); }

  /// Likewise, of one author.
  [[nodiscard]] std::size_t size_of(VehicleId author) const;

  [[nodiscard]] double patience_s(VehicleId holder) const;

 private:
  struct Missing {
    Time known;  ///< since when it is known to be missing
    std::optional<Time> asked;
    VehicleId asked_of;
    int times = 0;
  };

  [[nodiscard]] bool due(const Missing& missing, Time now) const;
  [[nodiscard]] const Holder* choose(const FactKey& key, const Missing& missing,
                                     const FactStore& store,
                                     const std::vector<Holder>& holders) const;
  [[nodiscard]] std::map<VehicleId, double> outstanding_bytes(Time now) const;

  ExchangeSettings settings_;
  std::map<FactKey, Missing> missing_;
  std::map<VehicleId, Patience> patience_;
  std::map<VehicleId, Time> last_request_;
  double fact_bytes_ = 1000.0;  ///< mean of the received ones
};

}  // namespace rali::fleet
