#include "rali/wire/fleet/codec.hpp"

#include <cstdlib>
#include <limits>

#include <gtest/gtest.h>

#include "rali/fleet/facts/keyframe_number.hpp"
#include "rali/fleet/facts/quantise.hpp"
#include "rali/wire/fleet/crc32c.hpp"
#include "rali/wire/fleet/messages_for_test.hpp"
#include "rali/wire/fleet/pack.hpp"

namespace rali::wire {
namespace {

using fleet::Kind;

/// Puts the right checksum on modified bytes.
Bytes sealed(Bytes bytes) {
  const std::span<const std::byte> all(bytes);
  const std::uint32_t sum = crc32c(all.subspan(10), crc32c(all.first(6)));
  for (std::size_t k = 0; k < 4; ++k) bytes[6 + k] = static_cast<std::byte>(sum >> (8 * k) & 0xFFU);
  return bytes;
}

const fleet::Fact& fact_of(const fleet::Envelope& envelope) {
  return *std::get<fleet::FactMessage>(envelope.message).fact;
}

TEST(Crc32c, of_123456789_is_the_published_value_whole_and_in_parts) {
  const std::string text = "123456789";
  const auto bytes = std::as_bytes(std::span(text.data(), text.size()));
  EXPECT_EQ(crc32c(bytes), 0xE3069283U);
  EXPECT_EQ(crc32c(bytes.subspan(4), crc32c(bytes.first(4))), 0xE3069283U);
}

TEST(FleetCodec, a_withheld_message_has_the_documented_bytes) {
  // version 1, kind 22, from 1, to all, checksum, section 1 of 5 bytes: vehicle 3, epoch 1, one gap
  // from 7 to 7 + 2.
  const fleet::Envelope envelope{VehicleId{1}, std::nullopt,
                                 fleet::Withheld{{VehicleId{3}, 1}, {{7, 9}}}};
  const Bytes bytes = *encode_envelope(envelope);
  const std::vector<int> expected = {1, 22, 1, 0, 0xFF, 0xFF, -1, -1, -1, -1, 1, 5, 3, 1, 1, 7, 2};
  ASSERT_EQ(bytes.size(), expected.size());
  for (std::size_t k = 0; k < bytes.size(); ++k) {
    if (expected[k] >= 0) {
      EXPECT_EQ(std::to_integer<int>(bytes[k]), expected[k]) << k;
    }
  }
}

TEST(FleetCodec, re_encoding_a_decoded_message_gives_the_same_bytes) {
  for (const fleet::Envelope& envelope : all_messages()) {
    const auto bytes = encode_envelope(envelope);
    ASSERT_TRUE(bytes) << bytes.error().message();
    const auto back = decode_envelope(*bytes);
    ASSERT_TRUE(back) << back.error().message();
    EXPECT_EQ(back->from, envelope.from);
    EXPECT_EQ(back->to, envelope.to);
    EXPECT_EQ(back->message.index(), envelope.message.index());
    EXPECT_EQ(fleet::kind_of(back->message), envelope_kind(*bytes));
    EXPECT_EQ(*encode_envelope(*back), *bytes) << fleet::name_of(envelope_kind(*bytes));
  }
}

TEST(FleetCodec, a_decoded_fact_equals_the_quantised_original) {
  Rng rng(3);
  for (int k = 0; k < 5 * fleet::kBodies; ++k) {
    const fleet::Envelope envelope =
        fact_envelope(fleet::random_body(rng, k % fleet::kBodies, VehicleId{3}));
    const auto back = decode_envelope(*encode_envelope(envelope));
    ASSERT_TRUE(back);
    EXPECT_EQ(fleet::content_hash(fact_of(*back)),
              fleet::content_hash(*fleet::quantised(fact_of(envelope))))
        << "kind " << k % fleet::kBodies;
  }
}

TEST(FleetCodec, fields_of_messages_without_facts_survive_a_round_trip) {
  const std::vector<fleet::Envelope> all = all_messages();
  const auto again = [&all](std::size_t k) {
    return *decode_envelope(*encode_envelope(all[all.size() - k]));
  };
  const auto status = std::get<fleet::VehicleStatus>(again(2).message);
  const auto& status_in = std::get<fleet::VehicleStatus>(all[all.size() - 2].message);
  EXPECT_EQ(status.waits_for, status_in.waits_for);
  EXPECT_EQ(status.mode, status_in.mode);
  EXPECT_EQ(status.degenerate_azimuth_rad, 1.0);
  EXPECT_EQ(status.T_odom_body.p, status_in.T_odom_body.p);
  ASSERT_TRUE(status.drive_end);
  EXPECT_EQ(status.drive_end->state, fleet::DriveState::kBlocked);
  EXPECT_EQ(status.drive_end->goal_map_m, geometry::Vec3(9.0, 6.0, 0.5));
  const auto goals = std::get<fleet::GoalList>(again(1).message);
  EXPECT_EQ(goals.goals[0].frontier, 1U);
  EXPECT_EQ(goals.frontiers[1].centre_map_m, geometry::Vec3(10.0, 12.0, 0.0));
  const auto& goals_in = std::get<fleet::GoalList>(all[all.size() - 1].message);
  EXPECT_EQ(goals.memory, goals_in.memory);
  const auto finished = std::get<fleet::RoleMessage>(again(4).message);
  EXPECT_EQ(finished.inventory, some_inventory());
  EXPECT_EQ(finished.reason, fleet::FinishReason::kDistance);
  const auto ack = std::get<fleet::RoleMessage>(again(3).message);
  EXPECT_EQ(ack.t_received, Time::from_s(123.1));
  const auto table = std::get<fleet::Table>(again(6).message);
  const auto& table_in = std::get<fleet::Table>(all[all.size() - 6].message);
  ASSERT_EQ(table.poses.size(), 60U);
  for (std::size_t k = 0; k < table.poses.size(); ++k) {
    const fleet::TablePose& a = table.poses[k];
    const fleet::TablePose& b = table_in.poses[k];
    EXPECT_EQ(a.stream, b.stream);
    EXPECT_EQ(a.keyframe, b.keyframe);
    EXPECT_LT((a.T_map_body.p - b.T_map_body.p).cwiseAbs().maxCoeff(), 0.00051);
    EXPECT_LT((a.T_map_body.R - b.T_map_body.R).cwiseAbs().maxCoeff(), 1.5e-4);
    EXPECT_NEAR(a.sigma.major_m / b.sigma.major_m, 1.0, 0.031);
  }
  EXPECT_EQ(table.hash, table_in.hash);
  EXPECT_FALSE(table.last_part);
}

TEST(FleetCodec, keyframe_numbers_of_the_last_epoch_survive_a_round_trip) {
  constexpr std::uint32_t kEpoch = fleet::kEpochsMax - 1;
  const std::uint32_t last = fleet::first_keyframe_of(kEpoch) + (fleet::kKeyframesPerEpoch - 1);
  EXPECT_EQ(last, 0xFFFFFFFFU);
  EXPECT_EQ(fleet::epoch_of_keyframe(last), kEpoch);
  EXPECT_EQ(fleet::epoch_of_keyframe(fleet::first_keyframe_of(1) - 1), 0U);
  fleet::Increment step;
  step.keyframe = last;
  fleet::KeyframePoints points;
  points.keyframe = last;
  points.points = fleet::PackedPoints(fleet::PointArrays{{1.0F}, {1.0F}, {1.0F}, {}});
  fleet::Loop loop;
  loop.from = {VehicleId{1}, last};
  loop.to = {VehicleId{2}, 0};
  for (const fleet::FactBody& body :
       {fleet::FactBody{step}, fleet::FactBody{points}, fleet::FactBody{loop}}) {
    const fleet::Envelope envelope = fact_envelope(body);
    const auto bytes = encode_envelope(envelope);
    ASSERT_TRUE(bytes.has_value());
    const auto back = decode_envelope(*bytes);
    ASSERT_TRUE(back.has_value());
    EXPECT_EQ(fleet::content_hash(fact_of(*back)),
              fleet::content_hash(*fleet::quantised(fact_of(envelope))));
  }
  fleet::Table table;
  for (const std::uint32_t keyframe : {0U, last}) {
    table.poses.push_back({{VehicleId{1}, keyframe == 0 ? 0U : kEpoch}, keyframe, {}, {}});
  }
  const auto bytes = encode_envelope({VehicleId{0}, std::nullopt, table});
  ASSERT_TRUE(bytes.has_value());
  const auto back = decode_envelope(*bytes);
  ASSERT_TRUE(back.has_value());
  EXPECT_EQ(std::get<fleet::Table>(back->message).poses.at(1).keyframe, last);
}

TEST(FleetCodec, a_peer_state_is_assigned_to_its_sender) {
  fleet::PeerStatus reported{VehicleId{9}, Time::from_s(5.0), true, fleet::PeerPose{}};
  reported.pose->T_start_body.p = {1.5, -2.25, 0.125};
  reported.pose->position_covariance_m2 = Eigen::Vector3d(0.25, 0.01, 0.04).asDiagonal();
  reported.pose->walls = ranging::PassageWalls{geometry::Vec3::UnitY(), 1.5, 2.25};
  reported.pose->seen = {{VehicleId{2}, 1, {0.5, -1.25, 0.125}, geometry::Mat3::Identity()}};
  const auto back = decode_envelope(*encode_envelope({VehicleId{3}, std::nullopt, reported}));
  ASSERT_TRUE(back);
  const auto& received = std::get<fleet::PeerStatus>(back->message);
  EXPECT_EQ(received.vehicle, VehicleId{3}) << "nobody speaks for another";
  EXPECT_EQ(received.t, reported.t);
  EXPECT_TRUE(received.at_rest);
  ASSERT_TRUE(received.pose);
  EXPECT_EQ(received.pose->T_start_body.p, reported.pose->T_start_body.p);
  EXPECT_TRUE(
      received.pose->position_covariance_m2.isApprox(reported.pose->position_covariance_m2, 1e-6));
  ASSERT_TRUE(received.pose->walls);
  EXPECT_EQ(received.pose->walls->right_m, 2.25);
  ASSERT_EQ(received.pose->seen.size(), 1U);
  EXPECT_EQ(received.pose->seen[0].vehicle, VehicleId{2});
  EXPECT_EQ(received.pose->seen[0].antenna, 1);
  EXPECT_EQ(received.pose->seen[0].apart_start_m, reported.pose->seen[0].apart_start_m);
}

TEST(FleetCodec, truncated_messages_are_refused) {
  for (const fleet::Envelope& envelope : all_messages()) {
    const Bytes whole = *encode_envelope(envelope);
    const std::size_t step = whole.size() > 1000 ? 7 : 1;
    for (std::size_t n = 0; n < whole.size(); n += step) {
      const Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(n));
      EXPECT_FALSE(decode_envelope(cut));
      // And with a valid checksum for the truncated bytes; a message without an optional section is
      // valid, too.
      if (n < 10) continue;
      const auto lucky = decode_envelope(sealed(cut));
      if (lucky) {
        const Kind kind = fleet::kind_of(lucky->message);
        EXPECT_TRUE(kind == Kind::kRole || kind == Kind::kGoals || kind == Kind::kStatus)
            << static_cast<int>(kind);
      }
    }
  }
}

TEST(FleetCodec, damage_to_any_byte_is_detected_by_the_checksum) {
  const Bytes whole = *encode_envelope(all_messages()[1]);
  for (std::size_t k = 0; k < whole.size(); ++k) {
    for (const unsigned bit : {0U, 3U, 7U}) {
      Bytes damaged = whole;
      damaged[k] ^= static_cast<std::byte>(1U << bit);
      const auto result = decode_envelope(damaged);
      ASSERT_FALSE(result) << "byte " << k;
      EXPECT_NE(result.error().what.find("checksum"), std::string::npos);
    }
  }
}

TEST(FleetCodec, unknown_fields_of_a_newer_fact_are_forwarded) {
  for (int k = 0; k < fleet::kBodies; ++k) {
    Rng rng(static_cast<std::uint64_t>(k));
    Bytes newer = *encode_envelope(fact_envelope(fleet::random_body(rng, k, VehicleId{3})));
    for (const int b : {200, 3, 1, 2, 3, 201, 0}) newer.push_back(static_cast<std::byte>(b));
    newer = sealed(newer);
    const auto read = decode_envelope(newer);
    ASSERT_TRUE(read) << read.error().message();
    EXPECT_EQ(fact_of(*read).unread, (std::vector<std::uint8_t>{200, 3, 1, 2, 3, 201, 0}));
    EXPECT_EQ(*encode_envelope(*read), newer);
  }
}

TEST(FleetCodec, an_unknown_tag_of_an_inventory_message_is_ignored) {
  Bytes newer = *encode_envelope({VehicleId{1}, std::nullopt, some_inventory()});
  for (const int b : {77, 2, 9, 9}) newer.push_back(static_cast<std::byte>(b));
  const auto read = decode_envelope(sealed(newer));
  ASSERT_TRUE(read);
  EXPECT_EQ(std::get<fleet::Inventory>(read->message), some_inventory());
}

TEST(FleetCodec, facts_of_unknown_kind_are_kept_and_other_unknown_messages_dropped) {
  Bytes newer = *encode_envelope(all_messages()[1]);
  newer[1] = std::byte{13};
  newer = sealed(newer);
  const auto read = decode_envelope(newer);
  ASSERT_TRUE(read);
  EXPECT_EQ(std::get<fleet::UnreadBody>(fact_of(*read).body).kind, 13);
  EXPECT_EQ(fact_of(*read).key, (fleet::FactKey{VehicleId{3}, 7, 1234}));
  EXPECT_EQ(*encode_envelope(*read), newer);

  newer = *encode_envelope({VehicleId{1}, std::nullopt, some_inventory()});
  newer[1] = std::byte{30};
  const auto dropped = decode_envelope(sealed(newer));
  ASSERT_FALSE(dropped);
  EXPECT_EQ(dropped.error().code, ErrorCode::kNoAnswer);
}

TEST(FleetCodec, another_protocol_version_is_refused) {
  Bytes other = *encode_envelope(all_messages()[0]);
  other[0] = std::byte{2};
  const auto refused = decode_envelope(sealed(other));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kNoAnswer);
  EXPECT_NE(refused.error().what.find("version 2"), std::string::npos);
}

