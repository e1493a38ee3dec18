#include "rali/drive/loop_progress.hpp"

namespace rali::drive {

void LoopProgress::report(double fraction, bool always) {
  const auto now = std::chrono::steady_clock::now();
  if (!always && now - last_ < std::chrono::milliseconds(100)) return;
  last_ = now;
  Progress progress;
  progress.vehicle = run_.name();
  progress.stage = "odometry";
  progress.fraction = fraction;
  progress.path_m = run_.path_m();
  progress.degenerate_fraction = run_.path_m() > 0.0 ? run_.degenerate_m() / run_.path_m() : 0.0;
  progress.ranges = run_.ranges();
  progress.ranges_used = run_.ranges_used();
  if (!run_.poses().empty()) {
    progress.t = run_.poses().back().t;
    const double data_s = seconds_between(run_.poses().front().t, progress.t);
    const double wall_s = std::chrono::duration<double>(now - begin_).count();
    progress.speed = wall_s > 0.0 ? data_s / wall_s : 0.0;
  }
  sink_.progress(progress);
}

}  // namespace rali::drive
