#pragma once

// State folders without a live fleet, for tests of this room and above.

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "rali/drive/state/state_dir.hpp"
#include "rali/fleet/facts/quantise.hpp"

namespace rali::drive {

/// A fact as quantised for all vehicles.
inline fleet::FactPtr quantised_fact(VehicleId vehicle, std::uint32_t epoch, std::uint32_t seq,
                                     double t_s, fleet::FactBody body) {
  auto quantised = fleet::quantised({{vehicle, epoch, seq}, Time::from_s(t_s), std::move(body)});
  EXPECT_TRUE(quantised.has_value());
  return std::make_shared<const fleet::Fact>(std::move(*quantised));
}

/// Writes facts as `rali run` does for a vehicle in a fleet of four.
inline void write_state(const std::string& folder, VehicleId self,
                        const std::vector<fleet::FactPtr>& facts) {
  auto state =
      StateDir::open(folder, self, {VehicleId{0}, VehicleId{1}, VehicleId{2}, VehicleId{3}});
  ASSERT_TRUE(state.has_value()) << state.error().message();
  for (const fleet::FactPtr& fact : facts) ASSERT_TRUE(state->take(fleet::SaveFact{fact}));
  static_cast<void>(state->sync(Time::from_s(1.0), true));
  ASSERT_EQ(state->waiting(), 0U);
}

}  // namespace rali::drive
