#pragma once

#include <optional>
#include <string>

#include "rali/drive/input/gap_watch.hpp"
#include "rali/drive/input/input_report.hpp"
#include "rali/drive/input/reorder_window.hpp"

namespace rali::drive {

/// The last stage of every source: puts events into order, cuts them to the time asked for and
/// counts what is missing.
class EventOutlet {
 public:
  explicit EventOutlet(const InputOptions& options)
      : start_s_(options.start_s), duration_s_(options.duration_s) {}

  void push(const sensor::ImuSample& sample);
  void push(std::shared_ptr<const sensor::LidarScan> scan);

  void finish() { window_.finish(); }

  /// The next event in order, if one can leave; events outside the time asked for do not.
  [[nodiscard]] std::optional<vehicle::Event> pop(InputReport& report);

  /// True once an event behind the time asked for was seen: nothing more will come.
  [[nodiscard]] bool past_end() const { return past_end_; }

  /// Adds the findings of gaps and late events; call once, at the end.
  void close(InputReport& report) const;

 private:
  void close_imu(InputReport& report) const;
  void count(const vehicle::Event& event, Time t, InputReport& report);

  double start_s_, duration_s_;
  ReorderWindow window_;
  std::optional<Time> t_first_;
  GapWatch sweeps_{1.7, 0.0};
  GapWatch imu_{4.0, 0.05};
  std::uint64_t imu_at_last_sweep_ = 0;
  std::uint64_t sweeps_without_imu_ = 0;  ///< no sample since the sweep before
  bool past_end_ = false;
};

}  // namespace rali::drive
