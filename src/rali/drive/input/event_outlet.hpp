#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>

#include "rali/drive/input/event_sink.hpp"
#include "rali/drive/input/gap_watch.hpp"
#include "rali/drive/input/input_report.hpp"
#include "rali/drive/input/reorder_window.hpp"

namespace rali::drive {

/// The last stage of every source: sorts events, cuts them to the requested time span and counts
/// what is missing.
class EventOutlet final : public EventSink {
 public:
  explicit EventOutlet(const InputOptions& options)
      : start_s_(options.start_s), duration_s_(options.duration_s) {}

  void push(const sensor::ImuSample& sample) override;
  /// Also takes scans without points: they are not passed on, but count as missing.
  void push(std::shared_ptr<const sensor::LidarScan> scan) override;

  /// Ranges wait outside the reordering window: a radio with a wrong clock must not disturb the
  /// sensors. A late range is passed on at once, with a stamp before the last event's.
  void push(const sensor::RangeSample& sample) override;

  void finish() {
    window_.finish();
    finished_ = true;
  }

  /// The next event in order, if one is ready; events outside the requested time span are dropped.
  [[nodiscard]] std::optional<vehicle::Event> pop(InputReport& report);

  /// True once an event behind the requested time span was seen: no more events will come.
  [[nodiscard]] bool past_end() const { return past_end_; }

  /// Adds the findings about gaps and late events; call once, at the end.
  void close(InputReport& report) const;

 private:
  void close_imu(InputReport& report) const;
  void close_late(InputReport& report) const;
  void close_empty(InputReport& report) const;
  void count(const vehicle::Event& event, Time t, InputReport& report);
  /// Moves the next sensor event within the requested time span to held_; false: none is ready yet.
  [[nodiscard]] bool hold_next();
  /// The first waiting range, if it precedes the held event or nothing else will come.
  [[nodiscard]] std::optional<vehicle::Event> pop_range(InputReport& report);
  [[nodiscard]] bool is_in_time(Time t) const;

  double start_s_, duration_s_;
  ReorderWindow window_;
  std::optional<std::pair<Time, vehicle::Event>> held_;
  std::multimap<Time, sensor::RangeSample> ranges_;
  bool finished_ = false;
  std::optional<Time> t_first_;
  GapWatch scans_{1.7, 0.0};
  GapWatch imu_{4.0, 0.05};
  std::uint64_t imu_at_last_scan_ = 0;
  std::uint64_t scans_without_imu_ = 0;  ///< no sample since the previous scan
  std::uint64_t late_scans_ = 0, late_imu_ = 0;
  std::uint64_t empty_ = 0, empty_at_start_ = 0, empty_at_end_ = 0;  ///< scans without a point
  bool any_scan_ = false;
  bool past_end_ = false;
};

}  // namespace rali::drive
