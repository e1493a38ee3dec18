#include "rali/vehicle/noise_tally.hpp"

#include <gtest/gtest.h>

namespace rali::vehicle {
namespace {

TEST(NoiseTally, is_the_geometric_mean_of_the_available_measurements) {
  NoiseTally tally;
  EXPECT_FALSE(tally.mean().accel_mps2_rthz);
  tally.add({std::nullopt, 0.01});
  tally.add({});
  tally.add({0.002, 1.0});
  EXPECT_NEAR(*tally.mean().accel_mps2_rthz, 0.1, 1e-12);
  EXPECT_NEAR(*tally.mean().gyro_radps_rthz, 0.002, 1e-15);
}

}  // namespace
}  // namespace rali::vehicle
