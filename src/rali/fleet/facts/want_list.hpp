#pragma once

#include <map>
#include <optional>
#include <vector>

#include "rali/base/time.hpp"
#include "rali/fleet/facts/exchange_settings.hpp"
#include "rali/fleet/facts/fact_store.hpp"
#include "rali/fleet/facts/send_queue.hpp"

namespace rali::fleet {

/// Another vehicle as one who may be asked.
struct Holder {
  VehicleId vehicle;
  double quality = 0.0;  ///< of the link, 0 to 1
  const Holdings* holdings = nullptr;
};

/// How long a link takes to answer (as TCP finds its timeout, RFC 6298).
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

/// The facts a vehicle knows of and does not have: whom it asked for which, and when.
class WantList {
 public:
  explicit WantList(const ExchangeSettings& settings) : settings_(settings) {}

  /// Looks for what is missing: below the end of each stream, and what others say they hold.
  /// `withheld` are points that are not wanted now. Bounded: the first few hundred of each stream,
  /// fewer if there are many streams.
  void refresh(const FactStore& store, const std::vector<Holder>& holders, const Holdings& withheld,
               Time now);

  /// What to ask of whom now, marked as asked. Of the author if it is in reach, else of the holder
  /// with the best link; of another one after two vain requests.
  [[nodiscard]] std::map<VehicleId, std::vector<Want>> ask(const FactStore& store,
                                                           const std::vector<Holder>& holders,
                                                           Time now);

  /// A fact came: how long its request took, and how large facts are.
  void came(const Fact& fact, VehicleId from, Time now);

  /// Not to be had now.
  void drop(const FactKey& key) { missing_.erase(key); }

  [[nodiscard]] std::size_t size() const { return missing_.size(); }

  /// Of one author.
  [[nodiscard]] std::size_t size_of(VehicleId author) const;

  [[nodiscard]] double patience_s(VehicleId holder) const;

 private:
  struct Missing {
    Time known;  ///< since when
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
  double fact_bytes_ = 1000.0;  ///< mean of those that came
};

}  // namespace rali::fleet