TEST(FleetCodec, a_list_size_larger_than_its_bytes_is_refused) {
  // A request that claims 2^40 wants in a section of 12 bytes.
  Bytes bytes = *encode_envelope({VehicleId{1}, std::nullopt, fleet::Request{}});
  bytes.resize(10);
  for (const int b : {1, 9, 0, 0, 0, 0x80, 0x80, 0x80, 0x80, 0x80, 0x20}) {
    bytes.push_back(static_cast<std::byte>(b));
  }
  const auto refused = decode_envelope(sealed(bytes));
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().what.find("too long a list"), std::string::npos);
}

TEST(FleetCodec, random_changes_with_a_valid_checksum_never_crash_the_decoder) {
  Rng rng(9);
  int read = 0;
  for (const fleet::Envelope& envelope : all_messages()) {
    const Bytes whole = *encode_envelope(envelope);
    for (int k = 0; k < 100; ++k) {
      Bytes changed = whole;
      for (int n = 0; n < 3; ++n) {
        changed[10 + rng.below(changed.size() - 10)] = static_cast<std::byte>(rng.below(256));
      }
      const auto result = decode_envelope(sealed(changed));
      if (!result) continue;
      ++read;
      // A decoded message can be encoded, and its bytes are then stable.
      const auto once = encode_envelope(*result);
      ASSERT_TRUE(once);
      const auto again = decode_envelope(*once);
      ASSERT_TRUE(again);
      EXPECT_EQ(*encode_envelope(*again), *once);
    }
  }
  EXPECT_GT(read, 100);
}

TEST(FleetCodec, nan_values_are_not_encoded) {
  fleet::Increment step;
  step.v_odom_mps.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(encode_envelope(fact_envelope(step)));
}

}  // namespace
}  // namespace rali::wire
