#include "rali/map/map_builder.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include <fmt/format.h>

#include "rali/map/point_error.hpp"

namespace rali::map {
namespace {

constexpr double kBytesPerMb = 1e6;
/// Beyond this float32 has steps above 0.25 mm.
constexpr double kFloatReach_m = 4000.0;

float mean_with(float mean, float value, std::uint32_t count) {
  return mean + (value - mean) / static_cast<float>(count);
}

}  // namespace

MapBuilder::MapBuilder(const MapSettings& settings)
    : settings_(settings), lattice_m_(settings.voxel_m > 0.0 ? settings.voxel_m : 1.0) {}

void MapBuilder::add(const KeyframeView& keyframe) {
  if (!is_usable(keyframe)) {
    ++keyframes_refused_;
    return;
  }
  ++keyframes_;
  const PointError error(keyframe.covariance, keyframe.T_map_body.R);
  const double range_m2 = settings_.range_sigma_m * settings_.range_sigma_m;
  const double bearing_rad2 = 2.0 * settings_.bearing_sigma_rad * settings_.bearing_sigma_rad;
  const double systematic_m2 = settings_.systematic_m * settings_.systematic_m;
  for (std::size_t i = 0; i < keyframe.size(); ++i) {
    const geometry::Vec3 p_body = keyframe.point_body(i);
    const geometry::Vec3 p_map = keyframe.T_map_body * p_body;
    const VoxelKey key = voxel_key(p_map, lattice_m_);
    if (key == kNoVoxel) {
      ++points_refused_;
      continue;
    }
    const double squared_range_m2 = (p_body - keyframe.T_body_lidar.p).squaredNorm();
    const double shared_m = std::sqrt(error.variance_m2(p_body) + systematic_m2);
    const double noise_m2 = range_m2 + bearing_rad2 * squared_range_m2;
    const float intensity = keyframe.intensity.empty() ? 0.0F : keyframe.intensity[i];
    add_sample({key, p_map, std::isfinite(intensity) ? intensity : 0.0F,
                static_cast<float>(shared_m), static_cast<float>(noise_m2)},
               keyframe.vehicle);
  }
}

void MapBuilder::add_sample(const Sample& sample, std::uint8_t vehicle) {
  Cell* cell = cell_for(sample.key);
  if (cell == nullptr) {
    ++points_no_room_;
    return;
  }
  if (cell->count == 0) cell->vehicle = vehicle;
  const geometry::Vec3 offset = sample.p_map_m - voxel_corner(sample.key, lattice_m_);
  ++cell->count;
  cell->x_m = mean_with(cell->x_m, static_cast<float>(offset.x()), cell->count);
  cell->y_m = mean_with(cell->y_m, static_cast<float>(offset.y()), cell->count);
  cell->z_m = mean_with(cell->z_m, static_cast<float>(offset.z()), cell->count);
  cell->intensity = mean_with(cell->intensity, sample.intensity, cell->count);
  cell->sigma_shared_m = mean_with(cell->sigma_shared_m, sample.sigma_shared_m, cell->count);
  cell->noise_sum_m2 += sample.noise_m2;
  if (cell->last_keyframe != keyframes_) {
    cell->last_keyframe = keyframes_;
    if (cell->seen < 0xffff) ++cell->seen;
  }
}

MapBuilder::Cell* MapBuilder::cell_for(VoxelKey key) {
  if (settings_.voxel_m > 0.0) {
    if (const auto known = index_.find(key)) return &cells_[*known];
  }
  if (!has_room()) return nullptr;
  if (settings_.voxel_m > 0.0) static_cast<void>(index_.insert(key));
  Cell cell;
  cell.key = key;
  cells_.push_back(cell);
  return &cells_[cells_.size() - 1];
}

bool MapBuilder::has_room() const {
  if (cells_.size() >= 0xfffffffeULL) return false;  // limit of a 32-bit index
  if (settings_.max_memory_mb <= 0.0) return true;
  const std::size_t needed =
      index_.memory_bytes_at_next_insert() + cells_.memory_bytes_at_next_push();
  return static_cast<double>(needed) <= settings_.max_memory_mb * kBytesPerMb;
}

geometry::Vec3 MapBuilder::position(const Cell& cell) const {
  return voxel_corner(cell.key, lattice_m_) + geometry::Vec3{static_cast<double>(cell.x_m),
                                                             static_cast<double>(cell.y_m),
                                                             static_cast<double>(cell.z_m)};
}

geometry::Vec3 MapBuilder::common_origin() const {
  if (cells_.size() == 0) return geometry::Vec3::Zero();
  geometry::Vec3 low = position(cells_[0]), high = low;
  for (std::size_t i = 1; i < cells_.size(); ++i) {
    const geometry::Vec3 p = position(cells_[i]);
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  if (std::max(high.cwiseAbs().maxCoeff(), low.cwiseAbs().maxCoeff()) < kFloatReach_m) {
    return geometry::Vec3::Zero();
  }
  const geometry::Vec3 km = (low + high) * 0.5e-3;
  return geometry::Vec3{std::round(km.x()), std::round(km.y()), std::round(km.z())} * 1e3;
}

void MapBuilder::append(const Cell& cell, const geometry::Vec3& p_map_m, MapCloud& out) {
  const geometry::Vec3 p = p_map_m - out.origin_map_m;
  out.x_m.push_back(static_cast<float>(p.x()));
  out.y_m.push_back(static_cast<float>(p.y()));
  out.z_m.push_back(static_cast<float>(p.z()));
  out.intensity.push_back(cell.intensity);
  const auto n = static_cast<float>(cell.count);
  out.sigma_m.push_back(
      std::sqrt(cell.sigma_shared_m * cell.sigma_shared_m + cell.noise_sum_m2 / (n * n)));
  out.seen.push_back(cell.seen);
  out.vehicle.push_back(cell.vehicle);
}

MapBuilder::Parts MapBuilder::finish(const std::function<bool(const geometry::Vec3&)>& is_removed,
                                     FindingList& findings) const {
  std::vector<std::uint32_t> order(cells_.size());
  std::iota(order.begin(), order.end(), 0U);
  if (settings_.voxel_m > 0.0) {
    std::sort(order.begin(), order.end(),
              [this](std::uint32_t a, std::uint32_t b) { return cells_[a].key < cells_[b].key; });
  }
  Parts parts;
  parts.map.origin_map_m = parts.removed.origin_map_m = common_origin();
  for (const std::uint32_t i : order) {
    const geometry::Vec3 p_map = position(cells_[i]);
    append(cells_[i], p_map, is_removed && is_removed(p_map) ? parts.removed : parts.map);
  }
  report(findings);
  return parts;
}

void MapBuilder::report(FindingList& findings) const {
  const auto add_finding = [&findings](std::string id, Severity severity, std::string text,
                                       std::string effect, std::string remedy, double value) {
    Finding f;
    f.id = std::move(id);
    f.severity = severity;
    f.text = std::move(text);
    f.effect = std::move(effect);
    f.remedy = std::move(remedy);
    f.value = value;
    findings.push_back(std::move(f));
  };
  if (points_no_room_ > 0) {
    add_finding("map.memory", Severity::kError,
                fmt::format("the map reached its limit of {:.0f} MB with {} points; {} measured "
                            "points found no room",
                            settings_.max_memory_mb, cells_.size(), points_no_room_),
                "the map ends where the memory did", "Raise map.max_memory_mb or --map-voxel.",
                static_cast<double>(points_no_room_));
  }
  if (keyframes_refused_ > 0) {
    add_finding("map.keyframe", Severity::kError,
                fmt::format("{} keyframes have a pose or covariance that is not a number",
                            keyframes_refused_),
                "their points are missing in the map", "", static_cast<double>(keyframes_refused_));
  }
  if (points_refused_ > 0) {
    add_finding(
        "map.points", Severity::kWarning,
        fmt::format("{} points are not a number or farther than {:.0f} km from the origin",
                    points_refused_, lattice_m_ * static_cast<double>(kVoxelHalfRange) * 1e-3),
        "they are missing in the map", "", static_cast<double>(points_refused_));
  }
}

}  // namespace rali::map
