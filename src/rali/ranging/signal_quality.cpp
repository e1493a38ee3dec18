#include "rali/ranging/signal_quality.hpp"

#include <algorithm>
#include <cmath>

namespace rali::ranging {
namespace {

bool is_known(double power_dbm) { return std::isfinite(power_dbm) && power_dbm != 0.0; }

/// 0 up to clear_db, 1 from blocked_db on, a straight line in between.
double blocked_part(double gap_db, const SignalSettings& s) {
  // Limits in the wrong order or equal make a step instead of a division by zero.
  if (s.blocked_db <= s.clear_db) return gap_db > s.clear_db ? 1.0 : 0.0;
  return std::clamp((gap_db - s.clear_db) / (s.blocked_db - s.clear_db), 0.0, 1.0);
}

}  // namespace

SignalQuality signal_quality(const sensor::RangeSample& sample, const SignalSettings& settings) {
  SignalQuality out;
  if (!is_known(sample.rssi_dbm) || !is_known(sample.first_path_dbm)) return out;
  out.gap_db = sample.rssi_dbm - sample.first_path_dbm;
  const double part = blocked_part(out.gap_db, settings);
  out.p_los = settings.p_los_clear + part * (settings.p_los_blocked - settings.p_los_clear);
  const bool beyond = out.gap_db > std::max(settings.blocked_db, settings.clear_db);
  out.sigma_factor = beyond ? settings.beyond_factor : 1.0 + part * (settings.blocked_factor - 1.0);
  return out;
}

}  // namespace rali::ranging
