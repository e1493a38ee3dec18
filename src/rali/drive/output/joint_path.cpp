#include "rali/drive/output/joint_path.hpp"

#include <algorithm>
#include <utility>

namespace rali::drive {

JointPath joint_path(const fleet::FleetEstimate& estimate, VehicleId vehicle) {
  JointPath path;
  const auto frame =
      std::find_if(estimate.frames.begin(), estimate.frames.end(),
                   [&](const fleet::VehicleFrame& f) { return f.vehicle == vehicle; });
  if (frame == estimate.frames.end()) return path;
  path.T_map_odom = frame->T_map_odom;
  const geometry::SE3 T_odom_map = frame->T_map_odom.inverse();
  // Rotation is perturbed in the body, position in the outer frame: only the latter turns.
  geometry::Mat6 turn = geometry::Mat6::Identity();
  turn.bottomRightCorner<3, 3>() = T_odom_map.R;
  const auto begin = estimate.keyframes.lower_bound({vehicle, 0});
  for (auto it = begin; it != estimate.keyframes.end() && it->first.vehicle == vehicle; ++it) {
    vehicle::KeyframeCorrected corrected;
    corrected.id = it->first;
    corrected.t = it->second.t;
    corrected.T_odom_body = T_odom_map * it->second.T_map_body;
    corrected.covariance = turn * it->second.covariance * turn.transpose();
    path.keyframes[it->first.seq] = corrected;
  }
  return path;
}

void join_path(const fleet::FleetEstimate& estimate, VehicleId vehicle, VehicleRun& run) {
  JointPath path = joint_path(estimate, vehicle);
  if (!path.keyframes.empty()) run.join(path.T_map_odom, std::move(path.keyframes));
}

}  // namespace rali::drive
