#include "rali/ranging/path_fit.hpp"

#include <gtest/gtest.h>

namespace rali::ranging {
namespace {

bool last_fits(const std::vector<double>& residuals_m) {
  ExcessWatch watch{ExcessSettings{}};
  bool fits = false;
  for (std::size_t k = 0; k < residuals_m.size(); ++k) {
    fits = fits_path(watch, Time::from_s(0.05 * static_cast<double>(k)), residuals_m[k], 0.05, 0.1,
                     GateSettings{});
  }
  return fits;
}

TEST(PathFit, rejects_ranges_outside_the_gate_or_with_a_sudden_step) {
  EXPECT_TRUE(last_fits({0.02}));
  // 3.29 sigma of 0.112 m is 0.368 m.
  EXPECT_TRUE(last_fits({0.36}));
  EXPECT_FALSE(last_fits({0.38}));
  std::vector<double> step(20, 0.0);
  step.push_back(0.34);
  EXPECT_FALSE(last_fits(step)) << "inside the gate, but longer from one range to the next";
}

TEST(PathFit, a_calibrated_bias_has_a_fifth_of_the_sigma) {
  BiasSettings settings;
  settings.sigma_m = 0.1;
  EXPECT_DOUBLE_EQ(bias_sigma_m(settings, false), 0.1);
  EXPECT_DOUBLE_EQ(bias_sigma_m(settings, true), 0.02);
}

}  // namespace
}  // namespace rali::ranging
