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

/// A smoothed range at a keyframe to a point that stands.
struct PaperRangeFactor {
  Time t;
  geometry::Vec3 p_body_m = geometry::Vec3::Zero();  ///< own end, in the keyframe's body
  geometry::Vec3 p_odom_peer_m = geometry::Vec3::Zero();
  double range_m = 0.0;
};

/// The paper's local pose graph over the last keyframes: between each two the corrected LiDAR
/// odometry with constant sd and the inertial deltas, at each at most one smoothed range (paper,
/// section "System Overview"; algorithms 6.1). The oldest keyframe is held: the paper says nothing
/// of marginalisation. The odometry's poses hang on inertial data already, which count twice here
/// as they do in the paper.
class PaperWindow {
 public:
  struct Node {
    std::uint32_t seq = 0;
    Time t;
    geometry::SE3 T_odom_body;      ///< as known now
    geometry::SE3 T_previous_this;  ///< the odometry's factor; identity for the first
    geometry::Mat6 covariance = geometry::Mat6::Zero();  ///< as the odometry told
    double room_m2 = 0.0;  ///< variance it added along the blind direction; 0 where nothing was
    bool corrected = false;
    odometry::KeyframeMotion motion;                ///< as known now
    odometry::KeyframeMotion told;                  ///< as the odometry told
    std::optional<graph::InertialFactor> inertial;  ///< from the keyframe before
    std::optional<PaperRangeFactor> range;
  };

  explicit PaperWindow(const ranging::PaperRangeSettings& settings) : settings_(settings) {}

  /// Appends a keyframe where the odometry has it; the oldest may leave. `T_previous_this` and
  /// `room_m2` are worked out here.
  void add(Node node, bool degenerate);

  /// Moves the newest keyframe, and by their part those blind ones before it that nothing corrected
  /// (setting `share`). With `correct_then_factor` guess the odometry's factors stay as they were:
  /// then this is but where solve() begins.
  void shift_newest(const geometry::Vec3& shift_odom_m);

  void set_range(const PaperRangeFactor& range) { nodes_.back().range = range; }

  /// All keyframes by Levenberg-Marquardt. Without ranges nothing moves.
  void solve();

  void clear() { nodes_.clear(); }

  [[nodiscard]] const std::deque<Node>& nodes() const { return nodes_; }

 private:
  ranging::PaperRangeSettings settings_;
  std::deque<Node> nodes_;
};

}  // namespace rali::vehicle
