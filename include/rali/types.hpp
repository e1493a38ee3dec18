#pragma once

#include <cstdint>
#include <string>

#include <Eigen/Geometry>

namespace rali {

// Conventions of all headers: SI units, named at the end of each name. T_a_b is the pose of b in a:
// p_a = T_a_b * p_b. `body` has x forward, y left, z up. Stamps are nanoseconds of the vehicle's
// clock, since the Unix epoch where the recording has such stamps.

using Vec3 = Eigen::Vector3d;

/// A pose. DontAlign makes the layout the same under all compiler options: 16 doubles, columns of
/// the 4x4 matrix.
using Pose3 = Eigen::Transform<double, 3, Eigen::Isometry, Eigen::DontAlign>;

/// Covariance of a pose, order x y z rx ry rz [m, rad], rotation about the fixed axes of the outer
/// frame, as in ROS' PoseWithCovariance.
using Covariance6 = Eigen::Matrix<double, 6, 6, Eigen::DontAlign>;

/// Seconds of a stamp. For current dates a double resolves 0.2 microseconds.
[[nodiscard]] inline double seconds(std::int64_t stamp_ns) {
  return static_cast<double>(stamp_ns) * 1e-9;
}

enum class FindingLevel { kInfo, kWarning, kError };

/// A problem in the data or during a run that did not stop it.
struct RunFinding {
  std::string id;  ///< stable: "D08" of the doctor, "odometry.diverged"
  FindingLevel level = FindingLevel::kWarning;
  std::int64_t stamp_ns = 0;  ///< 0: the whole recording
  std::string vehicle;        ///< may be empty
  std::string topic;          ///< may be empty
  std::string text;           ///< one sentence with its numbers and units
  std::string effect;         ///< on the map; may be empty
  std::string remedy;         ///< may be empty
};

}  // namespace rali
