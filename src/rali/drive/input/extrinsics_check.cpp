#include "rali/drive/input/extrinsics_check.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "rali/geometry/pca3.hpp"

namespace rali::drive {
namespace {

using geometry::Mat3;
using geometry::Vec3;

constexpr double kRadToDeg = 180.0 / std::numbers::pi;
/// Steepest ramp on which a vehicle starts (27 %).
constexpr double kTiltMaxDeg = 15.0;
/// How well an alternative must fit to be proposed.
constexpr double kFitsDeg = 7.0;
/// Escalators and loose rock are no steeper; on an incline, or beside a road on a hillside, such
/// slopes may be all that is seen.
constexpr double kSlopeMaxDeg = 40.0;
constexpr double kCellM = 0.8;
constexpr double kRangeM = 20.0;
constexpr std::size_t kCellPoints = 12;
constexpr double kFractionMin = 0.04;
constexpr double kClusterCos = 0.966;   // 15 deg
constexpr double kOtherWallCos = 0.87;  // 30 deg
constexpr double kObliqueFraction = 0.15;
/// The ground of a yard is most of what is seen, and a quarter even between walls. Below rough
/// rock or rings that pass over the floor it may be missing, and any small plane be nearest to it.
constexpr double kGroundFraction = 0.25;
/// Of a plane that the given rotation shows as a wall or a ceiling: most are.
constexpr double kUprightGroundFraction = 0.5;
constexpr double kSectionFraction = 0.1;
constexpr double kBentCosMin = 0.34;  // 70 deg
constexpr double kBentCosMax = 0.94;  // 20 deg

struct Point {
  std::int64_t key;
  Vec3 p_lidar_m;
};

std::int64_t cell_key(const Vec3& p) {
  std::int64_t key = 0;
  for (int axis = 0; axis < 3; ++axis) {
    key = key * 4096 + static_cast<std::int64_t>(std::floor(p[axis] / kCellM)) + 2048;
  }
  return key;
}

std::vector<Point> near_points(std::span<const sensor::LidarScan> scans) {
  std::vector<Point> points;
  for (const sensor::LidarScan& scan : scans) {
    for (std::size_t i = 0; i < scan.size(); ++i) {
      const Vec3 p(static_cast<double>(scan.x_m[i]), static_cast<double>(scan.y_m[i]),
                   static_cast<double>(scan.z_m[i]));
      if (p.squaredNorm() < kRangeM * kRangeM) points.push_back({cell_key(p), p});
    }
  }
  std::stable_sort(points.begin(), points.end(),
                   [](const Point& a, const Point& b) { return a.key < b.key; });
  return points;
}

/// Normal of one cell's points if they lie on a plane: thin, and wide in both other directions
/// (points of a single ring lie on a line).
std::optional<Vec3> cell_normal(std::span<const Point> cell) {
  if (cell.size() < kCellPoints) return std::nullopt;
  const auto n = static_cast<double>(cell.size());
  Vec3 mean = Vec3::Zero();
  for (const Point& point : cell) mean += point.p_lidar_m / n;
  Mat3 S = Mat3::Zero();
  for (const Point& point : cell) {
    const Vec3 d = point.p_lidar_m - mean;
    S += d * d.transpose() / n;
  }
  const geometry::Pca3 pca = geometry::pca3(S);
  const bool flat = pca.values[2] < 0.03 * 0.03 && pca.values[1] > 0.1 * 0.1;
  if (!flat) return std::nullopt;
  const Vec3 normal = pca.vectors.col(2);
  return normal.dot(mean) < 0.0 ? normal : Vec3(-normal);
}

struct Weighted {
  Vec3 n;
  double weight;
};

/// All normals within 15 deg of the one with the most weight around it, removed from the list.
std::optional<Weighted> take_heaviest(std::vector<Weighted>& normals) {
  Weighted best{Vec3::Zero(), 0.0};
  for (const Weighted& centre : normals) {
    Weighted sum{Vec3::Zero(), 0.0};
    for (const Weighted& other : normals) {
      if (other.n.dot(centre.n) < kClusterCos) continue;
      sum.n += other.weight * other.n;
      sum.weight += other.weight;
    }
    if (sum.weight > best.weight) best = sum;
  }
  if (best.weight <= 0.0) return std::nullopt;
  best.n.normalize();
  std::erase_if(normals, [&](const Weighted& w) { return w.n.dot(best.n) > kClusterCos; });
  return best;
}

/// The 24 axis permutations without mirroring.
std::vector<Mat3> axis_exchanges() {
  std::vector<Mat3> all;
  std::array<int, 3> order = {0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      Mat3 R = Mat3::Zero();
      for (int row = 0; row < 3; ++row) {
        R(row, order[static_cast<std::size_t>(row)]) = (signs >> row & 1) != 0 ? -1.0 : 1.0;
      }
      if (R.determinant() > 0.0) all.push_back(R);
    }
  } while (std::next_permutation(order.begin(), order.end()));
  return all;
}

std::string axes_in_words(const Mat3& R) {
  const char* names[] = {"x", "y", "z"};
  std::string text;
  for (int row = 0; row < 3; ++row) {
    int column = 0;
    R.row(row).cwiseAbs().maxCoeff(&column);
    text += fmt::format("{}{} of the body = {}{} of the LiDAR", row == 0 ? "" : ", ", names[row],
                        R(row, column) < 0.0 ? "-" : "", names[column]);
  }
  return text;
}

struct Verdict {
  std::string remedy;
  bool may_be_slope = false;  ///< no proof of a mistake
};

/// What would fit. @param given_deg tilt of the ground with the given rotation
Verdict what_fits(std::span<const PlaneDirection> grounds, const Mat3& R_body_lidar,
                  double given_deg, const Vec3& up_body) {
  const auto tilt_deg = [&](const Mat3& R) {
    return ground_tilt_rad(grounds, R, up_body).value_or(std::numbers::pi) * kRadToDeg;
  };
  const double inverse_deg = tilt_deg(R_body_lidar.transpose());
  if (inverse_deg < kFitsDeg) {
    return {fmt::format("The inverse fits ({:.1f} deg): was T_lidar_body given as T_body_lidar?",
                        inverse_deg)};
  }
  // On an incline, other axes that make a wall the ground fit better than the right ones.
  if (given_deg < kSlopeMaxDeg) {
    return {"Check it, unless the vehicle started on or beside a slope.", true};
  }
  for (const Mat3& R : axis_exchanges()) {
    // Among equal ones the first in a fixed order: gravity does not constrain yaw.
    if (tilt_deg(R) < kFitsDeg) {
      return {fmt::format("Other axes fit ({:.1f} deg), up to yaw: {}.", tilt_deg(R),
                          axes_in_words(R))};
    }
  }
  return {"Neither the inverse nor other axes fit; is the accelerometer's sign right?"};
}

/// A pipe or a vaulted tunnel along a horizontal axis: all oblique planes run along it, and between
/// walls on both sides, or large planes along it are neither parallel nor at right angles to each
/// other. Level rings may not see its bottom, and a rotation about its axis changes nothing that
/// they see. Small oblique planes prove nothing: a car beside a rolled ground is as oblique to it.
bool passage_seen(std::span<const PlaneDirection> planes, const Mat3& R_body_lidar,
                  const Vec3& up_body) {
  const double sine_of_tilt = std::sin(kTiltMaxDeg / kRadToDeg);
  const double cosine_of_tilt = std::cos(kTiltMaxDeg / kRadToDeg);
  const Vec3 up_lidar = R_body_lidar.transpose() * up_body;
  const auto is_oblique = [&](const PlaneDirection& plane) {
    const double cosine = std::abs(plane.n_lidar.dot(up_lidar));
    return cosine > sine_of_tilt && cosine < cosine_of_tilt;
  };
  const auto first = std::find_if(planes.begin(), planes.end(), is_oblique);
  if (first == planes.end()) return false;
  const Vec3 axis_lidar = first->n_lidar.cross(up_lidar).normalized();
  double elsewhere = 0.0;
  std::vector<Vec3> section_lidar;
  for (const PlaneDirection& plane : planes) {
    const bool along = std::abs(plane.n_lidar.dot(axis_lidar)) < sine_of_tilt;
    if (!along && is_oblique(plane)) elsewhere += plane.fraction;
    if (along && plane.fraction > kSectionFraction) section_lidar.push_back(plane.n_lidar);
  }
  const auto is_wall = [&](const Vec3& n_lidar) {
    return std::abs(n_lidar.dot(up_lidar)) < sine_of_tilt;
  };
  const auto closes_a_passage = [&](const Vec3& one) {
    return std::any_of(section_lidar.begin(), section_lidar.end(), [&](const Vec3& other) {
      const double cosine = one.dot(other);
      const bool bent = std::abs(cosine) > kBentCosMin && std::abs(cosine) < kBentCosMax;
      const bool opposite = cosine < 0.0 && is_wall(one) && is_wall(other);
      return bent || opposite;
    });
  };
  return elsewhere < kObliqueFraction &&
         std::any_of(section_lidar.begin(), section_lidar.end(), closes_a_passage);
}

/// Walls in at least two directions, or one and a level ceiling, and no oblique planes: what sparse
/// rings see of a narrow corridor whose floor is too near below them, and a LiDAR that looks up of
/// any room. One direction alone may be a ground under swapped axes.
bool only_walls_seen(std::span<const PlaneDirection> planes, const Mat3& R_body_lidar,
                     const Vec3& up_body) {
  const double sine_of_tilt = std::sin(kTiltMaxDeg / kRadToDeg);
  double oblique = 0.0;
  bool two_directions = false;
  bool ceiling_seen = false;
  const PlaneDirection* first = nullptr;
  for (const PlaneDirection& plane : planes) {
    const double cosine = (R_body_lidar * plane.n_lidar).dot(up_body);
    const bool wall = std::abs(cosine) < sine_of_tilt;
    const bool ceiling = cosine < -std::cos(kTiltMaxDeg / kRadToDeg);
    ceiling_seen = ceiling_seen || ceiling;
    if (!wall && !ceiling) oblique += plane.fraction;
    if (!wall) continue;
    if (first == nullptr) first = &plane;
    two_directions = two_directions || plane.n_lidar.dot(first->n_lidar) < kOtherWallCos;
  }
  return (two_directions || (first != nullptr && ceiling_seen)) && oblique < kObliqueFraction;
}

}  // namespace

