#include "rali/drive/output/map_files.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "rali/drive/output/final_path.hpp"
#include "rali/drive/output/rounds_files.hpp"
#include "rali/io/files/cloud_writers.hpp"
#include "rali/io/files/grid_file.hpp"
#include "rali/map/build_map.hpp"

namespace rali::drive {
namespace {

io::MapColumns columns(const map::MapCloud& cloud) {
  return {cloud.x_m,     cloud.y_m,  cloud.z_m,    cloud.intensity,
          cloud.sigma_m, cloud.seen, cloud.vehicle};
}

/// The map in site coordinates, in parts so that it is not in memory twice. Site coordinates do not
/// fit a float: they are stored relative to the map's origin on the site.
class SiteParts {
 public:
  SiteParts(const map::MapCloud& cloud, const SiteFrame& site)
      : cloud_(cloud), R_site_map_(geometry::rotation_from_rpy(0.0, 0.0, site.yaw_rad)) {}

  bool next(io::MapColumns& out) {
    constexpr std::size_t kPart = 65536;
    const std::size_t n = std::min(kPart, cloud_.size() - at_);
    if (n == 0) return false;
    for (std::vector<float>& column : site_m_) column.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t k = at_ + i;
      const geometry::Vec3 p =
          R_site_map_ * geometry::Vec3(cloud_.x_m[k], cloud_.y_m[k], cloud_.z_m[k]);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        site_m_[axis][i] = static_cast<float>(p[static_cast<Eigen::Index>(axis)]);
      }
    }
    const auto part = [&](const auto& column) { return std::span(column).subspan(at_, n); };
    out = {site_m_[0],           site_m_[1],        site_m_[2],          part(cloud_.intensity),
           part(cloud_.sigma_m), part(cloud_.seen), part(cloud_.vehicle)};
    at_ += n;
    return true;
  }

 private:
  const map::MapCloud& cloud_;
  geometry::Mat3 R_site_map_;
  std::size_t at_ = 0;
  std::array<std::vector<float>, 3> site_m_;
};

Status write_las(const map::MapCloud& cloud, const std::optional<SiteFrame>& site,
                 const std::string& path) {
  io::LasOptions options;
  const geometry::Vec3 shift = site ? site->site_of(cloud.origin_map_m) : cloud.origin_map_m;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    options.shift_m[axis] = shift[static_cast<Eigen::Index>(axis)];
  }
  options.intensity_scale = io::las_intensity_scale(cloud.intensity);
  if (!site) return io::write_map_las(path, cloud.size(), io::one_part(columns(cloud)), options);
  return io::write_map_las(
      path, cloud.size(),
      [parts = SiteParts(cloud, *site)](io::MapColumns& out) mutable -> Result<bool> {
        return parts.next(out);
      },
      options);
}

Status write_clouds(const map::MapResult& result, const MapJob& job,
                    const std::optional<SiteFrame>& site) {
  const map::MapCloud& map = result.map;
  if (site) {
    if (Status s = write_las(map, site, job.out_dir + "/map.las"); !s) return s;
  }
  for (const std::string& format : job.formats) {
    const std::string path = job.out_dir + "/map." + format;
    Status status;
    if (format == "pcd") status = io::write_map_pcd(path, map.size(), io::one_part(columns(map)));
    if (format == "ply") status = io::write_map_ply(path, map.size(), io::one_part(columns(map)));
    if (format == "las" && !site) status = write_las(map, site, path);
    if (!status) return status;
  }
  return io::write_map_pcd(job.out_dir + "/removed.pcd", result.removed.size(),
                           io::one_part(columns(result.removed)));
}

io::GridCell file_cell(map::CellState state) {
  switch (state) {
    case map::CellState::kFree:
      return io::GridCell::kFree;
    case map::CellState::kOccupied:
      return io::GridCell::kOccupied;
    case map::CellState::kUnknown:
      break;
  }
  return io::GridCell::kUnknown;
}

Status write_grid_files(const map::CellMap& grid, const std::string& out_dir) {
  std::vector<io::GridCell> cells(grid.cells.size());
  std::transform(grid.cells.begin(), grid.cells.end(), cells.begin(), file_cell);
  io::GridView view;
  view.width = static_cast<std::uint32_t>(grid.width);
  view.height = static_cast<std::uint32_t>(grid.height);
  view.cell_m = grid.cell_m;
  view.origin_x_m = grid.origin_map_m.x();
  view.origin_y_m = grid.origin_map_m.y();
  view.cells = cells;
  return io::write_grid(out_dir + "/map_2d", view);
}

/// Positions of the other vehicles' bodies at t.
std::vector<geometry::Vec3> others_at(const std::vector<const VehicleRun*>& runs, VehicleId vehicle,
                                      Time t) {
  std::vector<geometry::Vec3> others_map_m;
  for (const VehicleRun* run : runs) {
    if (run->keyframes().empty() || run->keyframes().front().id.vehicle == vehicle) continue;
    const auto T_map_body = FinalPath(run->poses(), run->T_map_local()).at(t);
    if (T_map_body) others_map_m.push_back(T_map_body->p);
  }
  return others_map_m;
}

}  // namespace

// By time: each point belongs to the vehicle that observed it first, not all to the first vehicle.
map::KeyframeStream map_stream(const std::vector<const VehicleRun*>& runs, const MapJob& job) {
  return [&runs, &job](const map::KeyframeVisitor& visit) {
    const FleetRunView fleet{nullptr, runs, job.out_dir};
    return walk_keyframes(fleet, [&](KeyframeId id, const map::KeyframeView& keyframe) {
      map::KeyframeView seen = keyframe;
      std::vector<geometry::Vec3> others_map_m;
      if (job.known.common_clock) others_map_m = others_at(runs, id.vehicle, keyframe.t);
      seen.others_map_m = others_map_m;
      visit(seen);
      return Status{};
    });
  };
}

Result<MapNumbers> write_map_files(const std::vector<const VehicleRun*>& runs, const MapJob& job,
                                   const std::optional<SiteFrame>& site, Executor& executor,
                                   FindingList& findings) {
  Result<map::MapResult> result =
      map::build_map(map_stream(runs, job), job.map, executor, findings);
  if (!result) return tl::make_unexpected(result.error());
  if (Status s = write_clouds(*result, job, site); !s) return tl::make_unexpected(s.error());
  if (result->grid) {
    if (Status s = write_grid_files(*result->grid, job.out_dir); !s) {
      return tl::make_unexpected(s.error());
    }
  }
  return MapNumbers{result->map.size(), result->removed.size(), result->thickness.median_m,
                    std::move(result->looks)};
}

}  // namespace rali::drive
