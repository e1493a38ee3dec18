#pragma once

#include <gtest/gtest.h>

#include "rali/graph/linearise.hpp"

namespace rali::graph {

/// Compares J and J^T r with central differences of residual and cost over every unknown of the
/// window. `derivative_of_r` is false with a robust loss: then J^T r is right but J is not dr/dx.
template <class Make>
void expect_derivatives(const Window& window, const Make& make, bool derivative_of_r = true) {
  constexpr double kStep = 1e-6;
  LinearFactor at;
  make(window, at);
  const int n = window.columns();
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(at.r.size(), n);
  for (int b = 0; b < at.block_count; ++b) {
    const auto& block = at.blocks[static_cast<std::size_t>(b)];
    if (block.column < 0) continue;
    J.middleCols(block.column, block.dim) = at.J.middleCols(block.local, block.dim);
  }
  for (int c = 0; c < n; ++c) {
    Eigen::VectorXd step = Eigen::VectorXd::Zero(n);
    step(c) = kStep;
    Window plus = window;
    plus.move(step);
    Window minus = window;
    minus.move(-step);
    LinearFactor up;
    LinearFactor down;
    make(plus, up);
    make(minus, down);
    if (derivative_of_r) {
      EXPECT_LT(((up.r - down.r) / (2.0 * kStep) - J.col(c)).cwiseAbs().maxCoeff(), 1e-6)
          << "column " << c;
    }
    EXPECT_NEAR((up.cost - down.cost) / (2.0 * kStep), J.col(c).dot(at.r),
                1e-6 * std::max(1.0, at.cost))
        << "column " << c;
  }
}

}  // namespace rali::graph
