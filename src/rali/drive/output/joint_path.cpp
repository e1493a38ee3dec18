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
  path.T_map_local = frame->T_map_odom;
  const geometry::SE3 T_odom_map = frame->T_map_odom.inverse();
  // Rotation is perturbed in the body, position in the outer frame: only the position part rotates.
  geometry::Mat6 turn = geometry::Mat6::Identity();
  turn.bottomRightCorner<3, 3>() = T_odom_map.R;
  const auto begin = estimate.keyframes.lower_bound({vehicle, 0});
  for (auto it = begin; it != estimate.keyframes.end() && it->first.vehicle == vehicle; ++it) {
    vehicle::KeyframeCorrected corrected;
    corrected.id = it->first;
    corrected.t = it->second.t;
    corrected.T_local_body = T_odom_map * it->second.T_map_body;
    corrected.covariance = turn * it->second.covariance * turn.transpose();
    path.keyframes[it->first.seq] = corrected;
  }
  return path;
}

void join_path(const fleet::FleetEstimate& estimate, VehicleId vehicle, VehicleRun& run) {
  JointPath path = joint_path(estimate, vehicle);
  if (!path.keyframes.empty()) run.join(path.T_map_local, std::move(path.keyframes));
}

void share_levels(const fleet::FleetEstimate& estimate, std::vector<VehicleRun>& runs) {
  for (const std::vector<VehicleId>& group : estimate.groups) {
    const bool levelled = std::any_of(group.begin(), group.end(),
                                      [&](VehicleId id) { return runs[id.value].knows_gravity(); });
    for (const VehicleId id : group) {
      if (levelled) runs[id.value].share_level();
    }
  }
}

void add_absent(std::size_t vehicles, fleet::FleetEstimate& estimate) {
  for (std::size_t i = 0; i < vehicles; ++i) {
    const VehicleId id{static_cast<std::uint16_t>(i)};
    const auto place = std::lower_bound(
        estimate.frames.begin(), estimate.frames.end(), id,
        [](const fleet::VehicleFrame& frame, VehicleId v) { return frame.vehicle < v; });
    if (place != estimate.frames.end() && place->vehicle == id) continue;
    fleet::VehicleFrame frame;
    frame.vehicle = id;
    frame.group = estimate.groups.size();
    frame.waits_for = "it has no path";
    estimate.frames.insert(place, frame);
    estimate.groups.push_back({id});
  }
}

}  // namespace rali::drive
