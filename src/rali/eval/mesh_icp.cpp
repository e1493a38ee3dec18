#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "rali/eval/cloud_to_mesh.hpp"

namespace rali::eval {

using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3;
using geometry::Vec6;

namespace {

constexpr std::size_t kBlock = 1024;
constexpr std::size_t kPointsMin = 10;
// Directions with less than this fraction of the best one's information are degenerate.
constexpr double kOpenFraction = 1e-6;

/// One point and the direction to its nearest point on the mesh.
struct Match {
  Vec3 p;          ///< in the mesh's frame
  Vec3 direction;  ///< unit, from the mesh to the point
  double distance_m = 0.0;
};

class Icp {
 public:
  Icp(PointList points, const TriangleTree& tree, double overlap, Executor& executor)
      : points_(std::move(points)), tree_(tree), executor_(executor), matches_(points_.size()) {
    const double n = overlap * static_cast<double>(points_.size());
    counted_ = std::max(kPointsMin, static_cast<std::size_t>(std::ceil(n)));
    counted_ = std::min(counted_, points_.size());
    for (const Vec3& p : points_) centre_ += p / static_cast<double>(points_.size());
  }

  /// Finds the matches at a pose; returns the rmse of the used ones [m].
  double match(const SE3& T) {
    executor_.for_blocks(points_.size(), kBlock,
                         [&](std::size_t, std::size_t begin, std::size_t end) {
                           for (std::size_t i = begin; i < end; ++i)
                             matches_[i] = one(T * points_[i]);
                         });
    std::vector<double> distances;
    distances.reserve(matches_.size());
    for (const Match& m : matches_) distances.push_back(m.distance_m);
    const auto last = distances.begin() + static_cast<std::ptrdiff_t>(counted_) - 1;
    std::nth_element(distances.begin(), last, distances.end());
    farthest_m_ = *last;
    double sum = 0.0;
    std::size_t n = 0;
    for (const Match& m : matches_) {
      if (m.distance_m > farthest_m_) continue;
      sum += m.distance_m * m.distance_m;
      ++n;
    }
    return std::sqrt(sum / static_cast<double>(n));
  }

  /// Gauss-Newton step from the matches. Rotations are about the centre of the cloud, so that
  /// distant origins do not cause rounding errors.
  SE3 step(const SE3& T, int& open_directions) const {
    const Vec3 centre = T * centre_;
    Mat6 A = Mat6::Zero();
    Vec6 b = Vec6::Zero();
    double arm2 = 0.0;
    for (const Match& m : matches_) {
      if (m.distance_m > farthest_m_) continue;
      arm2 += (m.p - centre).squaredNorm() / static_cast<double>(counted_);
    }
    const double arm_m = std::max(std::sqrt(arm2), 1e-6);
    for (const Match& m : matches_) {
      if (m.distance_m > farthest_m_) continue;
      Vec6 J;  // rotations scaled by the cloud's size: all six in metres
      J << (m.p - centre).cross(m.direction) / arm_m, m.direction;
      A += J * J.transpose();
      b -= m.distance_m * J;
    }
    const Eigen::SelfAdjointEigenSolver<Mat6> eigen(A);
    Vec6 x = Vec6::Zero();
    open_directions = 0;
    for (int k = 0; k < 6; ++k) {
      const double value = eigen.eigenvalues()[k];
      if (!(value > kOpenFraction * eigen.eigenvalues()[5])) {
        ++open_directions;
        continue;
      }
      const Vec6 v = eigen.eigenvectors().col(k);
      x += v.dot(b) / value * v;
    }
    const geometry::Mat3 turn = geometry::so3_exp(x.head<3>() / arm_m);
    const Vec3 shift = x.tail<3>();
    return {geometry::so3_normalised(turn * T.R), turn * (T.p - centre) + centre + shift};
  }

 private:
  [[nodiscard]] Match one(const Vec3& p) const {
    const TriangleTree::Nearest found = tree_.nearest(p);
    Match m{p, Vec3::Zero(), found.distance_m};
    // On the surface the difference vector is rounding noise; the triangle's normal is not.
    const Vec3 normal = tree_.normal(found.triangle);
    const Vec3 off = p - found.point;
    m.direction = found.distance_m > 1e-9 ? Vec3(off / found.distance_m) : normal;
    return m;
  }

  PointList points_;
  const TriangleTree& tree_;
  Executor& executor_;
  std::vector<Match> matches_;
  std::size_t counted_ = 0;
  double farthest_m_ = 0.0;
  Vec3 centre_ = Vec3::Zero();
};

}  // namespace

Result<MeshIcp> align_to_mesh(const PointList& points, const SE3& T_mesh_cloud,
                              const TriangleTree& tree, const MeshIcpOptions& options,
                              Executor& executor) {
  PointList finite;
  for (const Vec3& p : points) {
    if (p.allFinite()) finite.push_back(p);
  }
  if (finite.size() < kPointsMin) {
    return fail(ErrorCode::kNoAnswer, {},
                "the cloud has fewer than 10 points to lay onto the mesh");
  }
  Icp icp(drawn(finite, options.points_max), tree, options.overlap, executor);
  MeshIcp out;
  out.T_mesh_cloud = T_mesh_cloud;
  out.rmse_m = out.rmse_start_m = icp.match(T_mesh_cloud);
  while (out.iterations < options.iterations_max && !out.converged) {
    ++out.iterations;
    const SE3 T = icp.step(out.T_mesh_cloud, out.open_directions);
    const double rmse_m = icp.match(T);
    out.converged = std::abs(out.rmse_m - rmse_m) < options.rmse_change_m;
    // A step that increases the rmse is not taken: the minimum is reached to within rounding.
    if (rmse_m > out.rmse_m) {
      out.converged = true;
      break;
    }
    out.rmse_m = rmse_m;
    out.T_mesh_cloud = T;
  }
  return out;
}

}  // namespace rali::eval
