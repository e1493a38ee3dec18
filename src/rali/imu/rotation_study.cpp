#include "rali/imu/rotation_study.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/LU>
#include <Eigen/SVD>

namespace rali::imu {
namespace {

constexpr double kGap_s = 0.1;
constexpr double kRadPerDeg = std::numbers::pi / 180.0;
constexpr double kUnexplainedMax = 0.5;
/// Between 1 and 57.3: a gyro whose scale is off by more has another unit.
constexpr double kScaleMax = 7.5;

/// Rotations of the same interval from both sensors.
struct Pairs {
  std::vector<geometry::Vec3> lidar, imu;

  void subtract_means() {
    for (std::vector<geometry::Vec3>* turns : {&lidar, &imu}) {
      geometry::Vec3 mean = geometry::Vec3::Zero();
      for (const geometry::Vec3& turn : *turns) mean += turn;
      mean /= std::max(1.0, static_cast<double>(turns->size()));
      for (geometry::Vec3& turn : *turns) turn -= mean;
    }
  }
};

Pairs pairs_at(std::span<const LidarTurn> lidar, const GyroTrack& gyro, double offset_s) {
  Pairs pairs;
  const Duration offset = Duration::from_s(offset_s);
  for (const LidarTurn& turn : lidar) {
    const auto imu = gyro.turn(turn.begin + offset, turn.end + offset);
    if (!imu || !turn.turn_lidar_rad.allFinite()) continue;
    pairs.lidar.push_back(turn.turn_lidar_rad);
    pairs.imu.push_back(*imu);
  }
  pairs.subtract_means();
  return pairs;
}

/// Kabsch's solution of min |imu - R lidar|^2 and its residual statistics.
struct Kabsch {
  geometry::Mat3 R = geometry::Mat3::Identity();
  double scale = 0.0;      ///< of imu against lidar
  double explained = 0.0;  ///< trace of the rotated cross covariance
  double lidar_square = 0.0, imu_square = 0.0;
};

Kabsch kabsch(const Pairs& pairs) {
  Kabsch out;
  geometry::Mat3 cross = geometry::Mat3::Zero();
  for (std::size_t i = 0; i < pairs.lidar.size(); ++i) {
    cross += pairs.imu[i] * pairs.lidar[i].transpose();
    out.lidar_square += pairs.lidar[i].squaredNorm();
    out.imu_square += pairs.imu[i].squaredNorm();
  }
  const Eigen::JacobiSVD<geometry::Mat3> svd(cross, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double determinant = (svd.matrixU() * svd.matrixV().transpose()).determinant();
  const geometry::Vec3 signs{1.0, 1.0, determinant < 0.0 ? -1.0 : 1.0};
  out.R = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  out.explained = svd.singularValues().dot(signs);
  out.scale = out.lidar_square > 0.0 ? out.explained / out.lidar_square : 0.0;
  return out;
}

/// Fraction of the IMU's rotation that the best rotation and scale leave unexplained: 0..1. It does
/// not depend on the unit, so that deg/s does not spoil the search for the offset.
double unexplained(const Kabsch& fit) {
  const double product = fit.lidar_square * fit.imu_square;
  return product > 0.0 ? 1.0 - fit.explained * fit.explained / product : 1.0;
}

double second_axis(const std::vector<LidarTurn>& turns) {
  geometry::Mat3 S = geometry::Mat3::Zero();
  for (const LidarTurn& t : turns) S += t.turn_lidar_rad * t.turn_lidar_rad.transpose();
  const geometry::Vec3 values = Eigen::JacobiSVD<geometry::Mat3>(S).singularValues();
  return values(0) > 0.0 ? std::sqrt(values(1) / values(0)) : 0.0;
}

struct Offset {
  double offset_s = 0.0, sigma_s = 0.0;
  double unexplained = 1.0;
  double scale = 0.0;         ///< of the gyro against the LiDAR
  double gyro_rms_rad = 0.0;  ///< of its rotations
  bool at_border = false;

  /// Whether the gyro may have the assumed unit.
  [[nodiscard]] bool plausible() const {
    return unexplained <= kUnexplainedMax && scale > 1.0 / kScaleMax && scale < kScaleMax;
  }
};

/// Unexplained fraction over the offset, from -offset_max_s to offset_max_s.
struct FractionCurve {
  std::vector<double> fraction;
  std::size_t pairs = 0;
};

/// The gyro's rotation for each offset of the curve and each LiDAR rotation.
using TurnTable = std::vector<std::vector<std::optional<geometry::Vec3>>>;

TurnTable turn_table(std::span<const LidarTurn> lidar, const GyroTrack& gyro,
                     const RotationStudyLimits& limits) {
  const int half = static_cast<int>(limits.offset_max_s / limits.offset_step_s);
  TurnTable out;
  for (int i = -half; i <= half; ++i) {
    const Duration offset = Duration::from_s(i * limits.offset_step_s);
    std::vector<std::optional<geometry::Vec3>>& turns = out.emplace_back();
    turns.reserve(lidar.size());
    for (const LidarTurn& turn : lidar) {
      turns.push_back(gyro.turn(turn.begin + offset, turn.end + offset));
    }
  }
  return out;
}

/// @param is_used which of the LiDAR's rotations enter the curve, by their index.
template <class Used>
FractionCurve curve_of(std::span<const LidarTurn> lidar, const TurnTable& gyro, const Used& is_used,
                       const RotationStudyLimits& limits) {
  FractionCurve out;
  for (const std::vector<std::optional<geometry::Vec3>>& turns : gyro) {
    Pairs p;
    for (std::size_t i = 0; i < lidar.size(); ++i) {
      if (!is_used(i) || !turns[i] || !lidar[i].turn_lidar_rad.allFinite()) continue;
      p.lidar.push_back(lidar[i].turn_lidar_rad);
      p.imu.push_back(*turns[i]);
    }
    p.subtract_means();
    const bool enough = p.lidar.size() >= limits.pairs_min;
    out.fraction.push_back(enough ? unexplained(kabsch(p)) : 1.0);
    out.pairs = std::max(out.pairs, p.lidar.size());
  }
  return out;
}

/// The curve's minimum.
struct Tip {
  double offset_s = 0.0;
  double fraction = 1.0;
  double curvature = 0.0;  ///< 0 or less: no minimum
  bool at_border = false;
};

Tip tip_of(const FractionCurve& curve, const RotationStudyLimits& limits) {
  const std::vector<double>& fraction = curve.fraction;
  const int half = (static_cast<int>(fraction.size()) - 1) / 2;
  const auto best = std::min_element(fraction.begin(), fraction.end());
  const auto k = static_cast<int>(best - fraction.begin());
  Tip out;
  out.offset_s = (k - half) * limits.offset_step_s;
  out.fraction = *best;
  out.at_border = k == 0 || k == 2 * half;
  if (out.at_border) return out;
  // A parabola over +-4 steps, because interpolation makes the curve uneven at its minimum.
  const int reach = std::min({4, k, 2 * half - k});
  const double left = fraction[static_cast<std::size_t>(k - reach)];
  const double right = fraction[static_cast<std::size_t>(k + reach)];
  const double width_s = reach * limits.offset_step_s;
  out.curvature = (left + right - 2.0 * *best) / (width_s * width_s);
  if (out.curvature > 0.0) out.offset_s += -0.5 * (right - left) / width_s / out.curvature;
  return out;
}

/// Sigma of the offset by a jackknife over parts of the rotation. If LiDAR odometry lags in a
/// single turn, that turn yields an offset that no other turn confirms.
double jackknife_sigma_s(std::span<const LidarTurn> lidar, const TurnTable& gyro,
                         const RotationStudyLimits& limits) {
  constexpr int kParts = 5;
  double turned_rad = 0.0, all_rad = 0.0;
  for (const LidarTurn& turn : lidar) all_rad += turn.turn_lidar_rad.norm();
  if (!(all_rad > 0.0)) return limits.offset_max_s;
  std::vector<int> part;
  for (const LidarTurn& turn : lidar) {
    part.push_back(std::min(kParts - 1, static_cast<int>(kParts * turned_rad / all_rad)));
    turned_rad += turn.turn_lidar_rad.norm();
  }
  double mean_s = 0.0, squares_s2 = 0.0;
  std::vector<double> offsets_s;
  for (int k = 0; k < kParts; ++k) {
    const auto is_used = [&part, k](std::size_t i) { return part[i] != k; };
    offsets_s.push_back(tip_of(curve_of(lidar, gyro, is_used, limits), limits).offset_s);
    mean_s += offsets_s.back() / kParts;
  }
  for (const double offset_s : offsets_s) squares_s2 += (offset_s - mean_s) * (offset_s - mean_s);
  return std::sqrt((kParts - 1.0) / kParts * squares_s2);
}

/// Minimum of the unexplained fraction over the offset, and its uncertainty from noise.
/// @param alike neighbouring rotations that have most of their data in common and count as one
Offset search_offset(std::span<const LidarTurn> lidar, const GyroTrack& gyro,
                     const TurnTable& table, std::size_t alike, const RotationStudyLimits& limits) {
  const FractionCurve curve = curve_of(
      lidar, table, [](std::size_t) { return true; }, limits);
  const Tip tip = tip_of(curve, limits);
  Offset out;
  out.offset_s = tip.offset_s;
  out.at_border = tip.at_border;
  out.sigma_s = limits.offset_max_s;
  out.unexplained = tip.fraction;
  const Kabsch fit = kabsch(pairs_at(lidar, gyro, tip.offset_s));
  out.scale = fit.scale;
  out.gyro_rms_rad = std::sqrt(fit.imu_square / static_cast<double>(lidar.size()));
  if (tip.at_border || !(tip.curvature > 0.0)) return out;
  const double freedom =
      std::max(1.0, 3.0 * static_cast<double>(curve.pairs) / static_cast<double>(alike) - 7.0);
  out.sigma_s = std::min(out.sigma_s, std::sqrt(2.0 * tip.fraction / freedom / tip.curvature));
  return out;
}

/// Rotations over `count` scans, averaged over as many: the motion below about 1 Hz.
struct SlowTurns {
  std::vector<LidarTurn> turns;
  std::size_t count = 1;
  double scan_s = 0.1;  ///< median period
};

Time middle(Time a, Time b) { return a + Duration{(b - a).ns / 2}; }

/// Adds the slow rotations of a sequence of scans without gaps.
void add_slow_turns(std::span<const LidarTurn> stretch, SlowTurns& out) {
  // A scan measures the mean orientation over its duration: that of its middle.
  std::vector<Time> t;
  std::vector<geometry::Mat3> R_middle;
  geometry::Mat3 R = geometry::Mat3::Identity();
  for (const LidarTurn& turn : stretch) {
    t.push_back(middle(turn.begin, turn.end));
    R_middle.push_back(R * geometry::so3_exp(0.5 * turn.turn_lidar_rad));
    R = R * geometry::so3_exp(turn.turn_lidar_rad);
  }
  const std::size_t n = out.count;
  for (std::size_t i = 0; i + 2 * n <= t.size(); ++i) {
    LidarTurn mean;
    for (std::size_t k = i; k < i + n; ++k) {
      mean.turn_lidar_rad += geometry::so3_log(R_middle[k].transpose() * R_middle[k + n]);
    }
    mean.turn_lidar_rad /= static_cast<double>(n);
    mean.begin = middle(t[i], t[i + n - 1]);
    mean.end = middle(t[i + n], t[i + 2 * n - 1]);
    out.turns.push_back(mean);
  }
}

SlowTurns slow_turns(const std::vector<LidarTurn>& turns, double slow_s) {
  SlowTurns out;
  std::vector<double> periods_s;
  for (const LidarTurn& turn : turns) periods_s.push_back(seconds_between(turn.begin, turn.end));
  const auto median = periods_s.begin() + static_cast<std::ptrdiff_t>(periods_s.size() / 2);
  std::nth_element(periods_s.begin(), median, periods_s.end());
  if (!(*median > 0.0)) return out;
  out.scan_s = *median;
  out.count = static_cast<std::size_t>(std::clamp(std::round(slow_s / *median), 1.0, 1000.0));
  const std::span<const LidarTurn> all(turns);
  for (std::size_t begin = 0, end = 1; begin < all.size(); begin = end, end = begin + 1) {
    while (end < all.size() && all[end].begin == all[end - 1].end) ++end;
    add_slow_turns(all.subspan(begin, end - begin), out);
  }
  return out;
}

/// Samples of the mean rate over `width_s` around each sample; none if the window is incomplete.
std::vector<sensor::ImuSample> mean_rates(const GyroTrack& gyro, double width_s,
                                          std::span<const sensor::ImuSample> at) {
  std::vector<sensor::ImuSample> out;
  const Duration half = Duration::from_s(0.5 * width_s);
  for (const sensor::ImuSample& sample : at) {
    const auto turn = gyro.turn(sample.t - half, sample.t + half);
    if (turn) out.push_back({sample.t, *turn / width_s, sample.accel_mps2});
  }
  return out;
}

/// Filters the gyro like the LiDAR's slow rotations: over a scan, then over the same number of
/// scans.
GyroTrack slow_gyro(std::span<const sensor::ImuSample> imu, double scale, const SlowTurns& slow) {
  const auto per_scan = mean_rates(GyroTrack(imu, scale), slow.scan_s, imu);
  const double width_s = static_cast<double>(slow.count) * slow.scan_s;
  return GyroTrack(mean_rates(GyroTrack(per_scan), width_s, per_scan));
}

double misfit(const Pairs& pairs, const geometry::Mat3& R) {
  double left = 0.0, all = 0.0;
  for (std::size_t i = 0; i < pairs.lidar.size(); ++i) {
    left += (pairs.imu[i] - R * pairs.lidar[i]).squaredNorm();
    all += pairs.imu[i].squaredNorm();
  }
  return all > 0.0 ? std::sqrt(left / all) : 0.0;
}

}  // namespace

GyroTrack::GyroTrack(std::span<const sensor::ImuSample> samples, double scale) {
  for (const sensor::ImuSample& sample : samples) {
    if (!sample.gyro_radps.allFinite()) continue;
    const geometry::Vec3 rate = scale * sample.gyro_radps;
    if (knots_.empty()) {
      knots_.push_back({sample.t, geometry::Mat3::Identity(), rate, 0});
      continue;
    }
    Knot& last = knots_.back();
    const double dt_s = seconds_between(last.t, sample.t);
    if (!(dt_s > 0.0)) continue;
    // The mean of both ends: holding a sample's rate until the next one would shift the gyro by
    // half a sample, 2.5 ms at 200 Hz, which is the size of the offset to be measured.
    last.rate_radps = 0.5 * (last.rate_radps + rate);
    const geometry::Mat3 R = last.R * geometry::so3_exp(last.rate_radps * dt_s);
    knots_.push_back({sample.t, R, rate, last.gaps_before + (dt_s > kGap_s ? 1 : 0)});
  }
}

const GyroTrack::Knot* GyroTrack::knot_before(Time t) const {
  if (knots_.empty() || t < knots_.front().t || t > knots_.back().t) return nullptr;
  const auto after = std::upper_bound(knots_.begin(), knots_.end(), t,
                                      [](Time value, const Knot& k) { return value < k.t; });
  return &*(after - 1);
}

geometry::Mat3 GyroTrack::orientation(const Knot& knot, Time t) {
  return knot.R * geometry::so3_exp(knot.rate_radps * seconds_between(knot.t, t));
}

std::optional<geometry::Vec3> GyroTrack::turn(Time begin, Time end) const {
  const Knot* a = knot_before(begin);
  const Knot* b = knot_before(end);
  if (a == nullptr || b == nullptr || end <= begin || a->gaps_before != b->gaps_before) {
    return std::nullopt;
  }
  return geometry::so3_log(orientation(*a, begin).transpose() * orientation(*b, end));
}

RotationStudy study_rotations(std::span<const LidarTurn> lidar,
                              std::span<const sensor::ImuSample> imu,
                              const RotationStudyLimits& limits) {
  RotationStudy out;
  double duration_s = 0.0, square = 0.0;
  std::vector<LidarTurn> turns;
  for (const LidarTurn& turn : lidar) {
    if (!turn.turn_lidar_rad.allFinite()) continue;
    out.turned_rad += turn.turn_lidar_rad.norm();
    square += turn.turn_lidar_rad.squaredNorm();
    duration_s += seconds_between(turn.begin, turn.end);
    turns.push_back(turn);
  }
  out.pairs = turns.size();
  out.time_offset_sigma_s = limits.offset_max_s;
  if (duration_s > 0.0) {
    const auto n = static_cast<double>(turns.size());
    out.turn_rate_rms = std::sqrt(square / n) / (duration_s / n);
  }
  out.second_axis_fraction = second_axis(turns);
  if (out.pairs < limits.pairs_min || out.turned_rad < limits.turned_min_rad) return out;

  const SlowTurns slow = slow_turns(turns, limits.slow_s);
  if (slow.turns.size() < limits.pairs_min) return out;
  const GyroTrack slow_radps = slow_gyro(imu, 1.0, slow);
  const GyroTrack slow_degps = slow_gyro(imu, kRadPerDeg, slow);
  const TurnTable table_radps = turn_table(slow.turns, slow_radps, limits);
  const TurnTable table_degps = turn_table(slow.turns, slow_degps, limits);
  const Offset in_radps = search_offset(slow.turns, slow_radps, table_radps, slow.count, limits);
  const Offset in_degps = search_offset(slow.turns, slow_degps, table_degps, slow.count, limits);
  // Small rotations fit either unit, except for the scale; large ones wrap around in the wrong one.
  const bool degrees = in_degps.plausible() &&
                       (!in_radps.plausible() || in_degps.unexplained < 0.5 * in_radps.unexplained);
  const GyroTrack gyro(imu, degrees ? kRadPerDeg : 1.0);
  const Offset& offset = degrees ? in_degps : in_radps;
  out.offset_at_border = offset.at_border;
  out.gyro_rate_rms = offset.gyro_rms_rad / (static_cast<double>(slow.count) * slow.scan_s);
  // If less than half is explained, minimum and scale are determined by noise.
  if (offset.unexplained > kUnexplainedMax) return out;
  out.time_offset_sigma_s = offset.sigma_s;
  if (!offset.at_border && offset.sigma_s <= limits.offset_sigma_max_s) {
    const double by_parts_s =
        jackknife_sigma_s(slow.turns, degrees ? table_degps : table_radps, limits);
    out.time_offset_sigma_s = std::min(limits.offset_max_s, std::max(offset.sigma_s, by_parts_s));
  }
  const bool certain = !offset.at_border && out.time_offset_sigma_s <= limits.offset_sigma_max_s;
  if (certain) out.time_offset_s = offset.offset_s;

  const Pairs pairs = pairs_at(lidar, gyro, certain ? offset.offset_s : 0.0);
  if (pairs.lidar.size() < limits.pairs_min) return out;
  const Kabsch fit = kabsch(pairs);
  out.best.R_imu_lidar = fit.R;
  out.best.misfit = misfit(pairs, fit.R);
  out.gyro_ratio = offset.scale / (degrees ? kRadPerDeg : 1.0);
  out.gyro_ratio_max = out.gyro_ratio / (1.0 - offset.unexplained);
  return out;
}

double misfit_of(const geometry::Mat3& R_imu_lidar, std::span<const LidarTurn> lidar,
                 std::span<const sensor::ImuSample> imu, const RotationStudy& study) {
  const GyroTrack gyro(imu, study.gyro_ratio > 10.0 ? kRadPerDeg : 1.0);
  return misfit(pairs_at(lidar, gyro, study.time_offset_s.value_or(0.0)), R_imu_lidar);
}

}  // namespace rali::imu
