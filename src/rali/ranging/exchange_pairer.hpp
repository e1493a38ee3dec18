#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "rali/ranging/settings.hpp"
#include "rali/sensor/range_sample.hpp"

namespace rali::ranging {

/// A range to pass on, or a duplicate.
struct PairedRange {
  sensor::RangeSample sample;
  bool duplicate = false;
};

/// Finds ranges that are one measurement (algorithms 4.7): j's radio reports u_jk and k's u_kj, and
/// both may come from one exchange. A range may also arrive a second time, through the network or
/// by a repeated message.
///
/// Key: the pair of antennas and the time within half a slot. The mean of both directions of one
/// exchange is passed on once, sigma unchanged. Directions that differ by more than `agree_m` have
/// independent errors: both are passed on.
///
/// A range waits only if both directions of its pair are received, at most until a range half a
/// slot later comes or release() is called. Ranges of one pair leave in order of time; ranges of
/// different pairs may overtake each other by half a slot.
class ExchangePairer {
 public:
  explicit ExchangePairer(const ExchangeSettings& settings);

  /// Takes the next range and appends to `out` what is decided by it.
  void add(const sensor::RangeSample& sample, std::vector<PairedRange>& out);

  /// Passes on all ranges that wait for a partner from before `now`.
  void release(Time now, std::vector<PairedRange>& out);

  /// Passes on all waiting ranges: the recording has ended.
  void flush(std::vector<PairedRange>& out);

 private:
  /// (low id, high id, antenna of low, antenna of high)
  using Key = std::array<std::uint16_t, 4>;

  struct Past {
    sensor::RangeSample sample;
    bool paired = false;
  };

  struct Link {
    std::multimap<std::int64_t, Past> past;  ///< by stamp
    bool received[2] = {false, false};       ///< directions
    std::optional<sensor::RangeSample> waiting;
  };

  [[nodiscard]] bool within_half_slot(Time a, Time b) const;
  [[nodiscard]] static Past* find(Link& link, Time from, Time to, bool same_direction,
                                  const sensor::RangeSample& sample);
  void remember(Link& link, const sensor::RangeSample& sample, bool paired) const;
  void join(Link& link, Past& partner, const sensor::RangeSample& sample,
            std::vector<PairedRange>& out);

  ExchangeSettings settings_;
  std::map<Key, Link> links_;
  std::vector<Key> waiting_;  ///< links with a range that waits
};

}  // namespace rali::ranging
