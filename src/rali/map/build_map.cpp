#include "rali/map/build_map.hpp"

#include <utility>

#include "rali/map/map_builder.hpp"
#include "rali/map/motion_filter.hpp"

namespace rali::map {
namespace {

void add_grid(const GridBuilder& builder, MapResult& out, FindingList& findings) {
  Result<CellMap> grid = builder.finish();
  if (grid) {
    out.grid = std::move(*grid);
    return;
  }
  Finding finding;
  finding.id = "map.grid";
  finding.text = grid.error().what;
  finding.effect = "there is no 2-D grid";
  finding.remedy = grid.error().remedy;
  findings.push_back(std::move(finding));
}

/// The second pass: tests each keyframe's rays against the places that the first has collected.
Result<std::vector<KeyframeLooks>> look_again(const KeyframeStream& keyframes, MotionFilter& motion,
                                              Executor& executor) {
  std::vector<KeyframeLooks> out;
  const Status read = keyframes([&](const KeyframeView& keyframe) {
    motion.look(keyframe, executor);
    out.push_back({keyframe.vehicle, keyframe.t, {}, {}});
  });
  if (!read) return tl::make_unexpected(read.error());
  const std::vector<WallLooks> walls = motion.walls_seen();
  const std::vector<WallsMade> made = motion.walls_made();
  for (std::size_t i = 0; i < out.size() && i < made.size(); ++i) {
    out[i].walls = walls[i];
    out[i].made = made[i];
  }
  return out;
}

}  // namespace

Result<std::vector<KeyframeLooks>> look_at_walls(const KeyframeStream& keyframes,
                                                 const DynamicSettings& settings,
                                                 Executor& executor) {
  MotionFilter motion(settings);
  const Status read = keyframes([&](const KeyframeView& keyframe) { motion.collect(keyframe); });
  if (!read) return tl::make_unexpected(read.error());
  return look_again(keyframes, motion, executor);
}

Result<MapResult> build_map(const KeyframeStream& keyframes, const MapSettings& settings,
                            Executor& executor, FindingList& findings) {
  MapResult out;
  MapBuilder builder(settings);
  GridBuilder grid(settings.grid);
  MotionFilter motion(settings.dynamic);
  const Status first = keyframes([&](const KeyframeView& keyframe) {
    ++out.keyframes;
    builder.add(keyframe);
    if (settings.grid.make) grid.add(keyframe);
    motion.collect(keyframe);
  });
  if (!first) return tl::make_unexpected(first.error());
  if (out.keyframes == 0) {
    return fail(ErrorCode::kInput, "", "there is no keyframe to make a map of");
  }
  Result<std::vector<KeyframeLooks>> looks = look_again(keyframes, motion, executor);
  if (!looks) return tl::make_unexpected(looks.error());
  out.looks = std::move(*looks);
  if (settings.dynamic.remove) motion.decide(findings);
  MapBuilder::Parts parts = builder.finish(
      [&motion](const geometry::Vec3& p_map) { return motion.is_removed(p_map); }, findings);
  out.map = std::move(parts.map);
  out.removed = std::move(parts.removed);
  if (settings.grid.make) add_grid(grid, out, findings);
  out.thickness = wall_thickness(out.map);
  return out;
}

}  // namespace rali::map
