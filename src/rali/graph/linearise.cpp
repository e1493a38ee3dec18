#include "rali/graph/linearise.hpp"

#include "rali/base/assert.hpp"
#include "rali/geometry/robust.hpp"
#include "rali/graph/root.hpp"

namespace rali::graph {

using geometry::Mat3;
using geometry::SE3;
using geometry::skew;
using geometry::so3_exp;
using geometry::so3_log;
using geometry::so3_right_jacobian;
using geometry::so3_right_jacobian_inverse;
using geometry::Vec3;

namespace {

const KeyframeState& value(const Window& window, Seq seq) { return window.node(seq).x; }

const GlobalNode& value(const Window& window, GlobalId id) {
  const int g = window.find(id);
  RALI_ASSERT(g >= 0);
  return window.globals[static_cast<std::size_t>(g)];
}

// The first `dim` unknowns of a keyframe: pose 6, with velocity 9, all 15.
int append(const Window& window, Seq seq, int dim, LinearFactor& out) {
  return out.append(window.column(seq), dim);
}

// Pose and velocity of the IMU of a keyframe.
SE3 imu_pose(const KeyframeState& x, const SE3& T_body_imu) { return x.T_odom_body * T_body_imu; }

// d (rotation, position) of the IMU by (rotation, position) of the body.
geometry::Mat6 d_imu_d_body(const KeyframeState& x, const SE3& T_body_imu) {
  geometry::Mat6 J = geometry::Mat6::Identity();
  J.topLeftCorner<3, 3>() = T_body_imu.R.transpose();
  J.bottomLeftCorner<3, 3>() = -x.T_odom_body.R * skew(T_body_imu.p);
  return J;
}

void bias_walk(const InertialFactor& f, const KeyframeState& xi, const KeyframeState& xj, int ci,
               int cj, LinearFactor& out) {
  const double root_s = std::sqrt(f.duration_s);
  const double gyro = 1.0 / (f.gyro_walk_radps_rts * root_s);
  const double accel = 1.0 / (f.accel_walk_mps2_rts * root_s);
  out.r.segment<3>(9) = gyro * (xj.gyro_bias_radps - xi.gyro_bias_radps);
  out.r.segment<3>(12) = accel * (xj.accel_bias_mps2 - xi.accel_bias_mps2);
  out.J.block<3, 3>(9, ci + kGyroBias).diagonal().setConstant(-gyro);
  out.J.block<3, 3>(9, cj + kGyroBias).diagonal().setConstant(gyro);
  out.J.block<3, 3>(12, ci + kAccelBias).diagonal().setConstant(-accel);
  out.J.block<3, 3>(12, cj + kAccelBias).diagonal().setConstant(accel);
}

// Rows (rotation, velocity, position) and their derivatives by the IMU poses of i and j.
struct InertialRows {
  Eigen::Matrix<double, 9, 1> r = Eigen::Matrix<double, 9, 1>::Zero();
  Eigen::Matrix<double, 9, 6> d_pose_i = Eigen::Matrix<double, 9, 6>::Zero();
  Eigen::Matrix<double, 9, 6> d_pose_j = Eigen::Matrix<double, 9, 6>::Zero();
  Eigen::Matrix<double, 9, 3> d_velocity_i = Eigen::Matrix<double, 9, 3>::Zero();
  Eigen::Matrix<double, 9, 3> d_velocity_j = Eigen::Matrix<double, 9, 3>::Zero();
  Eigen::Matrix<double, 9, 6> d_bias = Eigen::Matrix<double, 9, 6>::Zero();
};

InertialRows inertial_rows(const InertialFactor& f, const KeyframeState& xi,
                           const KeyframeState& xj) {
  const SE3 Ti = imu_pose(xi, f.T_body_imu);
  const SE3 Tj = imu_pose(xj, f.T_body_imu);
  const auto RiT = Ti.R.transpose();  // a view: Ti must outlive it
  const double D = f.duration_s;
  const Vec3 db_g = xi.gyro_bias_radps - f.gyro_bias_radps;
  const Vec3 db_a = xi.accel_bias_mps2 - f.accel_bias_mps2;
  const Vec3 velocity_i = RiT * (xj.v_odom_mps - xi.v_odom_mps - f.g_odom_mps2 * D);
  const Vec3 position_i = RiT * (Tj.p - Ti.p - xi.v_odom_mps * D - f.g_odom_mps2 * (0.5 * D * D));
  const Mat3 dR = f.dR * so3_exp(f.d_rotation_d_gyro * db_g);
  const Vec3 r_R = so3_log(dR.transpose() * RiT * Tj.R);
  const Mat3 JrInv = so3_right_jacobian_inverse(r_R);

  InertialRows rows;
  rows.r << r_R, velocity_i - f.dv_mps - f.d_velocity_d_gyro * db_g - f.d_velocity_d_accel * db_a,
      position_i - f.dp_m - f.d_position_d_gyro * db_g - f.d_position_d_accel * db_a;
  rows.d_pose_i.block<3, 3>(0, 0) = -JrInv * Tj.R.transpose() * Ti.R;
  rows.d_pose_i.block<3, 3>(3, 0) = skew(velocity_i);
  rows.d_pose_i.block<3, 3>(6, 0) = skew(position_i);
  rows.d_pose_i.block<3, 3>(6, 3) = -RiT;
  rows.d_pose_j.block<3, 3>(0, 0) = JrInv;
  rows.d_pose_j.block<3, 3>(6, 3) = RiT;
  rows.d_velocity_i.block<3, 3>(3, 0) = -RiT;
  rows.d_velocity_i.block<3, 3>(6, 0) = -RiT * D;
  rows.d_velocity_j.block<3, 3>(3, 0) = RiT;
  rows.d_bias.block<3, 3>(0, 0) = -JrInv * so3_exp(r_R).transpose() *
                                  so3_right_jacobian(f.d_rotation_d_gyro * db_g) *
                                  f.d_rotation_d_gyro;
  rows.d_bias.block<3, 3>(3, 0) = -f.d_velocity_d_gyro;
  rows.d_bias.block<3, 3>(3, 3) = -f.d_velocity_d_accel;
  rows.d_bias.block<3, 3>(6, 0) = -f.d_position_d_gyro;
  rows.d_bias.block<3, 3>(6, 3) = -f.d_position_d_accel;
  return rows;
}

// Relative pose residual and its derivatives, multiplied by root.
void relative_rows(const SE3& Ti, const SE3& Tj, const SE3& T_i_j, const geometry::Mat6& root,
                   int row, int ci, int cj, LinearFactor& out) {
  const auto RiT = Ti.R.transpose();  // a view: Ti must outlive it
  const Vec3 r_R = so3_log(T_i_j.R.transpose() * RiT * Tj.R);
  const Mat3 JrInv = so3_right_jacobian_inverse(r_R);
  const Vec3 p_i = RiT * (Tj.p - Ti.p);
  geometry::Vec6 xi;
  xi << r_R, p_i - T_i_j.p;
  geometry::Mat6 d_i = geometry::Mat6::Zero();
  d_i.block<3, 3>(0, 0) = -JrInv * Tj.R.transpose() * Ti.R;
  d_i.block<3, 3>(3, 0) = skew(p_i);
  d_i.block<3, 3>(3, 3) = -RiT;
  geometry::Mat6 d_j = geometry::Mat6::Zero();
  d_j.block<3, 3>(0, 0) = JrInv;
  d_j.block<3, 3>(3, 3) = RiT;
  out.r.segment<6>(row) = root * xi;
  out.J.block<6, 6>(row, ci) = root * d_i;
  out.J.block<6, 6>(row, cj) = root * d_j;
}

}  // namespace

void LinearFactor::start(int rows) {
  J.resize(rows, 0);
  r.setZero(rows);
  block_count = 0;
  cost = 0.0;
}

int LinearFactor::append(int column, int dim) {
  const int local = static_cast<int>(J.cols());
  J.conservativeResize(Eigen::NoChange, local + dim);
  J.rightCols(dim).setZero();
  blocks[static_cast<std::size_t>(block_count)] = {column, local, dim};
  ++block_count;
  return local;
}

void linearise(const Window& window, const InertialTerm& term, LinearFactor& out) {
  const InertialFactor& f = term.f;
  const KeyframeState& xi = value(window, f.i);
  const KeyframeState& xj = value(window, f.j);
  out.start(15);
  const int ci = append(window, f.i, kStateDim, out);
  const int cj = append(window, f.j, kStateDim, out);
  const InertialRows rows = inertial_rows(f, xi, xj);
  out.r.head<9>() = term.root * rows.r;
  out.J.block<9, 6>(0, ci) = term.root * (rows.d_pose_i * d_imu_d_body(xi, f.T_body_imu));
  out.J.block<9, 6>(0, cj) = term.root * (rows.d_pose_j * d_imu_d_body(xj, f.T_body_imu));
  out.J.block<9, 3>(0, ci + kVel) = term.root * rows.d_velocity_i;
  out.J.block<9, 3>(0, cj + kVel) = term.root * rows.d_velocity_j;
  out.J.block<9, 6>(0, ci + kGyroBias) = term.root * rows.d_bias;
  bias_walk(f, xi, xj, ci, cj, out);
  out.finish();
}

void linearise(const Window& window, const RelativeTerm& term, LinearFactor& out) {
  out.start(6);
  const int ci = append(window, term.f.i, kPoseDim, out);
  const int cj = append(window, term.f.j, kPoseDim, out);
  relative_rows(value(window, term.f.i).T_odom_body, value(window, term.f.j).T_odom_body,
                term.f.T_i_j, term.root, 0, ci, cj, out);
  out.finish();
}

void linearise(const Window& window, const LoopTerm& loop, LinearFactor& out) {
  linearise(window, loop.term, out);
  const double root = std::sqrt(loop.weight);
  out.r *= root;
  out.J *= root;
  out.finish();
}

void linearise(const Window& window, const StandstillFactor& f, LinearFactor& out) {
  const KeyframeNode& node = window.node(f.i);
  const KeyframeState& xi = node.x;
  const int velocity = node.dim > kPoseDim ? 3 : 0;
  out.start(velocity + (f.next ? kPoseDim : 0));
  const int ci = append(window, f.i, kPoseDim + velocity, out);
  if (velocity > 0) {
    out.r.head<3>() = xi.v_odom_mps / f.sigma_mps;
    out.J.block<3, 3>(0, ci + kVel).diagonal().setConstant(1.0 / f.sigma_mps);
  }
  if (f.next) {
    const int cj = append(window, *f.next, kPoseDim, out);
    geometry::Mat6 root = geometry::Mat6::Zero();
    root.diagonal() << Vec3::Constant(1.0 / f.sigma_rad), Vec3::Constant(1.0 / f.sigma_m);
    relative_rows(xi.T_odom_body, value(window, *f.next).T_odom_body, {}, root, velocity, ci, cj,
                  out);
  }
  out.finish();
}

void linearise(const Window& window, const GravityFactor& f, LinearFactor& out) {
  out.start(3);
  const int c = append(window, f.i, kPoseDim, out);
  const Vec3 up = value(window, f.i).T_odom_body.R.transpose() * Vec3::UnitZ();
  out.r = (up - f.up_body) / f.sigma_rad;
  out.J.block<3, 3>(0, c + kTheta) = skew(up) / f.sigma_rad;
  out.finish();
}

void linearise(const Window& window, const PriorTerm& term, LinearFactor& out) {
  const KeyframeNode& node = window.node(term.f.i);
  out.start(kStateDim);
  append(window, term.f.i, node.dim, out);
  StateVec delta = boxminus(node.x, term.f.mean);
  delta.tail(kStateDim - node.dim).setZero();
  out.r = term.root * delta;
  out.J = (term.root * boxminus_jacobian(delta)).leftCols(node.dim);
  out.finish();
}

void linearise(const Window& window, const GlobalNode& global, LinearFactor& out) {
  const int dim = global.dim();
  out.start(dim);
  out.append(window.column(global.id), dim);
  const Eigen::MatrixXd root = information_root(global.prior_information.topLeftCorner(dim, dim));
  out.r = root * (global.value - global.prior_mean).head(dim);
  out.J = root;
  out.finish();
}

namespace {

/// Difference of the window from the prior's linearisation point, and the columns of its blocks.
Eigen::VectorXd delta_of(const Window& window, const DensePrior& prior) {
  Eigen::VectorXd delta(prior.H.rows());
  int at = 0;
  for (const auto& block : prior.keyframes) {
    const KeyframeNode& node = window.node(block.seq);
    delta.segment(at, node.dim) = boxminus(node.x, block.x_lin).head(node.dim);
    at += node.dim;
  }
  for (const auto& block : prior.globals) {
    const int dim = dimension(block.id.kind);
    delta.segment(at, dim) = (value(window, block.id).value - block.x_lin).head(dim);
    at += dim;
  }
  return delta;
}

}  // namespace

double cost(const Window& window, const DensePrior& prior) {
  const Eigen::VectorXd delta = delta_of(window, prior);
  return prior.cost + prior.b.dot(delta) + 0.5 * delta.dot(prior.H * delta);
}

LinearPrior linearise(const Window& window, const DensePrior& prior) {
  LinearPrior out;
  const Eigen::VectorXd delta = delta_of(window, prior);
  const Eigen::VectorXd Hd = prior.H * delta;
  out.cost = prior.cost + prior.b.dot(delta) + 0.5 * delta.dot(Hd);
  out.H = prior.H;
  out.gradient = prior.b + Hd;
  // The Jacobian of boxminus is the identity but for the rotations.
  int at = 0;
  for (const auto& block : prior.keyframes) {
    const int dim = window.node(block.seq).dim;
    const int turn = at + kTheta;
    const geometry::Mat3 J = geometry::so3_right_jacobian_inverse(delta.segment<3>(turn));
    out.H.middleCols<3>(turn) = out.H.middleCols<3>(turn) * J;
    out.H.middleRows<3>(turn) = J.transpose() * out.H.middleRows<3>(turn);
    out.gradient.segment<3>(turn) = J.transpose() * out.gradient.segment<3>(turn);
    out.blocks.push_back({window.column(block.seq), at, dim});
    at += dim;
  }
  for (const auto& block : prior.globals) {
    const int dim = dimension(block.id.kind);
    out.blocks.push_back({window.column(block.id), at, dim});
    at += dim;
  }
  return out;
}

}  // namespace rali::graph
