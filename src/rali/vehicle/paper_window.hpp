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

/// In which directions a LiDAR step of the local graph may give way to a range.
enum class PaperSteps {
  kDegenerate,  ///< along the degenerate direction; all else is held ten times as firmly
  kIsotropic    ///< in all alike, as the paper seems to do
};

/// The paper's local pose graph over the last keyframes: between each two the corrected LiDAR
/// odometry with constant sd and the inertial deltas, at each at most one smoothed range (paper,
/// section "System Overview"; algorithms 6.1). A step gives way along the degenerate direction
/// only: walls hold the heading of a vehicle that slips along them. The oldest keyframe is held:
/// the paper says nothing of marginalisation. The odometry's poses hang on inertial data already,
/// which count twice here as they do in the paper.
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
    bool degenerate = false;
    /// Along which the step before gives way; nothing: in no direction, or, where the keyframe is
    /// degenerate, in all.
    std::optional<geometry::Vec3> e3_odom;
    odometry::KeyframeMotion motion;                ///< as known now
    odometry::KeyframeMotion told;                  ///< as the odometry told
    std::optional<graph::InertialFactor> inertial;  ///< from the keyframe before
    std::optional<PaperRangeFactor> range;
  };

  explicit PaperWindow(const ranging::PaperRangeSettings& settings,
                       PaperSteps steps = PaperSteps::kDegenerate)
      : settings_(settings), steps_(steps) {}

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
  PaperSteps steps_;
  std::deque<Node> nodes_;
};

}  // namespace rali::vehicle
