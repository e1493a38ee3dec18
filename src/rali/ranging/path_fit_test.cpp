#include "rali/ranging/path_fit.hpp"

#include <gtest/gtest.h>

namespace rali::ranging {
namespace {

TEST(PathFit, rejects_ranges_outside_the_gate) {
  const auto fits = [](double nu_m) { return fits_path(nu_m, 0.05, 0.1, GateSettings{}); };
  EXPECT_TRUE(fits(0.02));
  // 3.29 sigma of 0.112 m is 0.368 m.
  EXPECT_TRUE(fits(0.36));
  EXPECT_FALSE(fits(0.38));
}

TEST(PathFit, a_calibrated_bias_has_a_fifth_of_the_sigma) {
  BiasSettings settings;
  settings.sigma_m = 0.1;
  EXPECT_DOUBLE_EQ(bias_sigma_m(settings, false), 0.1);
  EXPECT_DOUBLE_EQ(bias_sigma_m(settings, true), 0.02);
}

}  // namespace
}  // namespace rali::ranging
