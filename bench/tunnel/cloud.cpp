#include "cloud.hpp"

#include <map>

#include "errors.hpp"
#include "rali/map/build_map.hpp"

namespace rali::tunnel {

namespace {

eval::TriangleMesh mesh_of(const sim::TriangleMesh& world) {
  eval::TriangleMesh mesh;
  mesh.triangles = world.triangles;
  for (const auto& v : world.vertices) mesh.vertices.push_back(v.cast<double>());
  return mesh;
}

/// All keyframes at their poses in the smoothed trajectory.
map::KeyframeStream stream_of(const Track& track) {
  return [&track](const map::KeyframeVisitor& visit) -> Status {
    std::map<std::uint32_t, const drive::KeyframeRecord*> records;
    for (const drive::KeyframeRecord& r : track.keyframes) records[r.id.seq] = &r;
    for (const KeyframeKept& kept : track.clouds) {
      const drive::KeyframeRecord& record = *records.at(kept.id.seq);
      const odometry::KeyframeCloud& cloud = kept.keyframe->cloud;
      map::KeyframeView view;
      view.t = record.t;
      view.T_map_body = record.T_local_body;
      view.covariance = record.covariance;
      view.T_body_lidar = record.T_body_lidar;
      view.x_m = cloud.x_m;
      view.y_m = cloud.y_m;
      view.z_m = cloud.z_m;
      view.intensity = cloud.intensity;
      view.ring = cloud.ring;
      visit(view);
    }
    return {};
  };
}

}  // namespace

Result<eval::CloudToMesh> compare_cloud(const Track& track, const sim::TriangleMesh& world) {
  SerialExecutor executor;
  map::MapSettings settings;
  settings.grid.make = false;
  FindingList findings;
  const auto made = map::build_map(stream_of(track), settings, executor, findings);
  if (!made) return tl::make_unexpected(made.error());
  const map::MapCloud& cloud = made->map;
  eval::PointList points;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    points.push_back(cloud.origin_map_m +
                     geometry::Vec3f(cloud.x_m[i], cloud.y_m[i], cloud.z_m[i]).cast<double>());
  }
  const auto judged = judge(track.smoothed, track.truth, track.truth.back().t);
  if (!judged) return tl::make_unexpected(judged.error());
  const eval::TriangleMesh mesh = mesh_of(world);
  if (auto ok = eval::check_mesh(mesh, "world"); !ok) return tl::make_unexpected(ok.error());
  const eval::TriangleTree tree(mesh);
  const auto icp = eval::align_to_mesh(points, best_alignment(*judged), tree, {}, executor);
  if (!icp) return tl::make_unexpected(icp.error());
  return eval::cloud_to_mesh(points, icp->T_mesh_cloud, mesh, tree, {}, executor);
}

}  // namespace rali::tunnel