std::vector<PlaneDirection> ground_candidates(std::span<const PlaneDirection> planes,
                                              const Mat3& R_body_lidar, const Vec3& up_body) {
  std::vector<PlaneDirection> large;
  if (only_walls_seen(planes, R_body_lidar, up_body) ||
      passage_seen(planes, R_body_lidar, up_body)) {
    return large;
  }
  const double sine_of_tilt = std::sin(kTiltMaxDeg / kRadToDeg);
  const double cosine_of_tilt = std::cos(kTiltMaxDeg / kRadToDeg);
  std::copy_if(planes.begin(), planes.end(), std::back_inserter(large), [&](const auto& plane) {
    const double cosine = (R_body_lidar * plane.n_lidar).dot(up_body);
    const bool upright = std::abs(cosine) < sine_of_tilt || cosine < -cosine_of_tilt;
    return plane.fraction >= (upright ? kUprightGroundFraction : kGroundFraction);
  });
  return large;
}

std::vector<PlaneDirection> plane_directions(std::span<const sensor::LidarScan> scans) {
  const std::vector<Point> points = near_points(scans);
  std::vector<Weighted> normals;
  double total = 0.0;
  for (std::size_t begin = 0; begin < points.size();) {
    std::size_t end = begin;
    while (end < points.size() && points[end].key == points[begin].key) ++end;
    if (const auto n = cell_normal(std::span(points).subspan(begin, end - begin))) {
      // One weight per cell: near cells hold many more points without covering more area.
      normals.push_back({*n, 1.0});
      total += 1.0;
    }
    begin = end;
  }
  std::vector<PlaneDirection> planes;
  while (planes.size() < 8) {
    const std::optional<Weighted> heaviest = take_heaviest(normals);
    if (!heaviest || heaviest->weight < kFractionMin * total || heaviest->weight < 5.0) break;
    planes.push_back({heaviest->n, heaviest->weight / total});
  }
  return planes;
}

