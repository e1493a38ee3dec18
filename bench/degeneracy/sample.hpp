#pragma once

#include <array>
#include <string>
#include <vector>

#include "rali/degeneracy/information.hpp"
#include "registration.hpp"

namespace rali::degeneracy_bench {

/// The compared detectors. Low score = degenerate.
enum class Detector { kPaper, kLambda3, kZhang, kZhangShift, kRaw, kChance, kAware };
inline constexpr std::size_t kDetectors = 7;

/// Result of one detector for one scan.
struct Reported {
  double score = 0.0;
  /// Angle between its degenerate direction and the axis of the route, horizontal, without sign;
  /// NaN if it reports no direction.
  double off_axis_deg = 0.0;
};

/// One scan with the results of registration and of all detectors.
struct Sample {
  std::string place;  ///< scene, with its special features
  bool masked = false;
  std::uint64_t seed = 0;
  int rings = 0;
  double driven_m = 0.0;
  Achieved truth;
  std::array<Reported, kDetectors> reported;
  std::array<degeneracy::DirectionInfo, 6> directions;
};

/// Evaluates all stations of one drive. @param mask_m as in TrueMap::look()
class Judge {
 public:
  Judge(const odometry::RobustSettings& settings, std::string place, std::uint64_t seed, int rings,
        double mask_m);

  /// Adds the next station; one every 2 m becomes a sample.
  void add(const Station& station, const sensor::Calibration& calibration);

  [[nodiscard]] std::vector<Sample>& samples() { return samples_; }

 private:
  void judge(const Station& station, const sensor::Calibration& calibration);

  odometry::RobustSettings settings_;
  TrueMap map_;
  Sample pattern_;
  double mask_m_;
  double next_m_;
  degeneracy::Axes axes_ = degeneracy::Axes::Identity();
  std::vector<Sample> samples_;
};

}  // namespace rali::degeneracy_bench
