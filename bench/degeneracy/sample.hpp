#pragma once

#include <array>
#include <string>
#include <vector>

#include "rali/degeneracy/information.hpp"
#include "registration.hpp"

namespace rali::degeneracy_bench {

/// What is compared. Low score = blind.
enum class Detector { kPaper, kLambda3, kZhang, kZhangShift, kRaw, kChance, kAware };
inline constexpr std::size_t kDetectors = 7;

/// What one detector said about one scan.
struct Said {
  double score = 0.0;
  /// Between its blind direction and the axis of the route, horizontal, without sign; NaN if it
  /// names none.
  double off_axis_deg = 0.0;
};

/// One scan, judged by registration and by all detectors.
struct Sample {
  std::string place;  ///< scene, with what is special about it
  bool masked = false;
  std::uint64_t seed = 0;
  int rings = 0;
  double driven_m = 0.0;
  Achieved truth;
  std::array<Said, kDetectors> said;
  std::array<degeneracy::DirectionInfo, 6> directions;
};

/// Looks at all places of one drive. @param mask_m as in TrueMap::look().
class Judge {
 public:
  Judge(const odometry::RobustSettings& settings, std::string place, std::uint64_t seed, int rings,
        double mask_m);

  /// Takes the next station into account; one every 2 m becomes a sample.
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
