#include "rali/net/envelope.hpp"

#include <algorithm>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

namespace rali::net {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr VehicleId kV1{1}, kV2{2}, kV3{3};

FleetKey key_of(std::uint8_t fill) {
  FleetKey key;
  key.bytes.fill(fill);
  return key;
}

Bytes bytes_of(std::string_view text) { return {text.begin(), text.end()}; }

class Envelope : public ::testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(sodium_is_ready()); }

  EnvelopeSealer v1_{kV1, 7, key_of(0x11)};
  EnvelopeOpener v2_{kV2, key_of(0x11), {{kV1, 0}, {kV3, 0}}};
};

TEST_F(Envelope, header_has_the_documented_byte_layout) {
  const Bytes sealed = v1_.seal(2, Urgency::kBulk, bytes_of("abc"));
  ASSERT_EQ(sealed.size(), 24U + 3U + 16U);
  const Bytes header{'R',           1, 2, 0, /*from*/ 1, 0, /*to*/ 2, 0, /*epoch*/ 7, 0, 0, 0,
                     /*counter*/ 1, 0, 0, 0, 0,          0, 0,        0, 0,           0, 0, 0};
  EXPECT_TRUE(std::equal(header.begin(), header.end(), sealed.begin()));
}

TEST_F(Envelope, opens_messages_sealed_with_the_same_key) {
  const OpenedEnvelope opened =
      v2_.open(Urgency::kRole, v1_.seal(kEveryone, Urgency::kRole, bytes_of("stand still")));
  EXPECT_EQ(opened.verdict, EnvelopeVerdict::kGenuine);
  EXPECT_EQ(opened.from, kV1);
  EXPECT_EQ(opened.message, bytes_of("stand still"));
  const OpenedEnvelope empty = v2_.open(Urgency::kRole, v1_.seal(2, Urgency::kRole, {}));
  EXPECT_EQ(empty.verdict, EnvelopeVerdict::kGenuine);
  EXPECT_TRUE(empty.message.empty());
}

TEST_F(Envelope, encrypts_the_message) {
  const Bytes text = bytes_of("a sentence of some length");
  const Bytes sealed = v1_.seal(2, Urgency::kBulk, text);
  EXPECT_EQ(std::search(sealed.begin(), sealed.end(), text.begin(), text.begin() + 4),
            sealed.end());
}

TEST_F(Envelope, one_flipped_bit_anywhere_is_detected) {
  const Bytes sealed = v1_.seal(2, Urgency::kBulk, bytes_of("fact"));
  for (std::size_t i = 0; i < 8 * sealed.size(); ++i) {
    Bytes damaged = sealed;
    damaged[i / 8] = static_cast<std::uint8_t>(damaged[i / 8] ^ (1U << (i % 8)));
    EXPECT_NE(v2_.open(Urgency::kBulk, damaged).verdict, EnvelopeVerdict::kGenuine) << "bit " << i;
  }
  EXPECT_EQ(v2_.open(Urgency::kBulk, sealed).verdict, EnvelopeVerdict::kGenuine);
}

TEST_F(Envelope, a_truncated_envelope_is_not_opened) {
  const Bytes sealed = v1_.seal(2, Urgency::kBulk, bytes_of("fact"));
  for (std::size_t n = 0; n < sealed.size(); ++n) {
    const auto verdict = v2_.open(Urgency::kBulk, std::span(sealed).first(n)).verdict;
    EXPECT_EQ(verdict, n < kEnvelopeBytes ? EnvelopeVerdict::kStranger : EnvelopeVerdict::kForged);
  }
}

TEST_F(Envelope, another_key_is_forged_and_an_unknown_vehicle_a_stranger) {
  EnvelopeSealer liar(kV1, 7, key_of(0x12));
  const OpenedEnvelope opened = v2_.open(Urgency::kRole, liar.seal(2, Urgency::kRole, Bytes(9)));
  EXPECT_EQ(opened.verdict, EnvelopeVerdict::kForged);
  EXPECT_EQ(opened.from, kV1);
  EnvelopeSealer stranger(VehicleId{9}, 7, key_of(0x11));
  EXPECT_EQ(v2_.open(Urgency::kRole, stranger.seal(2, Urgency::kRole, Bytes(9))).verdict,
            EnvelopeVerdict::kStranger);
}

