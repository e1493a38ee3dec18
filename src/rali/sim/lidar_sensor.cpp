#include "rali/sim/lidar_sensor.hpp"

#include <algorithm>
#include <cmath>

namespace rali::sim {

using geometry::SE3;
using geometry::Vec3;

LidarSensor::LidarSensor(Lidar kind, const LidarOptions& options, std::uint64_t seed)
    : model_(kind),
      options_(options),
      noise_(seed, "lidar noise"),
      drop_(seed, "lidar drop"),
      edge_(seed, "lidar edge"),
      before_m_(static_cast<std::size_t>(model_.rings()), 0.0F) {}

/// @param neighbour_m  true range of the same laser one firing before, 0 if none
double LidarSensor::measured_range_m(const Hit& hit, float neighbour_m) {
  if (hit.range_m <= 0.0F) return 0.0;
  double range = static_cast<double>(hit.range_m);
  if (options_.dropouts) {
    // Received light of a matt surface against the limit 20 % white at max_range, head on.
    const double reach = options_.max_range_m / range;
    const double light = static_cast<double>(hit.reflectivity) / 0.2 *
                         static_cast<double>(hit.cos_incidence) * reach * reach;
    if (light < 3.0 && drop_.uniform() > 1.0 - std::exp(-3.0 * light)) return 0.0;
  }
  if (options_.mixed_share > 0.0 && neighbour_m > 0.0F) {
    // The beam is about as wide as the step between firings: at an edge it lights both surfaces,
    // and if these are nearer than a pulse length, the sensor reports something in between.
    const double gap = static_cast<double>(neighbour_m) - range;
    if (std::abs(gap) > 0.15 && std::abs(gap) < 1.5 && edge_.uniform() < options_.mixed_share) {
      range += edge_.uniform() * gap;
    }
  }
  range += options_.noise_m * noise_.normal();
  return range < options_.min_range_m || range > options_.max_range_m ? 0.0 : range;
}

const RawSweep& LidarSensor::measure_sweep(std::int64_t number, const PoseAt& pose_at,
                                           const RayCaster& world, Pedestrians& people) {
  const int rings = model_.rings();
  const double period_s = model_.sweep_s() / model_.firings();
  const double start_s = static_cast<double>(number) * model_.sweep_s();
  raw_.number = number;
  raw_.range_steps.clear();
  raw_.intensity.clear();
  SE3 now = pose_at(start_s);
  for (int firing = 0; firing < model_.firings(); ++firing) {
    // 32 firings are 2 ms: nobody moves by more than 3 mm in between.
    if (!people.empty() && firing % 32 == 0) people.place_at(start_s + firing * period_s);
    const SE3 next = pose_at(start_s + (firing + 1) * period_s);
    for (int ring = 0; ring < rings; ++ring) {
      const double phase = model_.phase(ring);
      const Vec3 beam = model_.beam(ring, firing, number).cast<double>();
      // Within 0.1 ms the pose is a straight line to far below a micrometre.
      const Vec3 origin = now.p + phase * (next.p - now.p);
      const Vec3 direction = now.R * beam + phase * (next.R * beam - now.R * beam);
      Hit hit = world.cast(origin, direction, options_.max_range_m + 1.0);
      if (!people.empty()) people.cast(origin, direction, hit);
      float& neighbour = before_m_[static_cast<std::size_t>(ring)];
      const double range = measured_range_m(hit, neighbour);
      neighbour = hit.range_m;
      raw_.range_steps.push_back(
          static_cast<std::uint16_t>(std::lround(range / options_.resolution_m)));
      raw_.intensity.push_back(
          static_cast<std::uint8_t>(255.0F * hit.reflectivity * hit.cos_incidence));
    }
    now = next;
  }
  return raw_;
}

std::shared_ptr<const sensor::LidarScan> expand(const RawSweep& raw, const LidarModel& model,
                                                double resolution_m, Time t_begin) {
  auto scan = std::make_shared<sensor::LidarScan>();
  const double period_s = model.sweep_s() / model.firings();
  scan->reserve(raw.range_steps.size());
  scan->t_begin = t_begin;
  scan->has_point_times = true;
  scan->has_rings = true;
  scan->rings = static_cast<std::uint16_t>(model.rings());
  std::size_t i = 0;
  for (int firing = 0; firing < model.firings(); ++firing) {
    for (int ring = 0; ring < model.rings(); ++ring, ++i) {
      if (raw.range_steps[i] == 0) {
        ++scan->dropped_range;
        continue;
      }
      const float range_m = static_cast<float>(raw.range_steps[i] * resolution_m);
      const geometry::Vec3f p = range_m * model.beam(ring, firing, raw.number);
      scan->push_back(p.x(), p.y(), p.z(), static_cast<float>(raw.intensity[i]),
                      static_cast<float>((firing + model.phase(ring)) * period_s),
                      static_cast<std::uint16_t>(ring));
    }
  }
  const float last_s = scan->dt_s.empty() ? 0.0F : scan->dt_s.back();
  scan->t_end = t_begin + Duration::from_s(static_cast<double>(last_s));
  return scan;
}

}  // namespace rali::sim
