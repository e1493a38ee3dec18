// Sizes of messages: algorithms_fleet 11.3, T24; the numbers are in README.md.
#include <algorithm>
#include <string>

#include <gtest/gtest.h>

#include "rali/wire/fleet/codec.hpp"
#include "rali/wire/fleet/corridor_for_test.hpp"
#include "rali/wire/fleet/messages_for_test.hpp"

namespace rali::wire {
namespace {

const fleet::KeyframePoints& points_of(const fleet::Envelope& envelope) {
  const auto& fact = *std::get<fleet::FactMessage>(envelope.message).fact;
  return std::get<fleet::KeyframePoints>(fact.body);
}

TEST(FleetSizes, a_corridor_keyframe_takes_at_most_10_kb) {
  const fleet::KeyframePoints points = corridor_keyframe(0.2, false);
  EXPECT_NEAR(static_cast<double>(points.size()), 4234.0, 0.25 * 4234.0) << "as in 11.3";
  const Bytes bytes = *encode_envelope(fact_envelope(points));
  RecordProperty("points", std::to_string(points.size()));
  RecordProperty("bytes", std::to_string(bytes.size()));
  EXPECT_LE(bytes.size(), 10000U);
  const auto back = decode_envelope(bytes);
  ASSERT_TRUE(back);
  ASSERT_EQ(points_of(*back).size(), points.size());
  EXPECT_EQ(points_of(*back).points.bytes(), points.points.bytes());
  EXPECT_EQ(*encode_envelope(*back), bytes);
}

TEST(FleetSizes, points_at_the_limits_of_the_coordinate_range_survive) {
  fleet::PointArrays arrays;
  for (const float far : {10485.7F, -10485.7F, 0.0F, 0.004F, -0.006F}) {
    arrays.push_back(far, -far, far);
  }
  fleet::KeyframePoints points;
  points.points = fleet::PackedPoints(arrays);
  const auto back = decode_envelope(*encode_envelope(fact_envelope(points)));
  ASSERT_TRUE(back);
  ASSERT_EQ(points_of(*back).size(), 5U);
  std::vector<float> x = points_of(*back).points.unpacked().x_m;
  std::sort(x.begin(), x.end());
  EXPECT_EQ(x, (std::vector<float>{-10485.7F, -0.01F, 0.0F, 0.0F, 10485.7F}));
}

TEST(FleetSizes, a_keyframe_without_points_survives_a_round_trip) {
  const auto back = decode_envelope(*encode_envelope(fact_envelope(fleet::KeyframePoints{})));
  ASSERT_TRUE(back);
  EXPECT_EQ(points_of(*back).size(), 0U);
}

TEST(FleetSizes, small_messages_stay_within_their_size_limits) {
  Rng rng(8);
  const auto size = [](const fleet::Envelope& envelope) {
    return encode_envelope(envelope)->size();
  };
  const auto soft = [](fleet::Message m) {
    return fleet::Envelope{VehicleId{1}, std::nullopt, std::move(m)};
  };
  const std::size_t increment = size(fact_envelope(fleet::random_increment(rng)));
  const std::size_t sixty = size(fact_envelope(fleet::random_ranges(rng, VehicleId{3}, 3, 60)));
  const std::size_t one = size(fact_envelope(fleet::random_ranges(rng, VehicleId{3}, 1, 1)));
  const double per_range = static_cast<double>(sixty - one) / 59.0;
  const std::size_t heartbeat = size(soft(some_role()));
  const std::size_t inventory = size(soft(some_inventory()));
  const double per_pose =
      static_cast<double>(size(soft(some_table(rng, 80))) - size(soft(some_table(rng, 20)))) / 60.0;
  fleet::PeerStatus peer{VehicleId{1}, Time::from_s(5.0), true, fleet::PeerPose{}};
  RecordProperty("peer_driving", std::to_string(size(soft(peer))));
  peer.pose->walls.emplace();
  peer.pose->seen.resize(1);
  const std::size_t standing = size(soft(peer));
  RecordProperty("peer_standing", std::to_string(standing));
  RecordProperty("increment", std::to_string(increment));
  RecordProperty("ranges_60", std::to_string(sixty));
  RecordProperty("per_range", std::to_string(per_range));
  RecordProperty("loop", std::to_string(size(fact_envelope(fleet::random_loop(rng)))));
  RecordProperty("heartbeat", std::to_string(heartbeat));
  RecordProperty("inventory", std::to_string(inventory));
  RecordProperty("per_pose", std::to_string(per_pose));
  RecordProperty("status_message", std::to_string(size(all_messages()[all_messages().size() - 2])));
  for (const double leaf_m : {0.1, 0.2, 0.4}) {
    for (const bool with_intensity : {false, true}) {
      const fleet::KeyframePoints points = corridor_keyframe(leaf_m, with_intensity);
      RecordProperty("points_" + std::to_string(leaf_m) + (with_intensity ? "_intensity" : ""),
                     std::to_string(points.size()) + " points, " +
                         std::to_string(size(fact_envelope(points))));
    }
  }
  EXPECT_LE(increment, 700U);
  EXPECT_LE(per_range, 16.0);
  EXPECT_LE(heartbeat, 100U);
  EXPECT_LE(standing, 170U) << "ten times a second: 0.1 MB per minute";
  EXPECT_LE(inventory, 60U);
  EXPECT_LE(per_pose, 24.0);
}

}  // namespace
}  // namespace rali::wire
