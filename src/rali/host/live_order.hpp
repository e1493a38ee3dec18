#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <tuple>
#include <vector>

#include "rali/drive/input/event_sink.hpp"
#include "rali/ranging/exchange_pairer.hpp"
#include "rali/vehicle/event.hpp"

namespace rali::host {

struct LiveOrderSettings {
  bool has_imu = true;
  /// Inertial samples of a scan that is late wait so long for it, by arrival.
  Duration scan_wait = Duration::from_s(0.25);
  /// A scan waits so long for inertial samples that reach its end.
  Duration imu_wait = Duration::from_s(0.05);
  std::size_t scans_max = 8;  ///< waiting; beyond it the oldest is dropped
};

/// An event whose turn it is, and when it arrived.
struct LiveEvent {
  vehicle::Event event;
  Time arrival;
};

/// What had to be left out. A count that rises is a Finding of the host.
struct LiveOrderTally {
  std::uint64_t late_imu = 0, late_scans = 0, empty_scans = 0;
  std::uint64_t dropped_scans = 0;  ///< the odometry did not keep up
  std::uint64_t repeated_ranges = 0;
  std::uint64_t forced = 0;  ///< events that left because the wait was over
};

/// Puts events of live sensors into the order in which recordings hand them out (by data time;
/// inertial samples before ranges before scans), and waits for nothing that need not be waited for:
///
/// - inertial samples and ranges leave at once up to where the next scan is expected to end; behind
///   that they wait for the scan;
/// - a scan leaves once an inertial sample has reached its end.
///
/// What never comes is waited for no longer than the settings allow. Pure: time is what the caller
/// says.
class LiveOrder final : public drive::EventSink {
 public:
  LiveOrder(const LiveOrderSettings& settings, const ranging::ExchangeSettings& exchange)
      : settings_(settings), pairer_(exchange) {}

  /// When the events that are pushed next arrived.
  void set_arrival(Time t) { arrival_ = t; }

  void push(const sensor::ImuSample& sample) override;
  void push(std::shared_ptr<const sensor::LidarScan> scan) override;
  void push(const sensor::RangeSample& sample) override;

  /// Appends what may leave. @param now on the clock of arrivals
  void take(Time now, std::vector<LiveEvent>& out);

  /// When take() has something at the latest; nothing: not before something arrives.
  [[nodiscard]] std::optional<Time> due() const;

  [[nodiscard]] const LiveOrderTally& tally() const { return tally_; }

  [[nodiscard]] std::size_t waiting() const { return due_.size(); }

 private:
  using Key = std::tuple<Time, int, std::uint64_t>;  ///< stamp, rank, order

  void put(Time t, int rank, vehicle::Event event);
  void settle();
  void drop_scans();
  [[nodiscard]] bool is_turn(const Key& key) const;
  [[nodiscard]] Time deadline(const Key& key, const LiveEvent& event) const;

  LiveOrderSettings settings_;
  ranging::ExchangePairer pairer_;
  std::vector<ranging::PairedRange> paired_;
  std::map<Key, LiveEvent> due_;
  Time arrival_;
  std::uint64_t order_ = 0;
  std::size_t scans_ = 0;  ///< waiting
  std::optional<Time> newest_imu_, newest_scan_, left_imu_, left_scan_;
  std::optional<Duration> period_;  ///< between scans, the shortest of late
  LiveOrderTally tally_;
};

}  // namespace rali::host
