#include "cloud.hpp"

#include "rali/drive/output/final_path.hpp"
#include "rali/eval/alignment.hpp"
#include "rali/map/build_map.hpp"
#include "truth.hpp"

namespace rali::fleet_bench {

namespace {

eval::TriangleMesh mesh_of(const sim::TriangleMesh& world) {
  eval::TriangleMesh mesh;
  mesh.triangles = world.triangles;
  for (const auto& v : world.vertices) mesh.vertices.push_back(v.cast<double>());
  return mesh;
}

/// Poses of the other vehicles, passed to the map as by write_map_files().
std::vector<geometry::Vec3> others_at(const Joined& joined, VehicleId vehicle, Time t) {
  std::vector<geometry::Vec3> others_map_m;
  for (const VehicleId id : joined.estimate.groups.front()) {
    if (id == vehicle) continue;
    const Path& path = joined.paths[id.value];
    const auto T_map_body = drive::FinalPath(path.poses, path.T_map_odom).at(t);
    if (T_map_body) others_map_m.push_back(T_map_body->p);
  }
  return others_map_m;
}

map::KeyframeStream stream_of(const Mission& mission, const Joined& joined) {
  return [&mission, &joined](const map::KeyframeVisitor& visit) -> Status {
    for (const VehicleId id : joined.estimate.groups.front()) {
      const Path& path = joined.paths[id.value];
      const Driven& driven = mission.vehicles[id.value];
      geometry::Mat6 turn = geometry::Mat6::Identity();
      turn.bottomRightCorner<3, 3>() = path.T_map_odom.R;
      for (std::size_t k = 0; k < path.keyframes.size(); ++k) {
        const drive::KeyframeRecord& record = path.keyframes[k];
        const Points& points = driven.points[k];
        map::KeyframeView view;
        view.t = record.t;
        view.vehicle = static_cast<std::uint8_t>(id.value);
        view.T_map_body = path.T_map_odom * record.T_local_body;
        view.covariance = turn * record.covariance * turn.transpose();
        view.T_body_lidar = record.T_body_lidar;
        view.x_m = points.x_m;
        view.y_m = points.y_m;
        view.z_m = points.z_m;
        view.intensity = points.intensity;
        view.ring = points.ring;
        const auto others_map_m = others_at(joined, id, record.t);
        view.others_map_m = others_map_m;
        visit(view);
      }
    }
    return {};
  };
}

}  // namespace

Result<eval::CloudToMesh> compare_cloud(const Mission& mission, const Joined& joined,
                                        const sim::TriangleMesh& world) {
  SerialExecutor executor;
  map::MapSettings settings;
  settings.grid.make = false;
  FindingList findings;
  const auto made = map::build_map(stream_of(mission, joined), settings, executor, findings);
  if (!made) return tl::make_unexpected(made.error());
  const map::MapCloud& cloud = made->map;
  eval::PointList points;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    points.push_back(cloud.origin_map_m +
                     geometry::Vec3f(cloud.x_m[i], cloud.y_m[i], cloud.z_m[i]).cast<double>());
  }
  eval::PairList pairs;
  for (const VehicleId id : joined.estimate.groups.front()) {
    const auto own = pairs_of(mission.vehicles[id.value], joined.paths[id.value]);
    pairs.insert(pairs.end(), own.begin(), own.end());
  }
  auto T_world_map = eval::align(pairs, eval::Alignment::kSe3);
  if (!T_world_map) T_world_map = eval::align(pairs, eval::Alignment::kOrigin);
  if (!T_world_map) return tl::make_unexpected(T_world_map.error());
  const eval::TriangleMesh mesh = mesh_of(world);
  if (auto ok = eval::check_mesh(mesh, "world"); !ok) return tl::make_unexpected(ok.error());
  const eval::TriangleTree tree(mesh);
  const auto icp = eval::align_to_mesh(points, *T_world_map, tree, {}, executor);
  if (!icp) return tl::make_unexpected(icp.error());
  return eval::cloud_to_mesh(points, icp->T_mesh_cloud, mesh, tree, {}, executor);
}

}  // namespace rali::fleet_bench
