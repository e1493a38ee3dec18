#include "rali/geometry/chi_square.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace rali::geometry {
namespace {

TEST(ChiSquare, tail_of_two_degrees_of_freedom_is_an_exponential) {
  for (const double x : {0.1, 2.0, 9.2, 50.0, 400.0}) {
    EXPECT_NEAR(chi2_tail(x, 2) / std::exp(-0.5 * x), 1.0, 1e-12) << x;
  }
}

TEST(ChiSquare, tail_of_one_degree_of_freedom_is_that_of_a_normal) {
  for (const double sigmas : {0.5, 1.0, 3.0, 6.0}) {
    EXPECT_NEAR(chi2_tail(sigmas * sigmas, 1) / std::erfc(sigmas / std::sqrt(2.0)), 1.0, 1e-9);
  }
}

TEST(ChiSquare, tail_agrees_with_published_tables) {
  EXPECT_NEAR(chi2_tail(11.345, 3), 0.01, 1e-5);
  EXPECT_NEAR(chi2_tail(22.458, 6), 0.001, 1e-6);
  EXPECT_NEAR(chi2_tail(0.872, 6), 0.99, 1e-4);
}

TEST(ChiSquare, tail_is_one_for_zero_negative_or_nan_input) {
  EXPECT_EQ(chi2_tail(0.0, 3), 1.0);
  EXPECT_EQ(chi2_tail(-1.0, 3), 1.0);
  EXPECT_EQ(chi2_tail(std::numeric_limits<double>::quiet_NaN(), 3), 1.0);
}

}  // namespace
}  // namespace rali::geometry
