#include "rali/vehicle/fact_writer.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace rali::vehicle {

namespace {

/// Full scale of sensors is 1, 100, 255 or 65535; a message has one byte.
std::uint8_t to_byte(float intensity) {
  const float full = intensity > 255.0F ? 257.0F : 1.0F;
  const float scaled = std::isfinite(intensity) ? intensity / full : 0.0F;
  return static_cast<std::uint8_t>(std::clamp(std::round(scaled), 0.0F, 255.0F));
}

}  // namespace

FactWriter::FactWriter(VehicleId self, const VehicleSettings& settings)
    : self_(self), settings_(settings.facts), start_{settings.name, settings.antennas_body_m} {}

void FactWriter::add(Time t, const std::optional<PathNode>& node,
                     const odometry::Keyframe* keyframe,
                     const std::vector<fleet::RangeEntry>& ranges, OutputList& out) {
  if (next_ == 0) write(t, start_, out);
  if (node) {
    write(node->t, node->step, out);
    if (keyframe != nullptr && node->step.keyframe) {
      write(node->t, points_of(*node->step.keyframe, *keyframe), out);
    }
  }
  for (const fleet::RangeEntry& range : ranges) {
    const bool full = !ranges_.ranges.empty() &&
                      (range.t - ranges_.ranges.front().t).s() >= settings_.range_block_s;
    if (full) write_ranges(out);
    ranges_.ranges.push_back(range);
  }
}

void FactWriter::flush(OutputList& out) { write_ranges(out); }

void FactWriter::write_ranges(OutputList& out) {
  if (ranges_.ranges.empty()) return;
  const Time t = ranges_.ranges.back().t;
  write(t, std::exchange(ranges_, {}), out);
}

void FactWriter::write(Time t, fleet::FactBody body, OutputList& out) {
  fleet::Fact fact{{self_, settings_.epoch, next_++}, t, std::move(body)};
  out.emplace_back(FactMade{std::make_shared<const fleet::Fact>(std::move(fact))});
}

/// Thinned by bundles of rays: the choice of a point in a bundle does not depend on its range
/// error.
fleet::KeyframePoints FactWriter::points_of(std::uint32_t number,
                                            const odometry::Keyframe& keyframe) {
  const odometry::KeyframeCloud& cloud = keyframe.cloud;
  fleet::KeyframePoints points;
  points.keyframe = number;
  points.T_body_lidar = keyframe.T_body_lidar;
  const Eigen::Vector3f origin = keyframe.T_body_lidar.p.cast<float>();
  std::vector<float> x(cloud.x_m), y(cloud.y_m), z(cloud.z_m);
  for (float& v : x) v -= origin.x();
  for (float& v : y) v -= origin.y();
  for (float& v : z) v -= origin.z();
  std::vector<std::uint32_t> kept;
  sampler_.sample_rays({x.data(), y.data(), z.data(), x.size()}, {}, settings_.spacing_m, kept);
  fleet::PointArrays chosen;
  for (const std::uint32_t i : kept) {
    chosen.push_back(cloud.x_m[i], cloud.y_m[i], cloud.z_m[i]);
    chosen.intensity.push_back(to_byte(cloud.intensity[i]));
  }
  points.points = fleet::PackedPoints(chosen);
  return points;
}

}  // namespace rali::vehicle
