#pragma once

#include <array>

#include "rali/graph/window.hpp"

namespace rali::graph {

/// One factor at the present values: r + J d, both divided by sigma, and its cost r.r/2 (less with
/// a robust loss). Columns are those of the unknowns it involves, block by block.
struct LinearFactor {
  static constexpr int kRowsMax = 15;
  static constexpr int kColumnsMax = 38;  ///< four keyframes with velocity, bias, tau

  /// A keyframe contributes its pose (6), its pose and velocity (9) or all 15.
  struct Block {
    int column = 0;  ///< in the vector of unknowns; -1: fixed, not an unknown
    int local = 0;   ///< in J
    int dim = 0;
  };

  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kRowsMax, kColumnsMax> J;
  Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kRowsMax, 1> r;
  std::array<Block, 6> blocks;
  int block_count = 0;
  double cost = 0.0;

  void start(int rows);
  /// Appends zero columns for one unknown, and returns the first one's index in J.
  int append(int column, int dim);

  /// Sets the quadratic cost of r.
  void finish() { cost = 0.5 * r.squaredNorm(); }
};

// Each linearises the factor at the values of `window`. Residuals: algorithms 1.3, 4.1, 6.1,
// algorithms_fleet 8.1.
void linearise(const Window& window, const InertialTerm& term, LinearFactor& out);
void linearise(const Window& window, const RelativeTerm& term, LinearFactor& out);
void linearise(const Window& window, const LoopTerm& loop, LinearFactor& out);
/// A residual beyond huber_sd sigma gets less weight and linear cost.
void linearise(const Window& window, const RangeFactor& f, double huber_sd, LinearFactor& out);
void linearise(const Window& window, const StandstillFactor& f, LinearFactor& out);
void linearise(const Window& window, const GravityFactor& f, LinearFactor& out);
void linearise(const Window& window, const PriorTerm& term, LinearFactor& out);
/// The prior of one landmark, bias or tau.
void linearise(const Window& window, const GlobalNode& global, LinearFactor& out);

/// Range with its derivatives, not weighted: r = |h| + b + tau rate - u and J = dr/dx in the
/// columns of `out`.
void range_residual(const Window& window, const RangeFactor& f, LinearFactor& out);

/// Calls use(LinearFactor) for every factor but the dense prior, always in the same order.
template <class Use>
void for_each_factor(const Window& window, double huber_sd, const Use& use) {
  LinearFactor factor;
  const auto all = [&](const auto& terms) {
    for (const auto& term : terms) {
      linearise(window, term, factor);
      use(factor);
    }
  };
  all(window.priors);
  all(window.inertial);
  all(window.relative);
  all(window.loops);
  all(window.standstill);
  all(window.gravity);
  for (const RangeFactor& range : window.ranges) {
    linearise(window, range, huber_sd, factor);
    use(factor);
  }
  all(window.globals);
}

/// The dense prior at the present values, for the unknowns of its blocks in its order.
struct LinearPrior {
  Eigen::MatrixXd H;
  Eigen::VectorXd gradient;
  double cost = 0.0;
  std::vector<LinearFactor::Block> blocks;  ///< local: position in H
};

[[nodiscard]] LinearPrior linearise(const Window& window, const DensePrior& prior);

/// Cost of a prior alone, without its gradient: more steps are tried than accepted.
[[nodiscard]] double cost(const Window& window, const DensePrior& prior);

}  // namespace rali::graph
