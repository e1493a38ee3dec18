#pragma once

#include <limits>

#include "rali/base/settings.hpp"

namespace rali::ranging {

/// What is fitted to the ranges of the last seconds.
enum class PaperSmoother { kLine, kMean, kQuadratic, kNone };
inline constexpr ChoiceNames<4> kPaperSmootherNames{"line", "mean", "quadratic", "none"};

/// The points between which a range is taken: antennas, or bodies as in the paper.
enum class PaperRangePoint { kAntenna, kBody };
inline constexpr ChoiceNames<2> kPaperRangePointNames{"antenna", "body"};

/// How a range becomes a distance in the plane of the correction.
enum class PaperRange2d {
  kProject,  ///< sqrt(u^2 - dz^2)
  kFlat,     ///< u, as in the paper
  k3d        ///< no plane: circle and direction in space
};
inline constexpr ChoiceNames<3> kPaperRange2dNames{"project", "flat", "3d"};

/// Which of two solutions.
enum class PaperRoot { kSmallest, kNearestImu };
inline constexpr ChoiceNames<2> kPaperRootNames{"smallest", "nearest_imu"};

/// What to do if the circle does not reach the line.
enum class PaperNoRoot { kClosest, kNone };
inline constexpr ChoiceNames<2> kPaperNoRootNames{"closest", "none"};

/// Further use of a range that moved the state (finding F13).
enum class PaperThenFactor {
  kState,  ///< it enters the graph as well, as in the paper
  kGuess   ///< the move is only an initial guess, the factor alone counts
};
inline constexpr ChoiceNames<2> kPaperThenFactorNames{"state", "guess"};

/// The time at which the smoothed range is compared with the pose.
enum class PaperRangeTime {
  kMeasured,  ///< at the newest range: the pose is extrapolated back by its velocity
  kKeyframe   ///< at the keyframe, as in the paper: one index for both
};
inline constexpr ChoiceNames<2> kPaperRangeTimeNames{"measured", "keyframe"};

/// Which smoothed ranges are factors of the local graph.
enum class PaperFactor {
  kDegenerate,  ///< wherever the scan is degenerate, also if the range fits already
  kCorrected,   ///< those that moved the state (algorithms 5.2)
  kAlways,      ///< one at each keyframe that has one
  kNone
};
inline constexpr ChoiceNames<4> kPaperFactorNames{"degenerate", "corrected", "always", "none"};

/// Which keyframes move with one that is corrected.
enum class PaperFraction {
  kKeyframes,  ///< degenerate keyframes since the last correction take their fraction
               ///< (algorithms 5.5)
  kNone        ///< as in the paper: that keyframe alone
};
inline constexpr ChoiceNames<2> kPaperFractionNames{"keyframes", "none"};

/// The paper's use of ranges: each open point of its text is a setting (algorithms.md table 0.2).
struct PaperRangeSettings {
  PaperSmoother smoother = PaperSmoother::kLine;
  double smoother_s = 1.0;
  double smoother_outlier_sds = 3.0;
  int smoother_outlier_samples = 5;
  double smoother_outlier_min_m = 0.005;
  PaperRangePoint range_point = PaperRangePoint::kAntenna;
  PaperRange2d range_2d = PaperRange2d::kProject;
  PaperRoot root = PaperRoot::kSmallest;
  PaperNoRoot no_root = PaperNoRoot::kClosest;
  double gap_m = 0.1;
  double max_s_m = 1e6;
  double max_sensitivity = 4.0;
  double min_horizontal = 0.5;
  double ambiguous_sigmas = 2.0;
  PaperThenFactor correct_then_factor = PaperThenFactor::kState;
  double range_sigma_m = 0.1;
  int smoother_samples_min = 5;
  PaperRangeTime range_time = PaperRangeTime::kMeasured;
  PaperFactor factor = PaperFactor::kDegenerate;
  PaperFraction fraction = PaperFraction::kKeyframes;
  double lidar_sd_m = 0.05;
  double lidar_sd_deg = 0.5;
  double level_sd_deg = 0.1;
  int window_keyframes = 20;
  int iterations = 10;

  template <class V>
  void visit(V& v) {
    v.choice("smoother", smoother, kPaperSmootherNames, "what is fitted to the last ranges");
    v("smoother_s", smoother_s, 0.05, 60.0, "over how long");
    v("smoother_outlier_sds", smoother_outlier_sds, 1.0, 100.0,
      "ranges farther from the fit are removed once");
    v("smoother_outlier_samples", smoother_outlier_samples, 4, 1000,
      "with fewer ranges none is removed");
    v("smoother_outlier_min_m", smoother_outlier_min_m, 0.0, 1.0,
      "least sd taken for that: resolution of the radio");
    v.choice("range_point", range_point, kPaperRangePointNames, "what a range is between");
    v.choice("range_2d", range_2d, kPaperRange2dNames,
             "how a range becomes a distance in the plane");
    v.choice("root", root, kPaperRootNames, "which of two solutions");
    v.choice("no_root", no_root, kPaperNoRootNames, "what if the circle does not reach the line");
    v("gap_m", gap_m, 0.0, 1000.0, "smaller differences to the range are not corrected");
    v("max_s_m", max_s_m, 0.0, 1e6, "longer corrections are refused");
    v("max_sensitivity", max_sensitivity, 1.0, 1e6, "metres of correction per metre of range");
    v("min_horizontal", min_horizontal, 0.0, 1.0, "a steeper degenerate direction is refused");
    v("ambiguous_sigmas", ambiguous_sigmas, 0.0, 100.0,
      "solutions whose lengths differ by less are not told apart");
    v.choice("correct_then_factor", correct_then_factor, kPaperThenFactorNames,
             "whether a range that moved the state is also a factor");
    v("range_sigma_m", range_sigma_m, 0.001, 10.0, "sd of a range");
    v("smoother_samples_min", smoother_samples_min, 1, 1000, "a fit to fewer ranges is not used");
    v.choice("range_time", range_time, kPaperRangeTimeNames, "where the vehicle was at a range");
    v.choice("factor", factor, kPaperFactorNames, "which ranges are factors of the local graph");
    v.choice("corrected", fraction, kPaperFractionNames, "keyframes that are corrected together");
    v("lidar_sd_m", lidar_sd_m, 1e-4, 10.0, "sd between two keyframes of the local graph");
    v("lidar_sd_deg", lidar_sd_deg, 1e-3, 90.0, "and of the rotation between them");
    v("level_sd_deg", level_sd_deg, 1e-3, 90.0, "sd of roll and pitch, which gravity holds");
    v("window_keyframes", window_keyframes, 2, 200, "keyframes of the local graph");
    v("iterations", iterations, 1, 100, "Levenberg-Marquardt steps at each keyframe, at most");
  }

  /// The settings with the odometry's `literal` resolved into the readings it stands for.
  [[nodiscard]] PaperRangeSettings resolved(bool literal) const {
    PaperRangeSettings out = *this;
    if (!literal) return out;
    out.range_point = PaperRangePoint::kBody;
    out.range_2d = PaperRange2d::kFlat;
    out.range_time = PaperRangeTime::kKeyframe;
    out.fraction = PaperFraction::kNone;
    out.factor = PaperFactor::kAlways;
    out.max_s_m = std::numeric_limits<double>::infinity();
    out.max_sensitivity = std::numeric_limits<double>::infinity();
    return out;
  }
};

}  // namespace rali::ranging
