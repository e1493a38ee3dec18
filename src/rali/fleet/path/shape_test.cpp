#include "rali/fleet/path/shape.hpp"

#include <gtest/gtest.h>

namespace rali::fleet {
namespace {

using geometry::Mat6;

/// Information along x that tie_by_filter() gives to a step that adds this sigma.
double information_of_step(double sigma_m) {
  Mat6 before = 1e-6 * Mat6::Identity(), after = before, shape = Mat6::Zero();
  after(3, 3) += sigma_m * sigma_m;
  tie_by_filter(shape, before, after, {0.05, 0.3});
  return shape(3, 3);
}

// A vehicle that drives when its recording begins, in a tunnel: nothing knows its speed.
TEST(TieByFilter, a_step_is_known_no_better_than_the_filter_knows_it) {
  EXPECT_NEAR(information_of_step(3.0), 1.0 / 9.0, 1e-9);
  EXPECT_NEAR(information_of_step(0.02), 1.0 / (0.3 * 0.3), 1e-9) << "the least sigma";
}

TEST(TieByFilter, a_covariance_that_shrinks_leaves_the_least_sigma) {
  Mat6 shape = Mat6::Zero();
  tie_by_filter(shape, Mat6::Identity(), 0.5 * Mat6::Identity(), {0.05, 0.3});
  EXPECT_NEAR(shape(4, 4), 1.0 / (0.3 * 0.3), 1e-9);
  EXPECT_NEAR(shape(0, 0), 1.0 / (0.05 * 0.05), 1e-9);
}

}  // namespace
}  // namespace rali::fleet
