#include "rali/odometry/robust/range_noise.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "rali/geometry/types.hpp"

namespace rali::odometry {

using geometry::Vec3f;

namespace {

constexpr std::size_t kTriplesMin = 500;
constexpr std::size_t kTriplesMax = 20000;
constexpr float kStepMax_rad = 0.02F;  // between neighbours of one ring
constexpr float kGrazing = 2.0F;       // maximum change of range, relative to the arc
constexpr double kMedianOfNormal = 0.6745;

/// The last two returns of a laser.
struct Last {
  Vec3f a, b;
  float range_a_m = 0.0F, range_b_m = 0.0F;
  int count = 0;
};

/// Neighbours on one surface: a small angle apart, with a range difference of at most a slanted
/// wall.
bool is_near(const Vec3f& p, float p_m, const Vec3f& q, float q_m, float& angle_rad) {
  const float cosine = p.dot(q) / (p_m * q_m);
  angle_rad = std::sqrt(std::max(0.0F, 2.0F * (1.0F - cosine)));
  return angle_rad > 1e-5F && angle_rad < kStepMax_rad &&
         std::abs(p_m - q_m) < 0.15F + kGrazing * angle_rad * p_m;
}

}  // namespace

std::optional<double> measure_range_noise(const sensor::LidarScan& scan) {
  if (!scan.has_rings) return std::nullopt;
  std::vector<Last> lasers;
  std::vector<float> second_m;
  for (std::size_t i = 0; i < scan.size() && second_m.size() < kTriplesMax; ++i) {
    const Vec3f p(scan.x_m[i], scan.y_m[i], scan.z_m[i]);
    const float range_m = p.norm();
    if (!(range_m > 0.0F)) continue;
    if (scan.ring[i] >= lasers.size()) lasers.resize(scan.ring[i] + std::size_t{1});
    Last& last = lasers[scan.ring[i]];
    float before_rad = 0.0F;
    float now_rad = 0.0F;
    if (last.count >= 2 && is_near(last.a, last.range_a_m, last.b, last.range_b_m, before_rad) &&
        is_near(last.b, last.range_b_m, p, range_m, now_rad) && now_rad < 1.3F * before_rad &&
        before_rad < 1.3F * now_rad) {
      second_m.push_back(std::abs(range_m - 2.0F * last.range_b_m + last.range_a_m));
    }
    last = {last.b, p, last.range_b_m, range_m, last.count + 1};
  }
  if (second_m.size() < kTriplesMin) return std::nullopt;
  // Edges are few, so the median ignores them.
  const auto middle = second_m.begin() + static_cast<std::ptrdiff_t>(second_m.size() / 2);
  std::nth_element(second_m.begin(), middle, second_m.end());
  return static_cast<double>(*middle) / (kMedianOfNormal * std::sqrt(6.0));
}

}  // namespace rali::odometry