std::optional<double> ground_tilt_rad(std::span<const PlaneDirection> planes,
                                      const Mat3& R_body_lidar, const Vec3& up_body) {
  std::optional<double> minimum;
  for (const PlaneDirection& plane : planes) {
    // The ground's normal points up to the sensor; a ceiling's points down and is excluded.
    const double cosine = std::clamp((R_body_lidar * plane.n_lidar).dot(up_body), -1.0, 1.0);
    const double tilt = std::acos(cosine);
    if (!minimum || tilt < *minimum) minimum = tilt;
  }
  return minimum;
}

bool ground_fits(std::span<const PlaneDirection> planes, const Mat3& R_body_lidar,
                 const Vec3& up_body) {
  const double cosine_of_tilt = std::cos(kTiltMaxDeg / kRadToDeg);
  return std::any_of(planes.begin(), planes.end(), [&](const PlaneDirection& plane) {
    return plane.fraction >= kGroundFraction &&
           (R_body_lidar * plane.n_lidar).dot(up_body) > cosine_of_tilt;
  });
}

Result<FindingList> check_extrinsics(std::span<const PlaneDirection> planes,
                                     const Mat3& R_body_lidar, const Vec3& up_body,
                                     const InputOptions& options) {
  FindingList findings;
  const std::optional<double> tilt = ground_tilt_rad(planes, R_body_lidar, up_body);
  if (!tilt || options.extrinsics == ExtrinsicsCheck::kOff) return findings;
  const double tilt_deg = *tilt * kRadToDeg;
  const std::vector<PlaneDirection> grounds = ground_candidates(planes, R_body_lidar, up_body);
  if (tilt_deg <= kTiltMaxDeg || grounds.empty()) return findings;
  const std::string text = fmt::format(
      "T_body_lidar does not fit the data: the ground seen by the LiDAR is {:.1f} deg off level",
      tilt_deg);
  const Verdict verdict = what_fits(grounds, R_body_lidar, tilt_deg, up_body);
  if (options.extrinsics == ExtrinsicsCheck::kError && !options.turning_follows &&
      !verdict.may_be_slope) {
    return fail(ErrorCode::kInput, fmt::format("vehicles.{}.lidar.T_body_lidar", options.vehicle),
                text, verdict.remedy + " (--set checks.extrinsics=warn goes on.)");
  }
  Finding f;
  f.id = "D11";
  f.vehicle = options.vehicle;
  f.text = text;
  f.remedy = verdict.remedy;
  f.value = tilt_deg;
  f.limit = kTiltMaxDeg;
  findings.push_back(f);
  return findings;
}

