#include "rali/fleet/frames/drift_basis.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

#include <Eigen/Eigenvalues>

#include "rali/fleet/frames/yaw_pose.hpp"

namespace rali::fleet {

using geometry::Mat3;
using geometry::Vec3;

namespace {

/// Below this a path has no direction, and its growth of covariance is rounding.
constexpr double kLeastWay_m = 0.05;
constexpr double kLeastSigma_m = 1e-3;

/// The path by time, with the way to each sample.
struct Way {
  std::vector<std::size_t> order;
  std::vector<double> s_m;  ///< by sample as given
  double length_m = 0.0;
};

Way way_of(const std::vector<PathSample>& path) {
  Way way;
  way.order.resize(path.size());
  std::iota(way.order.begin(), way.order.end(), std::size_t{0});
  std::stable_sort(way.order.begin(), way.order.end(),
                   [&](std::size_t i, std::size_t j) { return path[i].t < path[j].t; });
  way.s_m.assign(path.size(), 0.0);
  for (std::size_t k = 1; k < way.order.size(); ++k) {
    way.length_m += (path[way.order[k]].p_m - path[way.order[k - 1]].p_m).norm();
    way.s_m[way.order[k]] = way.length_m;
  }
  return way;
}

/// Position and told covariance at way s, on the line between its neighbours.
PathSample at_way(const std::vector<PathSample>& path, const Way& way, double s_m) {
  std::size_t k = 1;
  while (k + 1 < way.order.size() && way.s_m[way.order[k]] < s_m) ++k;
  const PathSample& a = path[way.order[k - 1]];
  const PathSample& b = path[way.order[k]];
  const double from = way.s_m[way.order[k - 1]];
  const double step = way.s_m[way.order[k]] - from;
  const double share = step > 0.0 ? std::clamp((s_m - from) / step, 0.0, 1.0) : 0.0;
  PathSample out = a;
  out.p_m += share * (b.p_m - a.p_m);
  out.covariance_m2 += share * (b.covariance_m2 - a.covariance_m2);
  return out;
}

/// Axes times sigma of what a covariance has grown by; what shrank counts as nothing.
Mat3 growth_axes(const Mat3& before, const Mat3& after) {
  const Mat3 grown = after - before;
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(0.5 * (grown + grown.transpose()));
  const Vec3 sigma = solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  return solver.eigenvectors() * sigma.asDiagonal();
}

class Builder {
 public:
  Builder(const std::vector<PathSample>& path, const DriftSettings& settings)
      : path_(path), settings_(settings), way_(way_of(path)) {}

  std::vector<Eigen::Matrix3Xd> build() {
    if (path_.size() > 1 && way_.length_m > kLeastWay_m) {
      add_rigid();
      for (int k = 0; k < settings_.segments; ++k) add_piece(k);
    }
    std::vector<Eigen::Matrix3Xd> out(path_.size());
    for (std::size_t i = 0; i < path_.size(); ++i) {
      out[i].resize(3, static_cast<Eigen::Index>(columns_.size()));
      for (std::size_t c = 0; c < columns_.size(); ++c) {
        out[i].col(static_cast<Eigen::Index>(c)) = columns_[c][i];
      }
    }
    return out;
  }

 private:
  template <class F>
  void add_column(double sigma, F displacement) {
    if (!(sigma > 0.0)) return;
    std::vector<Vec3> column(path_.size());
    for (std::size_t i = 0; i < path_.size(); ++i) column[i] = sigma * displacement(i);
    columns_.push_back(std::move(column));
  }

  void add_rigid() {
    const Vec3 p0 = path_[way_.order.front()].p_m;
    add_column(settings_.scale, [&](std::size_t i) { return Vec3(path_[i].p_m - p0); });
    const double tilt = settings_.tilt_deg * kDegree;
    for (const Vec3& axis : {Vec3(Vec3::UnitX()), Vec3(Vec3::UnitY())}) {
      add_column(tilt, [&, axis](std::size_t i) {
        const Vec3 d = path_[i].p_m - p0;
        return Vec3(axis.y() * d.z(), -axis.x() * d.z(), axis.x() * d.y() - axis.y() * d.x());
      });
    }
  }

  void add_piece(int k) {
    const double piece_m = way_.length_m / settings_.segments;
    const double begin_m = piece_m * k;
    const Vec3 middle = at_way(path_, way_, begin_m + 0.5 * piece_m).p_m;
    const double yaw = settings_.yaw_deg_per_sqrt_m * kDegree * std::sqrt(piece_m);
    add_column(yaw, [&](std::size_t i) {
      const bool after = way_.s_m[i] > begin_m + 0.5 * piece_m;
      return after ? quarter_turn(path_[i].p_m - middle) : Vec3(Vec3::Zero());
    });
    const Mat3 axes = growth_axes(at_way(path_, way_, begin_m).covariance_m2,
                                  at_way(path_, way_, begin_m + piece_m).covariance_m2);
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3 a = axes.col(axis);
      if (a.norm() < kLeastSigma_m) continue;
      add_column(1.0, [&](std::size_t i) {
        return Vec3(std::clamp((way_.s_m[i] - begin_m) / piece_m, 0.0, 1.0) * a);
      });
    }
  }

  const std::vector<PathSample>& path_;
  const DriftSettings& settings_;
  Way way_;
  std::vector<std::vector<Vec3>> columns_;
};

}  // namespace

std::vector<Eigen::Matrix3Xd> drift_basis(const std::vector<PathSample>& path,
                                          const DriftSettings& settings) {
  return Builder(path, settings).build();
}

}  // namespace rali::fleet
