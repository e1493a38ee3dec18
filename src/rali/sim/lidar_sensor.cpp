#include "rali/sim/lidar_sensor.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

namespace rali::sim {

using geometry::SE3;
using geometry::Vec3;

LidarOptions LidarOptions::of(Lidar kind) {
  LidarOptions o;
  const auto set = [&](double sigma_m, double step_m, double near_m, double far_m) {
    o.noise_m = sigma_m;
    o.resolution_m = step_m;
    o.min_range_m = near_m;
    o.max_range_m = far_m;
  };
  if (kind == Lidar::kRs16) set(0.02, 0.005, 0.4, 150.0);
  if (kind == Lidar::kVlp16) set(0.03, 0.002, 0.4, 100.0);
  if (kind == Lidar::kHdl32e) set(0.02, 0.002, 1.0, 100.0);
  if (kind == Lidar::kHdl64e) set(0.02, 0.002, 0.9, 120.0);
  if (kind == Lidar::kOs1_64) set(0.015, 0.003, 0.8, 120.0);
  if (kind == Lidar::kOs0_128) set(0.015, 0.001, 0.3, 50.0);
  if (kind == Lidar::kLivox) set(0.02, 0.002, 0.5, 130.0);
  return o;
}

LidarSensor::LidarSensor(Lidar kind, const LidarOptions& options, std::uint64_t seed)
    : model_(kind),
      lasers_(kind),
      options_(options),
      noise_(seed, "lidar noise"),
      drop_(seed, "lidar drop"),
      edge_(seed, "lidar edge"),
      before_m_(static_cast<std::size_t>(model_.rings()), 0.0F) {
  Rng lasers(seed, "lasers");
  std::vector<double> raised_rad;
  for (int ring = 0; ring < model_.rings(); ++ring) {
    laser_offset_m_.push_back(options.laser_offset_m * lasers.normal());
    raised_rad.push_back(options.laser_elevation_deg * lasers.normal() * std::numbers::pi / 180.0);
  }
  lasers_.raise_rings(raised_rad);
}

/// @param neighbour_m  true range of the same laser one firing before, 0 if none
double LidarSensor::measured_range_m(const Hit& hit, std::size_t ring, float neighbour_m) {
  if (hit.range_m <= 0.0F) return 0.0;
  double range = static_cast<double>(hit.range_m);
  if (options_.dropouts) {
    // Received light of a matt surface relative to the limit: 20 % white at max_range, normal
    // incidence.
    const double reach = options_.max_range_m / range;
    const double light = static_cast<double>(hit.reflectivity) / 0.2 *
                         static_cast<double>(hit.cos_incidence) * reach * reach;
    if (light < 3.0 && drop_.uniform() > 1.0 - std::exp(-3.0 * light)) return 0.0;
  }
  if (options_.mixed_fraction > 0.0 && neighbour_m > 0.0F) {
    // The beam is about as wide as the step between firings, so at an edge it hits both surfaces.
    // If these are less than a pulse length apart, the sensor reports a range between them.
    const double gap = static_cast<double>(neighbour_m) - range;
    if (std::abs(gap) > 0.15 && std::abs(gap) < 1.5 && edge_.uniform() < options_.mixed_fraction) {
      range += edge_.uniform() * gap;
    }
  }
  range += laser_offset_m_[ring] + options_.noise_m * noise_.normal();
  return range < options_.min_range_m || range > options_.max_range_m ? 0.0 : range;
}

void LidarSensor::cast_block(std::int64_t number, double start_s, const PoseAt& pose_at,
                             const RayCaster& world, Scratch& scratch, int begin, int end) {
  const int rings = model_.rings();
  const double period_s = model_.scan_s() / model_.firings();
  const std::size_t first = static_cast<std::size_t>(begin) * static_cast<std::size_t>(rings);
  const std::size_t count = static_cast<std::size_t>(end - begin) * static_cast<std::size_t>(rings);
  scratch.rays.resize(count);
  const std::span<Hit> hits(&hits_[first], count);
  Ray* ray = scratch.rays.data();
  SE3 now = pose_at(start_s + begin * period_s);
  for (int firing = begin; firing < end; ++firing) {
    const SE3 next = pose_at(start_s + (firing + 1) * period_s);
    for (int ring = 0; ring < rings; ++ring, ++ray) {
      const double phase = model_.phase(ring);
      const Vec3 beam = lasers_.beam(ring, firing, number).cast<double>();
      // Within 0.1 ms linear interpolation of the pose is exact to far below a micrometre.
      ray->origin = now.p + phase * (next.p - now.p);
      ray->direction = now.R * beam + phase * (next.R * beam - now.R * beam);
    }
    now = next;
  }
  world.cast_all(scratch.rays, options_.max_range_m + 1.0, hits);
  if (scratch.others.empty()) return;
  // A block lasts 2 ms: a person walks less than 3 mm. Vehicles are placed for each firing.
  scratch.others.place_people_at(start_s + begin * period_s);
  for (std::size_t i = 0; i < count; ++i) {
    if (i % static_cast<std::size_t>(rings) == 0) {
      const auto firing = begin + static_cast<int>(i) / rings;
      scratch.others.place_vehicles_at(start_s + (firing + 0.5) * period_s);
    }
    scratch.others.cast(scratch.rays[i].origin, scratch.rays[i].direction, hits[i]);
  }
}

const RawScan& LidarSensor::measure_scan(std::int64_t number, double start_s, const PoseAt& pose_at,
                                         const RayCaster& world, const MovingScene& others,
                                         Executor& executor) {
  constexpr std::size_t kBlock = 32;
  const auto firings = static_cast<std::size_t>(model_.firings());
  const auto rings = static_cast<std::size_t>(model_.rings());
  hits_.resize(firings * rings);
  scratch_.resize((firings + kBlock - 1) / kBlock);
  for (Scratch& s : scratch_) s.others = others;
  executor.for_blocks(firings, kBlock, [&](std::size_t block, std::size_t begin, std::size_t end) {
    cast_block(number, start_s, pose_at, world, scratch_[block], static_cast<int>(begin),
               static_cast<int>(end));
  });
  raw_.number = number;
  raw_.range_steps.resize(hits_.size());
  raw_.intensity.resize(hits_.size());
  for (std::size_t i = 0; i < hits_.size(); ++i) {
    const Hit& hit = hits_[i];
    const std::size_t ring = i % rings;
    float& neighbour = before_m_[ring];
    const double range = measured_range_m(hit, ring, neighbour);
    neighbour = hit.range_m;
    raw_.range_steps[i] = static_cast<std::uint16_t>(std::lround(range / options_.resolution_m));
    raw_.intensity[i] = static_cast<std::uint8_t>(255.0F * hit.reflectivity * hit.cos_incidence);
  }
  return raw_;
}

std::shared_ptr<const sensor::LidarScan> expand(const RawScan& raw, const LidarModel& model,
                                                double resolution_m, Time t_start) {
  auto scan = std::make_shared<sensor::LidarScan>();
  const double period_s = model.scan_s() / model.firings();
  scan->reserve(raw.range_steps.size());
  scan->t_start = t_start;
  scan->has_point_times = true;
  scan->has_rings = true;
  scan->rings = static_cast<std::uint16_t>(model.rings());
  for (int firing = 0; firing < model.firings(); ++firing) {
    const std::size_t first = static_cast<std::size_t>(firing * model.rings());
    for (const int ring : model.order()) {
      const std::uint16_t steps = raw.range_steps[first + static_cast<std::size_t>(ring)];
      if (steps == 0) {
        ++scan->dropped_range;
        continue;
      }
      const float range_m = static_cast<float>(steps * resolution_m);
      const geometry::Vec3f p = range_m * model.beam(ring, firing, raw.number);
      const float intensity =
          static_cast<float>(raw.intensity[first + static_cast<std::size_t>(ring)]);
      scan->push_back(p.x(), p.y(), p.z(), intensity,
                      static_cast<float>((firing + model.phase(ring)) * period_s),
                      static_cast<std::uint16_t>(ring));
    }
  }
  const float last_s = scan->dt_s.empty() ? 0.0F : scan->dt_s.back();
  scan->t_end = t_start + Duration::from_s(static_cast<double>(last_s));
  return scan;
}

}  // namespace rali::sim
