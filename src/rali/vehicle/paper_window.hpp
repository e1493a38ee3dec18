#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "rali/base/time.hpp"
#include "rali/geometry/se3.hpp"
#include "rali/graph/factors.hpp"
#include "rali/odometry/odometry.hpp"
#include "rali/ranging/paper_settings.hpp"

namespace rali::vehicle {

/// A smoothed range at a keyframe to a fixed point.
struct PaperRangeFactor {
  Time t;
  geometry::Vec3 p_body_m = geometry::Vec3::Zero();  ///< own end, in the keyframe's body
  geometry::Vec3 p_odom_peer_m = geometry::Vec3::Zero();
  double range_m = 0.0;
};

/// The directions in which a range may correct a LiDAR step of the local graph.
enum class PaperSteps {
  kDegenerate,  ///< along the degenerate direction; all others have a tenth of the sd
  kIsotropic    ///< in all equally, as the paper seems to do
};

/// The paper's local pose graph over the last keyframes (paper, section "System Overview";
/// algorithms 6.1). Neighbours are connected by the corrected LiDAR odometry with constant sd and
/// by the inertial deltas. Each has at most one smoothed range. A range corrects a step along the
/// degenerate direction only: walls constrain the heading of a vehicle that slips along them. The
/// oldest keyframe is fixed: the paper does not mention marginalisation. The odometry's poses
/// already depend on inertial data, which count twice here as they do in the paper.
class PaperWindow {
 public:
  struct Node {
    std::uint32_t seq = 0;
    Time t;
    geometry::SE3 T_odom_body;      ///< current estimate
    geometry::SE3 T_previous_this;  ///< the odometry's factor; identity for the first
    geometry::Mat6 covariance = geometry::Mat6::Zero();  ///< as reported by the odometry
    double room_m2 = 0.0;  ///< variance it added along the degenerate direction; 0 without one
    bool corrected = false;
    bool degenerate = false;
    /// Direction in which a range may correct the step to this keyframe. Empty: none, or, if the
    /// keyframe is degenerate, all.
    std::optional<geometry::Vec3> e3_odom;
    odometry::KeyframeMotion motion;                ///< current estimate
    odometry::KeyframeMotion reported;              ///< as reported by the odometry
    std::optional<graph::InertialFactor> inertial;  ///< from the keyframe before
    std::optional<PaperRangeFactor> range;
  };

  explicit PaperWindow(const ranging::PaperRangeSettings& settings,
                       PaperSteps steps = PaperSteps::kDegenerate)
      : settings_(settings), steps_(steps) {}

  /// Appends a keyframe at the odometry's pose; the oldest may be dropped. Computes
  /// `T_previous_this` and `room_m2`.
  void add(Node node, bool degenerate);

  /// Shifts the newest keyframe, and by their fractions the degenerate ones before it since the
  /// last correction (setting `fraction`). With `correct_then_factor` guess the odometry's factors
  /// do not change: the shift is then only the initial value of solve().
  void shift_newest(const geometry::Vec3& shift_odom_m);

  void set_range(const PaperRangeFactor& range) { nodes_.back().range = range; }

  /// Optimises all keyframes by Levenberg-Marquardt. Without ranges nothing moves.
  void solve();

  void clear() { nodes_.clear(); }

  [[nodiscard]] const std::deque<Node>& nodes() const { return nodes_; }

 private:
  ranging::PaperRangeSettings settings_;
  PaperSteps steps_;
  std::deque<Node> nodes_;
};

}  // namespace rali::vehicle