TEST_F(Envelope, is_valid_only_for_its_receiver_and_topic) {
  EXPECT_EQ(v2_.open(Urgency::kBulk, v1_.seal(3, Urgency::kBulk, Bytes(4))).verdict,
            EnvelopeVerdict::kForged);
  EXPECT_EQ(v2_.open(Urgency::kRole, v1_.seal(2, Urgency::kStatus, Bytes(4))).verdict,
            EnvelopeVerdict::kForged);
}

TEST_F(Envelope, a_second_copy_is_reported_as_repeated) {
  const Bytes sealed = v1_.seal(2, Urgency::kBulk, Bytes(4));
  EXPECT_EQ(v2_.open(Urgency::kBulk, sealed).verdict, EnvelopeVerdict::kGenuine);
  const OpenedEnvelope again = v2_.open(Urgency::kBulk, sealed);
  EXPECT_EQ(again.verdict, EnvelopeVerdict::kRepeated);
  EXPECT_TRUE(again.message.empty());
}

TEST_F(Envelope, messages_may_arrive_out_of_order) {
  const Bytes first = v1_.seal(2, Urgency::kStatus, Bytes(1)),
              second = v1_.seal(2, Urgency::kStatus, Bytes(2));
  EXPECT_EQ(v2_.open(Urgency::kStatus, second).verdict, EnvelopeVerdict::kGenuine);
  EXPECT_EQ(v2_.open(Urgency::kStatus, first).verdict, EnvelopeVerdict::kGenuine);
}

TEST_F(Envelope, messages_from_an_earlier_epoch_of_the_sender_are_rejected) {
  const Bytes old = v1_.seal(2, Urgency::kRole, Bytes(4));
  EnvelopeSealer restarted(kV1, 8, key_of(0x11));
  EXPECT_EQ(v2_.open(Urgency::kRole, restarted.seal(2, Urgency::kRole, Bytes(4))).verdict,
            EnvelopeVerdict::kGenuine);
  EXPECT_EQ(v2_.open(Urgency::kRole, old).verdict, EnvelopeVerdict::kRepeated);

  EnvelopeOpener with_log(kV2, key_of(0x11), {{kV1, 8}});
  EXPECT_EQ(with_log.open(Urgency::kRole, old).verdict, EnvelopeVerdict::kRepeated);
}

TEST(SealedSample, is_a_cdr_byte_sequence) {
  const Bytes sample = encode_sealed(bytes_of("abc"));
  EXPECT_EQ(sample, (Bytes{0, 1, 0, 0, 3, 0, 0, 0, 'a', 'b', 'c'}));
  const auto body = decode_sealed(sample);
  EXPECT_EQ(Bytes(body.begin(), body.end()), bytes_of("abc"));
}

TEST(SealedSample, truncated_or_wrongly_encoded_samples_decode_to_empty) {
  const Bytes sample = encode_sealed(bytes_of("abc"));
  for (std::size_t n = 0; n < sample.size(); ++n) {
    EXPECT_TRUE(decode_sealed(std::span(sample).first(n)).empty()) << n;
  }
  EXPECT_TRUE(decode_sealed(Bytes{0, 0, 0, 0, 0, 0, 0, 3, 'a', 'b', 'c'}).empty());
  EXPECT_TRUE(decode_sealed(Bytes{0, 1, 0, 0, 255, 255, 255, 255, 'a'}).empty());
}

