#include "rali/graph/rotation_start.hpp"

#include <limits>
#include <numeric>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>

#include "rali/graph/block_cholesky.hpp"
#include "rali/graph/levenberg_marquardt.hpp"
#include "rali/graph/linearise.hpp"

namespace rali::graph {

using geometry::Mat3;
using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3;

namespace {

// Weak prior for an unconstrained position: sd 100 m, from the rotated original path.
constexpr double kWeakInformationM2 = 1e-4;
// Likewise for a rotation, about an unconstrained axis: sd of about 6 degrees.
constexpr double kWeakInformationRad2 = 100.0;
constexpr double kFloor = 1e-12;

// A relative pose with its weights.
struct Edge {
  int i = 0;  ///< indices in window.keyframes
  int j = 0;
  SE3 T_i_j;
  Mat3 chord = Mat3::Zero();  ///< weight of a difference of rotation matrices, see chord_of()
  Mat6 root = Mat6::Zero();
};

struct Anchor {
  int i = 0;
  SE3 T;
  double rotation_information = 0.0;
  double position_information = 0.0;
};

// D with |skew(theta) D|^2 = theta' Omega theta, as near as a real D can be: then (R_j - R_i R_i_j)
// D weights a rotation as the information does. D D' = tr(Omega)/2 - Omega.
Mat3 chord_of(const Mat3& information) {
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(
      Mat3(0.5 * information.trace() * Mat3::Identity() -
           0.5 * (information + information.transpose())));
  const Vec3 roots = eigen.eigenvalues().cwiseMax(kWeakInformationRad2).cwiseSqrt();
  return eigen.eigenvectors() * roots.asDiagonal() * eigen.eigenvectors().transpose();
}

SE3 between(const Window& window, int i, int j) {
  const auto& T = [&](int k) -> const SE3& {
    return window.keyframes[static_cast<std::size_t>(k)].x.T_odom_body;
  };
  return T(i).inverse() * T(j);
}

Edge edge_of(const Window& window, const RelativeTerm& term, double weight) {
  Edge e{window.find(term.f.i), window.find(term.f.j), term.f.T_i_j, Mat3::Zero(), term.root};
  e.root *= std::sqrt(weight);
  e.chord = chord_of(e.root.leftCols<3>().transpose() * e.root.leftCols<3>());
  return e;
}

std::vector<Edge> edges_of(const Window& window) {
  std::vector<Edge> edges;
  for (const RelativeTerm& term : window.relative) edges.push_back(edge_of(window, term, 1.0));
  for (const LoopTerm& loop : window.loops) {
    if (loop.weight > 0.0) edges.push_back(edge_of(window, loop.term, loop.weight));
  }
  for (const InertialTerm& term : window.inertial) {
    Edge e{window.find(term.f.i), window.find(term.f.j), {}, Mat3::Zero(), Mat6::Zero()};
    e.T_i_j = between(window, e.i, e.j);
    const Mat3& R_body_imu = term.f.T_body_imu.R;
    e.T_i_j.R = R_body_imu * term.f.dR * R_body_imu.transpose();
    e.chord = chord_of(term.root.leftCols<3>().transpose() * term.root.leftCols<3>());
    edges.push_back(e);
  }
  for (const StandstillFactor& f : window.standstill) {
    if (!f.next) continue;
    Edge e{window.find(f.i),
           window.find(*f.next),
           {},
           chord_of(Mat3::Identity() / (f.sigma_rad * f.sigma_rad)),
           Mat6::Zero()};
    e.root.diagonal().tail<3>().setConstant(1.0 / f.sigma_m);
    edges.push_back(e);
  }
  return edges;
}

std::vector<Anchor> anchors_of(const Window& window) {
  std::vector<Anchor> anchors;
  const auto anchor = [&](Seq seq, const SE3& T, const auto& information) {
    anchors.push_back({window.find(seq), T, information.diagonal().template head<3>().sum() / 3.0,
                       information.diagonal().template segment<3>(kPos).sum() / 3.0});
  };
  for (const PriorTerm& prior : window.priors) {
    anchor(prior.f.i, prior.f.mean.T_odom_body, prior.f.information);
  }
  int at = 0;
  for (const auto& block : window.dense.keyframes) {
    const int dim = window.node(block.seq).dim;
    anchor(block.seq, block.x_lin.T_odom_body, window.dense.H.block(at, at, dim, dim));
    at += dim;
  }
  return anchors;
}

// Index of the connected part of each node.
std::vector<int> parts(std::size_t nodes, const std::vector<Edge>& edges) {
  std::vector<int> part(nodes);
  std::iota(part.begin(), part.end(), 0);
  const auto root = [&](int k) {
    while (part[static_cast<std::size_t>(k)] != k) {
      auto& up = part[static_cast<std::size_t>(k)];
      up = part[static_cast<std::size_t>(up)];
      k = up;
    }
    return k;
  };
  for (const Edge& e : edges) {
    const int a = root(e.i);
    const int b = root(e.j);
    part[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
  }
  for (std::size_t k = 0; k < nodes; ++k) part[k] = root(static_cast<int>(k));
  return part;
}

// Parts without any anchor are anchored at their first node.
void hold_free_parts(const Window& window, const std::vector<Edge>& edges,
                     std::vector<Anchor>& anchors) {
  const std::vector<int> part = parts(window.keyframes.size(), edges);
  std::vector<bool> held_r(part.size(), false);
  std::vector<bool> held_p(part.size(), false);
  for (const Anchor& a : anchors) {
    const auto p = static_cast<std::size_t>(part[static_cast<std::size_t>(a.i)]);
    held_r[p] = held_r[p] || a.rotation_information > 0.0;
    held_p[p] = held_p[p] || a.position_information > 0.0;
  }
  for (std::size_t k = 0; k < part.size(); ++k) {
    const auto p = static_cast<std::size_t>(part[k]);
    if (window.keyframes[k].fixed) held_r[p] = held_p[p] = true;
  }
  for (std::size_t k = 0; k < part.size(); ++k) {
    const auto p = static_cast<std::size_t>(part[k]);
    if (held_r[p] && held_p[p]) continue;
    anchors.push_back({static_cast<int>(k), window.keyframes[k].x.T_odom_body,
                       held_r[p] ? 0.0 : 1.0, held_p[p] ? 0.0 : 1.0});
    held_r[p] = held_p[p] = true;
  }
}

// Linear least squares on three unknowns per free node, with `Rights` right sides.
class ThreePerNode {
 public:
  ThreePerNode(const Window& window, const std::vector<Edge>& edges, int rights) {
    std::vector<int> dims;
    for (const KeyframeNode& node : window.keyframes) {
      variable_.push_back(node.fixed ? -1 : static_cast<int>(dims.size()));
      if (!node.fixed) dims.push_back(3);
    }
    std::vector<std::pair<int, int>> pairs;
    for (const Edge& e : edges) {
      if (variable(e.i) >= 0 && variable(e.j) >= 0)
        pairs.emplace_back(variable(e.i), variable(e.j));
    }
    H_ = BlockMatrix(dims, pairs);
    right_.setZero(3 * static_cast<Eigen::Index>(dims.size()), rights);
  }

  /// Adds |A_i x_i + A_j x_j - c|^2; `known` is x of a node that is fixed.
  template <class A, class C, class Known>
  void add(int i, const A& A_i, int j, const A& A_j, C c, const Known& known) {
    if (variable(i) < 0) c -= A_i * known(i);
    if (variable(j) < 0) c -= A_j * known(j);
    diagonal(i, A_i, c);
    diagonal(j, A_j, c);
    if (variable(i) < 0 || variable(j) < 0) return;
    if (variable(i) > variable(j)) {
      H_.block(variable(i), variable(j)) += A_i.transpose() * A_j;
    } else {
      H_.block(variable(j), variable(i)) += A_j.transpose() * A_i;
    }
  }

  /// Adds |A x - c|^2.
  template <class A, class C>
  void diagonal(int i, const A& A_i, const C& c) {
    if (variable(i) < 0) return;
    H_.block(variable(i), variable(i)) += A_i.transpose() * A_i;
    right_.middleRows(3 * variable(i), 3) += A_i.transpose() * c;
  }

  bool solve() {
    BlockCholesky cholesky(H_, {});
    if (!cholesky.factorise(H_, kFloor, kFloor)) return false;
    x_ = cholesky.solve(right_);
    return x_.allFinite();
  }

  [[nodiscard]] Eigen::MatrixXd x(int i) const { return x_.middleRows(3 * variable(i), 3); }

 private:
  [[nodiscard]] int variable(int i) const { return variable_[static_cast<std::size_t>(i)]; }

  std::vector<int> variable_;
  BlockMatrix H_;
  Eigen::MatrixXd right_;
  Eigen::MatrixXd x_;
};

Mat3 nearest_rotation(const Mat3& M) {
  const Eigen::JacobiSVD<Mat3> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Vec3 sign(1.0, 1.0, (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0);
  return svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
}

// Unknown of a node: the transpose of its R, so that R_j = R_i R_i_j is x_j = R_i_j^T x_i.
bool solve_rotations(const Window& window, const std::vector<Edge>& edges,
                     const std::vector<Anchor>& anchors, std::vector<SE3>& poses) {
  ThreePerNode equations(window, edges, 3);
  const auto known = [&](int k) -> Mat3 {
    return poses[static_cast<std::size_t>(k)].R.transpose();
  };
  for (const Edge& e : edges) {
    equations.add(e.i, Mat3(-e.chord * e.T_i_j.R.transpose()), e.j, e.chord, Mat3(Mat3::Zero()),
                  known);
  }
  for (const Anchor& a : anchors) {
    const double root = std::sqrt(a.rotation_information);
    equations.diagonal(a.i, Mat3(root * Mat3::Identity()), Mat3(root * a.T.R.transpose()));
  }
  if (!equations.solve()) return false;
  for (std::size_t k = 0; k < poses.size(); ++k) {
    if (window.keyframes[k].fixed) continue;
    poses[k].R = nearest_rotation(equations.x(static_cast<int>(k)).transpose());
  }
  return true;
}

bool solve_positions(const Window& window, const std::vector<Edge>& edges,
                     const std::vector<Anchor>& anchors, std::vector<SE3>& poses) {
  using Mat63 = Eigen::Matrix<double, 6, 3>;
  ThreePerNode equations(window, edges, 1);
  const auto known = [&](int k) -> Vec3 { return poses[static_cast<std::size_t>(k)].p; };
  for (const Edge& e : edges) {
    const Mat3& R_i = poses[static_cast<std::size_t>(e.i)].R;
    const Mat3& R_j = poses[static_cast<std::size_t>(e.j)].R;
    const Vec3 turn = geometry::so3_log(e.T_i_j.R.transpose() * R_i.transpose() * R_j);
    const Mat63 d_j = e.root.rightCols<3>() * R_i.transpose();
    const geometry::Vec6 c = e.root.rightCols<3>() * e.T_i_j.p - e.root.leftCols<3>() * turn;
    equations.add(e.i, Mat63(-d_j), e.j, d_j, c, known);
    const Mat3 weak = std::sqrt(kWeakInformationM2) * Mat3::Identity();
    equations.add(e.i, Mat3(-weak), e.j, weak, Vec3(weak * (R_i * e.T_i_j.p)), known);
  }
  for (const Anchor& a : anchors) {
    const double root = std::sqrt(a.position_information);
    equations.diagonal(a.i, Mat3(root * Mat3::Identity()), Vec3(root * a.T.p));
  }
  if (!equations.solve()) return false;
  for (std::size_t k = 0; k < poses.size(); ++k) {
    if (!window.keyframes[k].fixed) poses[k].p = equations.x(static_cast<int>(k));
  }
  return true;
}

}  // namespace

bool start_from_rotations(Window& window) {
  const std::vector<Edge> edges = edges_of(window);
  std::vector<Anchor> anchors = anchors_of(window);
  hold_free_parts(window, edges, anchors);
  std::vector<SE3> poses;
  for (const KeyframeNode& node : window.keyframes) poses.push_back(node.x.T_odom_body);
  if (!solve_rotations(window, edges, anchors, poses) ||
      !solve_positions(window, edges, anchors, poses)) {
    return false;
  }
  for (std::size_t k = 0; k < poses.size(); ++k) {
    KeyframeState& x = window.keyframes[k].x;
    x.v_odom_mps = poses[k].R * (x.T_odom_body.R.transpose() * x.v_odom_mps);
    x.T_odom_body = poses[k];
  }
  return true;
}

int degrees_of_freedom(const Window& window) {
  Eigen::Index rows = 0;
  for_each_factor(window, std::numeric_limits<double>::infinity(),
                  [&](const LinearFactor& f) { rows += f.r.size(); });
  return std::max(1, static_cast<int>(rows) - window.columns());
}

bool start_if_poor(Window& window, const GraphSettings& settings) {
  const double cost = total_cost(window, settings.huber_sd);
  if (2.0 * cost <= settings.start_chi2_per_dof * degrees_of_freedom(window)) return false;
  SavedValues saved;
  saved.save(window);
  if (start_from_rotations(window) && total_cost(window, settings.huber_sd) < cost) return true;
  saved.restore(window);
  return false;
}

}  // namespace rali::graph
