#pragma once

#include "rali/base/time.hpp"
#include "rali/ranging/arrival_clock.hpp"
#include "rali/wire/messages.hpp"

namespace rali::drive {

/// Times of a radio's frames on the recorder's clock, from their arrivals (algorithms 4.6). The
/// network's time is used where it advances: both ends of an exchange share it. Where it does not
/// (no network yet, other firmware), the radio's own time is used.
class RadioStamps {
 public:
  explicit RadioStamps(const ranging::ArrivalClockSettings& settings)
      : system_clock_(settings), local_clock_(settings) {}

  [[nodiscard]] Time host_time(const wire::LinktrackFrame& frame, Time t_record) {
    const Time by_system = system_clock_.add(system_count_.unwrap(frame.system_time_ms), t_record);
    const Time by_local = local_clock_.add(local_count_.unwrap(frame.local_time_ms), t_record);
    const bool system_runs = started_ && frame.system_time_ms != last_system_ms_;
    started_ = true;
    last_system_ms_ = frame.system_time_ms;
    return system_runs ? by_system : by_local;
  }

 private:
  ranging::MillisecondCount system_count_, local_count_;
  ranging::ArrivalClock system_clock_, local_clock_;
  bool started_ = false;
  std::uint32_t last_system_ms_ = 0;
};

}  // namespace rali::drive
