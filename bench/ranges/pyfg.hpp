#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/base/time.hpp"
#include "rali/geometry/se3.hpp"

namespace rali::ranges_bench {

/// A pose, e.g. "A17", or a landmark, e.g. "L3" (`robot` is then 'L').
struct PyfgName {
  char robot = 'A';
  int index = 0;
  constexpr auto operator<=>(const PyfgName&) const = default;
};

struct PyfgPose {
  Time t;
  geometry::SE3 T;  ///< in world; true
};

/// Relative pose; the covariance is of (rotation, translation) [rad, m] as in this program.
struct PyfgStep {
  PyfgName from, to;
  geometry::SE3 T_from_to;
  geometry::Mat6 covariance = geometry::Mat6::Identity();
};

struct PyfgRange {
  Time t;
  PyfgName from, to;
  double range_m = 0.0;
  double variance_m2 = 0.0;
};

/// Contents of a PyFG file. In a planar one z, roll and pitch are zero with a sigma of 1e-4 m and
/// rad per step.
struct Pyfg {
  bool planar = false;
  std::map<PyfgName, PyfgPose> poses;
  std::map<PyfgName, geometry::Vec3> landmarks_m;  ///< in world; true
  std::vector<PyfgStep> steps;
  std::vector<PyfgRange> ranges;
  std::size_t left_out = 0;  ///< lines with ignored tags (EDGE_SE2_XY, EDGE_SE3_XYZ, ...)
};

/// Sigma of z, roll and pitch of a planar step.
inline constexpr double kPlanarSigma = 1e-4;

/// Reads the text of a PyFG file (PyFactorGraph; lengths m, angles rad, times s).
/// Errors (kInput, name:line): a word instead of a number, too few or too many numbers, a number
/// that is not finite, a variance that is not positive, a duplicate or undefined name, planar and
/// spatial entries mixed, no pose at all.
[[nodiscard]] Result<Pyfg> parse_pyfg(std::string_view text, const std::string& name);

[[nodiscard]] Result<Pyfg> read_pyfg(const std::filesystem::path& path);

}  // namespace rali::ranges_bench
