#include "rali/fleet/centre/joint_covariance.hpp"

#include <numbers>

#include <Eigen/Eigenvalues>

namespace rali::fleet {

using geometry::Mat6;
using geometry::SE3;
using geometry::Vec6;

namespace {

/// Regularises a zero step covariance (first node). Far below any real uncertainty [m^2, rad^2].
constexpr double kNothing = 1e-12;

/// Maps the error of a pose (boxplus) to a rotation and translation about the origin; these add up.
Mat6 about_origin(const SE3& T) {
  Mat6 A = Mat6::Zero();
  A.block<3, 3>(0, 0) = T.R;
  A.block<3, 3>(3, 0) = geometry::skew(T.p) * T.R;
  A.block<3, 3>(3, 3).setIdentity();
  return A;
}

Mat6 of_step(const Increment& step, const JointSettings& settings) {
  const bool isotropic = settings.steps == StepWeight::kIsotropic;
  const double rad =
      isotropic ? settings.isotropic_deg * std::numbers::pi / 180.0 : settings.shape.shape_rad;
  const double m = isotropic ? settings.isotropic_m : settings.shape.shape_m;
  Mat6 loose = Mat6::Zero();
  loose.diagonal().head<3>().setConstant(rad * rad);
  loose.diagonal().tail<3>().setConstant(m * m);
  if (isotropic) return loose;
  const Mat6 fraction = known_fraction(step.lidar_information, settings.shape);
  return fraction * loose * fraction.transpose();
}

}  // namespace

std::vector<Mat6> shape_covariances(const VehiclePath& path, const JointSettings& settings) {
  std::vector<Mat6> out;
  Mat6 sum = Mat6::Zero();
  bool rested = false;
  for (const VehiclePath::Node& node : path.nodes()) {
    const Mat6 A = about_origin(node.step->T_odom_body);
    // Nodes at standstill are fixed to each other in the graph: no step.
    if (!out.empty() && !rested) sum += A * of_step(*node.step, settings) * A.transpose();
    rested = node.step->at_rest;
    const Mat6 B = A.partialPivLu().inverse();
    out.push_back(B * sum * B.transpose());
  }
  return out;
}

Mat6 joint_covariance(const Mat6& of_graph, const Mat6& of_steps, const Mat6& of_map) {
  const Mat6 steps = of_steps + kNothing * Mat6::Identity();
  const Eigen::GeneralizedSelfAdjointEigenSolver<Mat6> ratios(of_graph, steps);
  Mat6 out = of_map;
  for (int k = 0; k < 6; ++k) {
    const double ratio = ratios.eigenvalues()[k];
    // Variance above that of the steps: the excess is the frame's. Below: ranges or loops have bent
    // the path by 1 - ratio of the difference, and ratio / (1 - ratio) is their own variance.
    const double more = ratio > 1.0 ? ratio - 1.0 : ratio * (1.0 - ratio);
    if (!(more > 0.0)) continue;
    const Vec6 direction = steps * ratios.eigenvectors().col(k);
    out += more * direction * direction.transpose();
  }
  return out;
}

}  // namespace rali::fleet