std::string extrinsics_in_words(const geometry::SE3& T, const std::string& origin) {
  std::vector<std::string> parts;
  const std::array<std::array<const char*, 2>, 3> names = {
      {{"forward", "back"}, {"left", "right"}, {"up", "down"}}};
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(T.p[axis]) < 0.0005) continue;
    parts.push_back(fmt::format("{:.3g} m {}", std::abs(T.p[axis]),
                                names[static_cast<std::size_t>(axis)][T.p[axis] < 0.0 ? 1 : 0]));
  }
  std::string text = parts.empty() ? "at the place of the " + origin
                                   : fmt::format("{} of the {}", fmt::join(parts, ", "), origin);
  const Vec3 rpy = kRadToDeg * geometry::rpy_from_rotation(T.R);
  const std::array<std::array<const char*, 2>, 3> turns = {
      {{"rolled right", "rolled left"}, {"pitched down", "pitched up"}, {"left", "right"}}};
  bool turned = false;
  for (int axis = 2; axis >= 0; --axis) {
    if (std::abs(rpy[axis]) < 0.05) continue;
    text += fmt::format(", {}{:.1f} deg {}", axis == 2 ? "turned " : "", std::abs(rpy[axis]),
                        turns[static_cast<std::size_t>(axis)][rpy[axis] < 0.0 ? 1 : 0]);
    turned = true;
  }
  return turned ? text : text + ", not turned";
}

std::optional<geometry::SE3> maker_extrinsics(const std::string& model,
                                              const std::string& imu_topic) {
  // Only for the LiDAR's own IMU.
  if (imu_topic.find("livox") == std::string::npos) return std::nullopt;
  geometry::SE3 T_body_lidar;
  if (model == "mid360") {
    // Livox Mid-360 user manual: IMU at (11.0, 23.29, -44.12) mm in the LiDAR's frame.
    T_body_lidar.p = {-0.011, -0.02329, 0.04412};
    return T_body_lidar;
  }
  if (model == "avia") {
    // Livox Avia user manual: IMU at (-41.65, -23.26, 28.40) mm in the LiDAR's frame.
    T_body_lidar.p = {0.04165, 0.02326, -0.0284};
    return T_body_lidar;
  }
  return std::nullopt;
}

}  // namespace rali::drive
