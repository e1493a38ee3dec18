#include "rali/drive/input/gap_watch.hpp"

#include <fmt/format.h>

#include "rali/base/counted.hpp"

namespace rali::drive {

void GapWatch::see(Time t) {
  if (!last_) {
    last_ = t;
    return;
  }
  const double step_s = t.s() - last_->s();
  last_ = t;
  if (step_s <= 0.0) return;
  if (period_s_ == 0.0) {
    period_s_ = step_s;
    return;
  }
  // The first steps may themselves be gaps: the period adapts faster to smaller steps.
  if (step_s > factor_ * period_s_ && step_s > min_s_) {
    ++gaps_;
    missing_s_ += step_s - period_s_;
    if (step_s > longest_s_) {
      longest_s_ = step_s;
      t_longest_ = t;
    }
    return;
  }
  period_s_ += (step_s < period_s_ ? 0.25 : 0.05) * (step_s - period_s_);
}

std::optional<Finding> gap_finding(const GapWatch& watch, const std::string& id,
                                   const std::string& what) {
  if (watch.gaps() == 0) return std::nullopt;
  Finding f;
  f.id = id;
  f.t = watch.t_longest();
  f.text = fmt::format("{} in the {}: {:.2f} s missing, longest {:.2f} s, ends at {:.3f} s",
                       counted(watch.gaps(), "gap"), what, watch.missing_s(), watch.longest_s(),
                       watch.t_longest().s());
  f.value = watch.longest_s();
  return f;
}

}  // namespace rali::drive