TEST(ReplayWindow, admits_each_counter_once) {
  ReplayWindow window;
  EXPECT_FALSE(window.admit(0, 0)) << "counters begin with 1";
  EXPECT_TRUE(window.admit(0, 1));
  EXPECT_FALSE(window.admit(0, 1));
  EXPECT_TRUE(window.admit(0, 1024));
  EXPECT_TRUE(window.admit(0, 2)) << "1022 behind";
  EXPECT_FALSE(window.admit(0, 2));
  EXPECT_FALSE(window.admit(0, 1));
  EXPECT_TRUE(window.admit(0, 1025));
  EXPECT_FALSE(window.admit(0, 1)) << "1024 behind: too old";
}

TEST(ReplayWindow, clears_old_counters_after_a_jump) {
  ReplayWindow window;
  EXPECT_TRUE(window.admit(0, 5));
  EXPECT_TRUE(window.admit(0, 5 + 1024)) << "the same place in the window";
  EXPECT_TRUE(window.admit(0, ~std::uint64_t{0}));
  EXPECT_FALSE(window.admit(0, ~std::uint64_t{0}));
  EXPECT_TRUE(window.admit(0, ~std::uint64_t{0} - 1023));
  EXPECT_FALSE(window.admit(0, 6));
}

TEST(ReplayWindow, rejects_counters_seen_before_a_restart) {
  ReplayWindow window(3);
  window.recall(3, 2000);
  EXPECT_FALSE(window.admit(3, 2000));
  EXPECT_FALSE(window.admit(3, 1500)) << "whether it came is not known";
  EXPECT_TRUE(window.admit(3, 2001));
  window.recall(3, 1000);
  window.recall(2, 9000);
  EXPECT_TRUE(window.admit(3, 2002)) << "older knowledge changes nothing";
  EXPECT_TRUE(window.admit(4, 1)) << "its sender has started anew";
}

TEST_F(Envelope, replayed_envelopes_are_rejected_after_a_restart_of_the_receiver) {
  EnvelopeSealer sealer(kV1, 5, key_of(0x11));
  std::vector<Bytes> heartbeats;
  for (int k = 0; k < 10; ++k) {
    heartbeats.push_back(sealer.seal(kEveryone, Urgency::kRole, Bytes{1, 2}));
  }
  const auto vote = sealer.seal(kV2.value, Urgency::kRole, Bytes{3});
  EnvelopeOpener before(kV2, key_of(0x11), {{kV1, 0}});
  // Two more arrived after the last save.
  for (std::size_t k = 0; k < 6; ++k) {
    static_cast<void>(before.open(Urgency::kRole, heartbeats[k]));
  }
  static_cast<void>(before.open(Urgency::kRole, vote));
  const std::vector<SeenCounter> saved = before.seen();
  for (std::size_t k = 6; k < 8; ++k) {
    static_cast<void>(before.open(Urgency::kRole, heartbeats[k]));
  }

  EnvelopeOpener after(kV2, key_of(0x11), {{kV1, 0}});
  after.recall(*decode_seen(encode_seen(saved)));
  for (std::size_t k = 0; k < 8; ++k) {
    EXPECT_EQ(after.open(Urgency::kRole, heartbeats[k]).verdict, EnvelopeVerdict::kRepeated) << k;
  }
  EXPECT_EQ(after.open(Urgency::kRole, vote).verdict, EnvelopeVerdict::kRepeated);
  EXPECT_EQ(after.open(Urgency::kRole, heartbeats[9]).verdict, EnvelopeVerdict::kGenuine);
  const auto next = sealer.seal(kV2.value, Urgency::kRole, Bytes{4});
  EXPECT_EQ(after.open(Urgency::kRole, next).verdict, EnvelopeVerdict::kGenuine)
      << "of votes none is passed over";
}

TEST(ReplayWindow, resets_with_each_new_epoch) {
  ReplayWindow window(3);
  EXPECT_FALSE(window.admit(2, 1));
  EXPECT_TRUE(window.admit(3, 9));
  EXPECT_TRUE(window.admit(4, 9));
  EXPECT_TRUE(window.admit(4, 1));
  EXPECT_FALSE(window.admit(3, 10));
}

}  // namespace
}  // namespace rali::net
