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
  /// Inertial samples wait this long for a late scan, by arrival.
  Duration scan_wait = Duration::from_s(0.25);
  /// A scan waits this long for inertial samples that reach its end.
  Duration imu_wait = Duration::from_s(0.05);
  std::size_t scans_max = 8;  ///< waiting; beyond it the oldest is dropped
};

/// An event that is due, and when it arrived.
struct LiveEvent {
  vehicle::Event event;
  Time arrival;
};

/// Counts of dropped events. A count that rises is a Finding of the host.
struct LiveOrderTally {
  std::uint64_t late_imu = 0, late_scans = 0, empty_scans = 0;
  std::uint64_t dropped_scans = 0;  ///< the odometry did not keep up
  std::uint64_t repeated_ranges = 0;
  std::uint64_t forced = 0;  ///< events passed on because their wait was over
};

/// Puts events of live sensors into the order of recordings (by data time; inertial samples before
/// ranges before scans), with the shortest possible waits:
///
/// - inertial samples and ranges are passed on at once up to the expected end of the next scan;
///   later ones wait for the scan;
/// - a scan is passed on once an inertial sample has reached its end.
///
/// No event is waited for longer than the settings allow. Pure: the caller supplies the time.
class LiveOrder final : public drive::EventSink {
 public:
  LiveOrder(const LiveOrderSettings& settings, const ranging::ExchangeSettings& exchange)
      : settings_(settings), pairer_(exchange) {}

  /// Arrival time of the events that are pushed next.
  void set_arrival(Time t) { arrival_ = t; }

  void push(const sensor::ImuSample& sample) override;
  void push(std::shared_ptr<const sensor::LidarScan> scan) override;
  void push(const sensor::RangeSample& sample) override;

  /// Appends the events that are due. @param now on the clock of arrivals
  void take(Time now, std::vector<LiveEvent>& out);

  /// The latest time at which take() has an event; empty: not before something arrives.
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
  std::optional<Duration> period_;  ///< between scans, the shortest of recent ones
  LiveOrderTally tally_;
};

}  // namespace rali::host
