#pragma once

// Hand-made pieces of paths and results of comparing them.

#include <vector>

#include "rali/fleet/centre/loop_search.hpp"

namespace rali::fleet {

/// One node at the origin of odom.
inline VehiclePath standing(std::uint16_t id) {
  VehiclePath path(VehicleId{id});
  Increment step;
  step.keyframe = 0;
  step.begins = true;
  step.levelled = true;
  path.add(Time::from_s(0), step);
  return path;
}

/// 10 m straight ahead, with a LiDAR that constrains all directions.
inline VehiclePath straight_path(std::uint16_t id) {
  VehiclePath p(VehicleId{id});
  p.add(Time::from_s(0), EpochStart{"v", {geometry::Vec3::Zero()}});
  for (std::uint32_t k = 0; k < 11; ++k) {
    Increment step;
    step.node = k;
    step.begins = k == 0;
    step.keyframe = k;
    step.levelled = true;
    step.T_odom_body.p = {1.0 * k, 0.0, 0.0};
    step.lidar_information.setIdentity();
    step.lidar_information *= 1e6;
    step.covariance.setIdentity();
    step.covariance *= 1e-6;
    p.add(Time::from_s(k), step);
  }
  return p;
}

/// The piece around a node that is a keyframe: a single point, because it is not compared.
inline PathSubmap piece_of(const VehiclePath& path, std::size_t index, std::size_t node) {
  const std::vector<float> x = {1.0F};
  const Increment& step = *path.nodes()[node].step;
  places::PosedScan scan;
  scan.scan.id = {path.vehicle(), *step.keyframe};
  scan.scan.x_m = scan.scan.y_m = scan.scan.z_m = x;
  scan.T_odom_body = step.T_odom_body;
  PathSubmap piece;
  piece.path = index;
  piece.node = node;
  piece.T_odom_ref = step.T_odom_body;
  piece.submap = places::make_submap({&scan, 1}, 0, {}).value();
  return piece;
}

/// A comparison without rival: source in the target, with the same sigma in all directions.
inline LoopFound seen_at(const geometry::Vec3& p_m, std::size_t target, std::size_t source,
                         double sigma) {
  LoopFound found;
  found.candidate = {target, source, std::nullopt};
  found.recognition.certainty = places::Certainty::kUnique;
  places::Placement placement;
  placement.registration.T_target_source.p = p_m;
  placement.registration.information.diagonal().setConstant(1.0 / (sigma * sigma));
  found.recognition.placements = {placement};
  return found;
}

}  // namespace rali::fleet
