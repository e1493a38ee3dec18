#pragma once

#include <vector>

#include "rali/graph/factors.hpp"

namespace rali::graph {

struct KeyframeNode {
  Seq seq = 0;
  KeyframeState x;
  int dim = kStateDim;  ///< kPoseDim: velocity and biases are not estimated
  bool fixed = false;   ///< not estimated
};

/// Landmark, bias or tau; a scalar uses the first coefficient.
struct GlobalNode {
  GlobalId id;
  geometry::Vec3 value = geometry::Vec3::Zero();
  geometry::Vec3 prior_mean = geometry::Vec3::Zero();
  geometry::Mat3 prior_information = geometry::Mat3::Zero();  ///< zero once it is in the dense
                                                              ///< prior

  [[nodiscard]] int dim() const { return dimension(id.kind); }
};

/// Factors with the square root of their information, computed once.
struct InertialTerm {
  InertialFactor f;
  Eigen::Matrix<double, 9, 9> root;  ///< root^T root = information
};

struct RelativeTerm {
  RelativePoseFactor f;
  geometry::Mat6 root;
};

/// Number of directions that a relative pose constrains.
[[nodiscard]] int rank(const RelativeTerm& term);

struct LoopTerm {
  std::uint64_t id = 0;
  RelativeTerm term;
  int dof = 6;          ///< rank of its information
  double weight = 1.0;  ///< 0: switched off
};

struct PriorTerm {
  PriorFactor f;
  StateMat root;
};

/// Prior left by marginalised keyframes: cost + b.d + d.H d/2 with d = x [-] x_lin over its blocks.
/// The linearisation points never change until the next marginalisation replaces them.
struct DensePrior {
  struct KeyframeBlock {
    Seq seq = 0;
    KeyframeState x_lin;
  };

  struct GlobalBlock {
    GlobalId id;
    geometry::Vec3 x_lin = geometry::Vec3::Zero();
  };

  std::vector<KeyframeBlock> keyframes;  ///< first in H, each with its node's `dim`
  std::vector<GlobalBlock> globals;      ///< then these
  Eigen::MatrixXd H;
  Eigen::VectorXd b;
  double cost = 0.0;
};

/// Values and factors of a graph: plain data, in the order they were added.
struct Window {
  std::vector<KeyframeNode> keyframes;  ///< by seq
  std::vector<GlobalNode> globals;      ///< by id
  std::vector<InertialTerm> inertial;
  std::vector<RelativeTerm> relative;
  std::vector<LoopTerm> loops;
  std::vector<RangeFactor> ranges;
  std::vector<StandstillFactor> standstill;
  std::vector<GravityFactor> gravity;
  std::vector<PriorTerm> priors;
  DensePrior dense;

  /// Index in `keyframes` or `globals`; -1 if absent.
  [[nodiscard]] int find(Seq seq) const;
  [[nodiscard]] int find(GlobalId id) const;

  [[nodiscard]] const KeyframeNode& node(Seq seq) const;

  /// First column of a keyframe or global in the vector of unknowns: keyframes first. -1 for a
  /// keyframe that is fixed.
  [[nodiscard]] int column(Seq seq) const;
  [[nodiscard]] int column(GlobalId id) const;
  [[nodiscard]] int columns() const;

  /// Assigns the columns: needed after each change of keyframes or globals.
  void lay_out();

  /// Moves every value by its part of delta.
  void move(const Eigen::VectorXd& delta);

 private:
  /// Assigned by lay_out(); the last element is the end.
  std::vector<int> keyframe_column_;
  std::vector<int> global_column_;
};

}  // namespace rali::graph
