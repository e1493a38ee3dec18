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

/// Below this length a path has no direction, and its covariance growth is rounding error.
constexpr double kMinPath_m = 0.05;
constexpr double kMinSigma_m = 1e-3;

/// The path by time, with the distance travelled at each sample.
struct OrderedPath {
  std::vector<std::size_t> order;
  std::vector<double> s_m;  ///< by sample as given
  double length_m = 0.0;
};

OrderedPath ordered_path(const std::vector<PathSample>& samples) {
  OrderedPath ordered;
  ordered.order.resize(samples.size());
  std::iota(ordered.order.begin(), ordered.order.end(), std::size_t{0});
  std::stable_sort(ordered.order.begin(), ordered.order.end(),
                   [&](std::size_t i, std::size_t j) { return samples[i].t < samples[j].t; });
  ordered.s_m.assign(samples.size(), 0.0);
  for (std::size_t k = 1; k < ordered.order.size(); ++k) {
    ordered.length_m += (samples[ordered.order[k]].p_m - samples[ordered.order[k - 1]].p_m).norm();
    ordered.s_m[ordered.order[k]] = ordered.length_m;
  }
  return ordered;
}

/// Position and reported covariance at distance s, interpolated between its neighbours.
PathSample at_distance(const std::vector<PathSample>& samples, const OrderedPath& ordered,
                       double s_m) {
  std::size_t k = 1;
  while (k + 1 < ordered.order.size() && ordered.s_m[ordered.order[k]] < s_m) ++k;
  const PathSample& a = samples[ordered.order[k - 1]];
  const PathSample& b = samples[ordered.order[k]];
  const double from = ordered.s_m[ordered.order[k - 1]];
  const double step = ordered.s_m[ordered.order[k]] - from;
  const double fraction = step > 0.0 ? std::clamp((s_m - from) / step, 0.0, 1.0) : 0.0;
  PathSample out = a;
  out.p_m += fraction * (b.p_m - a.p_m);
  out.covariance_m2 += fraction * (b.covariance_m2 - a.covariance_m2);
  return out;
}

/// Axes times sigma of the growth of a covariance; decreases count as zero.
Mat3 growth_axes(const Mat3& before, const Mat3& after) {
  const Mat3 grown = after - before;
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(0.5 * (grown + grown.transpose()));
  const Vec3 sigma = solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  return solver.eigenvectors() * sigma.asDiagonal();
}

class Builder {
 public:
  Builder(const std::vector<PathSample>& samples, const DriftSettings& settings)
      : samples_(samples), settings_(settings), ordered_(ordered_path(samples)) {}

  std::vector<Eigen::Matrix3Xd> build() {
    if (samples_.size() > 1 && ordered_.length_m > kMinPath_m) {
      add_rigid();
      for (int k = 0; k < settings_.segments; ++k) add_piece(k);
    }
    std::vector<Eigen::Matrix3Xd> out(samples_.size());
    for (std::size_t i = 0; i < samples_.size(); ++i) {
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
    std::vector<Vec3> column(samples_.size());
    for (std::size_t i = 0; i < samples_.size(); ++i) column[i] = sigma * displacement(i);
    columns_.push_back(std::move(column));
  }

  void add_rigid() {
    const Vec3 p0 = samples_[ordered_.order.front()].p_m;
    add_column(settings_.scale, [&](std::size_t i) { return Vec3(samples_[i].p_m - p0); });
    const double tilt = settings_.tilt_deg * kDegree;
    for (const Vec3& axis : {Vec3(Vec3::UnitX()), Vec3(Vec3::UnitY())}) {
      add_column(tilt, [&, axis](std::size_t i) {
        const Vec3 d = samples_[i].p_m - p0;
        return Vec3(axis.y() * d.z(), -axis.x() * d.z(), axis.x() * d.y() - axis.y() * d.x());
      });
    }
  }

  void add_piece(int k) {
    const double piece_m = ordered_.length_m / settings_.segments;
    const double start_m = piece_m * k;
    const Vec3 middle = at_distance(samples_, ordered_, start_m + 0.5 * piece_m).p_m;
    const double yaw = settings_.yaw_deg_per_sqrt_m * kDegree * std::sqrt(piece_m);
    add_column(yaw, [&](std::size_t i) {
      const bool after = ordered_.s_m[i] > start_m + 0.5 * piece_m;
      return after ? quarter_turn(samples_[i].p_m - middle) : Vec3(Vec3::Zero());
    });
    const Mat3 axes = growth_axes(at_distance(samples_, ordered_, start_m).covariance_m2,
                                  at_distance(samples_, ordered_, start_m + piece_m).covariance_m2);
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3 a = axes.col(axis);
      if (a.norm() < kMinSigma_m) continue;
      add_column(1.0, [&](std::size_t i) {
        return Vec3(std::clamp((ordered_.s_m[i] - start_m) / piece_m, 0.0, 1.0) * a);
      });
    }
  }

  const std::vector<PathSample>& samples_;
  const DriftSettings& settings_;
  OrderedPath ordered_;
  std::vector<std::vector<Vec3>> columns_;
};

}  // namespace

std::vector<Eigen::Matrix3Xd> drift_basis(const std::vector<PathSample>& samples,
                                          const DriftSettings& settings) {
  return Builder(samples, settings).build();
}

}  // namespace rali::fleet
