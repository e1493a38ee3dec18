#pragma once

#include <limits>

#include "rali/ranging/settings.hpp"
#include "rali/sensor/range_sample.hpp"

namespace rali::ranging {

/// Quality of one range by its signal strengths.
struct SignalQuality {
  double gap_db = std::numeric_limits<double>::quiet_NaN();  ///< total less first path
  double sigma_factor = 1.0;
  double p_los = std::numeric_limits<double>::quiet_NaN();  ///< NaN: nothing is known

  [[nodiscard]] bool clear() const { return sigma_factor <= 1.0; }
};

/// The gap between the total power and that of the first path widens behind obstacles; sigma is
/// raised by it (algorithms 4.3, step 2). If one of the powers is missing (0 or not a number),
/// sigma is not raised and p_los is NaN.
///
/// This never rejects a range. In recordings on open ground (UWB-dataset, DW1000) the gap is 0.8 dB
/// on average with and without an obstacle: it detects metal and people close by, not every
/// obstacle. So p_los stays away from 0 and 1.
[[nodiscard]] SignalQuality signal_quality(const sensor::RangeSample& sample,
                                           const SignalSettings& settings);

}  // namespace rali::ranging
