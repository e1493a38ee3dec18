#include <algorithm>
#include <cmath>
#include <numbers>

#include "rali/wire/internal/ring_choice.hpp"

// A laser at a fixed elevation makes a sharp peak in the histogram of elevations; between two
// lasers it is nearly empty. Sensors without fixed elevations (Livox) and merged or downsampled
// clouds fill the valleys.
namespace rali::wire::internal {
namespace {

constexpr double kBinRad = 0.04 * std::numbers::pi / 180.0;
constexpr double kLimitRad = 65.0 * std::numbers::pi / 180.0;
constexpr std::size_t kRingsMin = 8, kRingsMax = 128;
constexpr double kFarM = 3.0;     ///< nearer points blur: lasers have no common origin
constexpr double kValley = 0.25;  ///< of the lower neighbouring peak
constexpr double kInPeaksMin = 0.85;

std::vector<double> histogram(const FirstClouds& first, double nearest_m, std::size_t& points) {
  const auto bins = static_cast<std::size_t>(2.0 * kLimitRad / kBinRad) + 1;
  std::vector<double> counts(bins, 0.0);
  points = 0;
  for (const FirstClouds::Cloud& cloud : first.clouds) {
    for (std::size_t i = 0; i < cloud.valid.size(); ++i) {
      if (cloud.valid[i] == 0) continue;
      const double flat_m = std::hypot(cloud.x_m[i], cloud.y_m[i]);
      if (flat_m < nearest_m) continue;
      const double at = (std::atan2(cloud.z_m[i], flat_m) + kLimitRad) / kBinRad;
      if (at < 0.0 || at >= static_cast<double>(bins)) continue;
      counts[static_cast<std::size_t>(at)] += 1.0;
      ++points;
    }
  }
  return counts;
}

std::vector<double> smoothed(const std::vector<double>& counts) {
  std::vector<double> smooth(counts.size(), 0.0);
  for (std::size_t i = 1; i + 1 < counts.size(); ++i) {
    smooth[i] = 0.25 * counts[i - 1] + 0.5 * counts[i] + 0.25 * counts[i + 1];
  }
  return smooth;
}

/// Peaks separated by valleys: index of the maximum of each.
std::vector<std::size_t> peaks_of(const std::vector<double>& smooth, double minimum) {
  std::vector<std::size_t> peaks;
  std::size_t top = 0;
  double lowest = 0.0;
  bool climbing = true;
  for (std::size_t i = 0; i < smooth.size(); ++i) {
    if (climbing) {
      if (smooth[i] > smooth[top]) top = i;
      if (smooth[top] >= minimum && smooth[i] < kValley * smooth[top]) {
        peaks.push_back(top);
        climbing = false;
        lowest = smooth[i];
      }
    } else {
      lowest = std::min(lowest, smooth[i]);
      if (smooth[i] >= minimum && lowest < kValley * smooth[i]) {
        climbing = true;
        top = i;
      }
    }
  }
  if (climbing && smooth[top] >= minimum) peaks.push_back(top);
  return peaks;
}

/// Mean elevation of the bins of each peak; adds up the points in them.
std::vector<float> centres(const std::vector<double>& counts, const std::vector<double>& smooth,
                           const std::vector<std::size_t>& peaks, double& in_peaks) {
  std::vector<float> found;
  in_peaks = 0.0;
  for (const std::size_t top : peaks) {
    const double floor = kValley * smooth[top];
    std::size_t from = top, to = top;
    while (from > 0 && smooth[from - 1] >= floor) --from;
    while (to + 1 < smooth.size() && smooth[to + 1] >= floor) ++to;
    double sum = 0.0, weight = 0.0;
    for (std::size_t i = from; i <= to; ++i) {
      sum += counts[i] * (static_cast<double>(i) + 0.5);
      weight += counts[i];
    }
    // The bin on either side of the cut belongs to the peak, too.
    in_peaks += weight + (from > 0 ? counts[from - 1] : 0.0) +
                (to + 1 < counts.size() ? counts[to + 1] : 0.0);
    if (weight > 0.0) found.push_back(static_cast<float>(sum / weight * kBinRad - kLimitRad));
  }
  return found;
}

std::vector<float> find_beyond(const FirstClouds& first, double nearest_m, bool& enough) {
  std::size_t points = 0;
  const std::vector<double> counts = histogram(first, nearest_m, points);
  enough = points >= 40 * kRingsMin;
  if (!enough) return {};
  const std::vector<double> smooth = smoothed(counts);
  // A ring may have few points, but more than this fraction (half a thousandth).
  const double minimum = std::max(2.0, 0.0005 * static_cast<double>(points));
  const std::vector<std::size_t> peaks = peaks_of(smooth, minimum);
  double in_peaks = 0.0;
  std::vector<float> found = centres(counts, smooth, peaks, in_peaks);
  const bool discrete = found.size() >= kRingsMin && found.size() <= kRingsMax &&
                        in_peaks >= kInPeaksMin * static_cast<double>(points);
  if (!discrete) found.clear();
  return found;
}

}  // namespace

std::vector<float> find_elevations(const FirstClouds& first) {
  bool enough = false;
  std::vector<float> far = find_beyond(first, kFarM, enough);
  if (enough) {
    // Steep lasers may reach nothing beyond 3 m: then all points give more rings.
    std::vector<float> all = find_beyond(first, 0.0, enough);
    return all.size() > far.size() ? all : far;
  }
  return find_beyond(first, 0.0, enough);
}

}  // namespace rali::wire::internal
