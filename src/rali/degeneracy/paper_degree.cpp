#include "rali/degeneracy/paper_degree.hpp"

#include <algorithm>
#include <limits>
#include <optional>

#include <Eigen/Eigenvalues>

#include "rali/geometry/pca3.hpp"
#include "rali/geometry/so3.hpp"

namespace rali::degeneracy {
namespace {

using geometry::Mat3;
using geometry::Vec3;

// A direction with a horizontal part below one half does not count as horizontal (table 0.2).
constexpr double kHorizontalPartMin = 0.5;

struct Moments {
  Mat3 S = Mat3::Zero();
  int count = 0;
};

Moments moments_of(std::span<const Vec3> normals, NormalSign sign) {
  Moments out;
  Vec3 sum = Vec3::Zero();
  for (const Vec3& n : normals) {
    if (!n.allFinite()) continue;
    sum += n;
    out.S += n * n.transpose();
    ++out.count;
  }
  if (out.count == 0) return out;
  out.S /= out.count;
  const Vec3 mean = sum / out.count;
  if (sign == NormalSign::kGiven) out.S -= mean * mean.transpose();
  return out;
}

double ratio(double upper, double lower) {
  // Rounding turns an exact zero into +-1e-17, which must not become a large negative degree.
  if (lower <= 1e-15) return std::numeric_limits<double>::infinity();
  return std::max(0.0, upper) / lower;
}

double degree_of(const Vec3& values, DegreeRatio which) {
  switch (which) {
    case DegreeRatio::kL1L3:
      return ratio(values(0), values(2));
    case DegreeRatio::kL1L2:
      return ratio(values(0), values(1));
    case DegreeRatio::kHorizontal:
    case DegreeRatio::kL2L3:
      break;
  }
  return ratio(values(1), values(2));
}

std::optional<Vec3> horizontal(const Vec3& e3, const Vec3& up) {
  const Vec3 flat = e3 - e3.dot(up) * up;
  const double length = flat.norm();
  if (length < kHorizontalPartMin) return std::nullopt;
  return Vec3(flat / length);
}

/// The horizontal 2x2 block: its eigenvalues, smaller first, and the eigenvector of the smaller.
struct Horizontal {
  Eigen::Vector2d values;
  Vec3 minimum;
};

Horizontal horizontal_block(const Mat3& S, const Vec3& up) {
  const Mat3 R = geometry::rotation_between(up, Vec3::UnitZ());
  const Eigen::Matrix2d block = (R * S * R.transpose()).topLeftCorner<2, 2>();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(block);
  const Eigen::Vector2d axis = solver.eigenvectors().col(0);
  return {solver.eigenvalues(), R.transpose() * Vec3(axis.x(), axis.y(), 0.0)};
}

bool is_usable(const Vec3& up) { return up.allFinite() && up.norm() > 1e-9; }

std::optional<Vec3> direction_of(const Moments& moments, const Vec3& e3, const Vec3& up,
                                 DegreeDirection which) {
  switch (which) {
    case DegreeDirection::kE3:
      return e3;
    case DegreeDirection::kMinHorizontal:
      if (!is_usable(up)) return std::nullopt;
      return horizontal_block(moments.S, up.normalized()).minimum;
    case DegreeDirection::kE3Xy:
      break;
  }
  if (!is_usable(up)) return std::nullopt;
  return horizontal(e3, up.normalized());
}

}  // namespace

PaperDegree paper_degree(std::span<const Vec3> normals_body, const Vec3& up_body,
                         const PaperDegreeSettings& settings) {
  const Moments moments = moments_of(normals_body, settings.normal_sign);
  PaperDegree out;
  out.normals = moments.count;
  if (moments.count == 0 || moments.count < settings.deg_min_normals) {
    out.degenerate = true;
    return out;
  }
  const geometry::Pca3 pca = geometry::pca3(moments.S);
  out.known = settings.deg_ratio != DegreeRatio::kHorizontal || is_usable(up_body);
  if (!out.known) {
    out.degenerate = true;
    return out;
  }
  out.degree = degree_of(pca.values, settings.deg_ratio);
  if (settings.deg_ratio == DegreeRatio::kHorizontal) {
    const Eigen::Vector2d h = horizontal_block(moments.S, up_body.normalized()).values;
    out.degree = ratio(h(1), h(0));
  }
  out.e3_body = pca.vectors.col(2);
  out.degenerate = out.degree < settings.deg_below ||
                   (settings.deg_above > 0.0 && out.degree > settings.deg_above);
  const auto direction = direction_of(moments, out.e3_body, up_body, settings.deg_direction);
  out.direction_known = direction.has_value();
  if (direction) out.direction_body = *direction;
  return out;
}

}  // namespace rali::degeneracy
