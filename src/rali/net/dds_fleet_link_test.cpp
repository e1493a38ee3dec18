#include "rali/net/dds_fleet_link.hpp"

#include <algorithm>

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "rali/net/internal/dds_config.hpp"
#include "rali/net/internal/dds_for_test.hpp"
#include "rali/net/internal/fleet_inbox.hpp"

namespace rali::net {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr VehicleId kV1{1}, kV2{2}, kV3{3};
constexpr const char* kSealedType = "rali_msgs::msg::dds_::Sealed_";
const Duration kSecond = Duration::from_s(1.0);

Bytes message(std::size_t size, std::uint8_t number = 0) {
  Bytes out(size);
  for (std::size_t i = 0; i < size; ++i) out[i] = static_cast<std::uint8_t>(i * 7 + number);
  return out;
}

/// Three vehicles on 127.0.0.1 to 127.0.0.3.
FleetLinkOptions options_of(VehicleId self, std::uint32_t epoch = 1) {
  FleetLinkOptions out;
  out.self = self;
  out.epoch = epoch;
  out.domain = domain_for_test();
  out.key.bytes.fill(0x33);
  for (const VehicleId vehicle : {kV1, kV2, kV3}) {
    const std::string address = "127.0.0." + std::to_string(vehicle.value);
    if (vehicle == self) {
      out.address = address;
    } else {
      out.peers.push_back({vehicle, address, 0});
    }
  }
  return out;
}

/// Settings of an outsider that is in the network, but not in the fleet.
std::string outsider_config() {
  FleetLinkOptions out = options_of(kV1);
  out.self = VehicleId{9};
  out.address = "127.0.0.9";
  out.peers.push_back({kV1, "127.0.0.1", 0});
  return cyclone_config(out);
}

const LinkCounts& row(const std::vector<LinkCounts>& counts, VehicleId peer) {
  return *std::find_if(counts.begin(), counts.end(),
                       [&](const LinkCounts& one) { return one.peer == peer; });
}

bool is_matched(const FleetLink& link, VehicleId peer) {
  const auto counts = link.counts();
  return row(counts, peer).matched;
}

/// Messages until there are `n`, for at most ten seconds.
std::vector<Arrived> take(FleetLink& link, std::size_t n) {
  std::vector<Arrived> out;
  const double end_s = seconds_now() + 10.0;
  while (out.size() < n && seconds_now() < end_s) {
    (void)link.wait(Duration::from_s(0.1));
    for (Arrived& one : link.take()) out.push_back(std::move(one));
  }
  return out;
}

/// As the sender of facts does: a refused message is kept and sent later.
bool send_in_time(FleetLink& link, std::optional<VehicleId> to, const Bytes& bytes,
                  double limit_s = 10.0) {
  return holds_within(limit_s, [&] { return link.send(to, Urgency::kBulk, bytes); });
}

class DdsFleetLinks : public ::testing::Test {
 protected:
  void SetUp() override {
    auto v1 = open_dds_fleet_link(options_of(kV1));
    if (!v1) GTEST_SKIP() << "no loopback for DDS: " << v1.error().message();
    v1_ = std::move(*v1);
    v2_ = open(options_of(kV2));
  }

  [[nodiscard]] static std::unique_ptr<FleetLink> open(const FleetLinkOptions& options) {
    auto link = open_dds_fleet_link(options);
    EXPECT_TRUE(link) << link.error().message();
    return link ? std::move(*link) : nullptr;
  }

  [[nodiscard]] bool is_joined() const {
    return holds_within(10.0, [&] { return is_matched(*v1_, kV2) && is_matched(*v2_, kV1); });
  }

  std::unique_ptr<FleetLink> v1_, v2_;
};

TEST_F(DdsFleetLinks, find_each_other_within_a_second) {
  const double start_s = seconds_now();
  EXPECT_TRUE(is_joined());
  EXPECT_LT(seconds_now() - start_s, 1.0);
  EXPECT_FALSE(is_matched(*v1_, kV3)) << "it is not there";
}

TEST_F(DdsFleetLinks, messages_of_every_urgency_arrive_whole) {
  ASSERT_TRUE(is_joined());
  EXPECT_TRUE(v1_->send(kV2, Urgency::kBulk, message((std::size_t{1} << 20) + 1024, 1)));
  EXPECT_TRUE(v1_->send(std::nullopt, Urgency::kRole, message(90, 2)));
  EXPECT_TRUE(v1_->send(kV2, Urgency::kRole, message(91, 3)));
  EXPECT_TRUE(v1_->send(std::nullopt, Urgency::kStatus, message(0)));
  EXPECT_TRUE(send_in_time(*v1_, std::nullopt, message(20'000, 4)));
  std::vector<Bytes> got;
  for (const Arrived& one : take(*v2_, 5)) {
    EXPECT_EQ(one.from, kV1);
    got.push_back(one.bytes);
  }
  std::vector<Bytes> sent{message((std::size_t{1} << 20) + 1024, 1), message(90, 2), message(91, 3),
                          message(0), message(20'000, 4)};
  std::sort(got.begin(), got.end());
  std::sort(sent.begin(), sent.end());
  EXPECT_TRUE(got == sent) << got.size() << " arrived";
  EXPECT_EQ(row(v1_->counts(), kV2).sent, 5U);
  EXPECT_EQ(row(v2_->counts(), kV1).arrived, 5U);
  EXPECT_EQ(v2_->strangers(), 0U);
}

TEST_F(DdsFleetLinks, oversized_messages_and_invalid_receivers_are_refused) {
  ASSERT_TRUE(is_joined());
  EXPECT_FALSE(v1_->send(kV2, Urgency::kBulk, message((std::size_t{1} << 20) + 1025)));
  EXPECT_FALSE(v1_->send(VehicleId{7}, Urgency::kRole, message(4))) << "of no fleet";
  EXPECT_FALSE(v1_->send(kV1, Urgency::kRole, message(4))) << "itself";
  EXPECT_FALSE(v1_->send(kV3, Urgency::kBulk, message(4))) << "not there";
  EXPECT_TRUE(v1_->send(kV3, Urgency::kRole, message(4))) << "roles are sent into nothing";
  EXPECT_TRUE(v1_->send(std::nullopt, Urgency::kBulk, message(4))) << "to all who are there";
  EXPECT_EQ(row(v1_->counts(), kV3).refused, 1U);
}

TEST_F(DdsFleetLinks, a_full_queue_refuses_messages_and_all_accepted_ones_arrive) {
  ASSERT_TRUE(is_joined());
  std::size_t taken = 0, refused = 0;
  for (int i = 0; i < 400; ++i) {
    ++(v1_->send(kV2, Urgency::kBulk, message(20'000)) ? taken : refused);
  }
  EXPECT_EQ(take(*v2_, taken).size(), taken);
  EXPECT_EQ(row(v1_->counts(), kV2).refused, refused);
}

TEST_F(DdsFleetLinks, a_restarted_vehicle_is_received_again) {
  ASSERT_TRUE(is_joined());
  EXPECT_TRUE(v1_->send(kV2, Urgency::kBulk, message(10)));
  EXPECT_EQ(take(*v2_, 1).size(), 1U);
  v1_.reset();
  EXPECT_TRUE(holds_within(10.0, [&] { return !is_matched(*v2_, kV1); }));
  v1_ = open(options_of(kV1, 2));
  ASSERT_TRUE(is_joined());
  EXPECT_TRUE(v1_->send(kV2, Urgency::kBulk, message(11)));
  const auto arrived = take(*v2_, 1);
  ASSERT_EQ(arrived.size(), 1U);
  EXPECT_EQ(arrived[0].bytes, message(11));
}

TEST_F(DdsFleetLinks, forged_replayed_and_truncated_samples_are_counted_and_dropped) {
  ASSERT_TRUE(is_joined());
  OutsiderForTest thief(outsider_config(), "rt/rali/bulk", kSealedType);
  ASSERT_EQ(thief.error(), "");
  thief.open_reader(qos_for_test(true, "v2"));
  thief.open_writer(qos_for_test(true, "v2"));
  // Two readers of partition v2, so that messages to v2 reach the thief too.
  ASSERT_TRUE(holds_within(10.0, [&] { return thief.is_matched(); }));
  std::vector<Bytes> stolen;
  std::uint64_t sent = 0;
  EXPECT_TRUE(holds_within(10.0, [&] {
    sent += v1_->send(kV2, Urgency::kBulk, message(500)) ? 1U : 0U;
    stolen = thief.take();
    return !stolen.empty();
  }));
  ASSERT_EQ(take(*v2_, sent).size(), sent);

  // That the thief sees v2 does not mean that v2 sees the thief yet.
  const Bytes too_short{0, 1, 0, 0, 3, 0, 0, 0, 'R', 1, 2};
  ASSERT_TRUE(holds_within(10.0, [&] { return thief.write(too_short) && v2_->strangers() > 0; }));
  std::this_thread::sleep_for(std::chrono::milliseconds(200));  // the last of them arrive
  const std::uint64_t strangers = v2_->strangers();

  Bytes forged = stolen[0];
  forged[60] = static_cast<std::uint8_t>(forged[60] ^ 1U);
  Bytes cut_inside = stolen[0];
  cut_inside.resize(100);
  EXPECT_TRUE(thief.write(stolen[0]));
  EXPECT_TRUE(thief.write(forged));
  EXPECT_TRUE(thief.write(cut_inside)) << "shorter than its own length says";
  EXPECT_TRUE(thief.write(too_short));
  EXPECT_TRUE(thief.write(encode_sealed(Bytes(2 << 20)))) << "larger than any message";
  EXPECT_TRUE(holds_within(10.0, [&] { return v2_->strangers() == strangers + 3; }));
  EXPECT_EQ(row(v2_->counts(), kV1).repeated, 1U);
  EXPECT_EQ(row(v2_->counts(), kV1).forged, 1U);
  EXPECT_EQ(row(v2_->counts(), kV1).arrived, sent);
  EXPECT_TRUE(v2_->take().empty());
}

TEST_F(DdsFleetLinks, a_flood_of_forged_messages_does_not_fill_the_queue) {
  ASSERT_TRUE(is_joined());
  OutsiderForTest hostile(outsider_config(), "rt/rali/role", kSealedType);
  ASSERT_EQ(hostile.error(), "");
  hostile.open_writer(qos_for_test(false, "all"));
  ASSERT_TRUE(holds_within(10.0, [&] { return hostile.is_matched(); }));
  FleetKey wrong;
  EnvelopeSealer liar(kV1, 99, wrong);
  std::size_t received = 0;
  for (int i = 0; i < 3000; ++i) {
    EXPECT_TRUE(hostile.write(encode_sealed(liar.seal(kEveryone, Urgency::kRole, message(200)))));
    if (i % 300 == 0) {
      EXPECT_TRUE(v1_->send(kV2, Urgency::kBulk, message(300)));
      received += take(*v2_, 1).size();
    }
  }
  EXPECT_EQ(received, 10U);
  EXPECT_TRUE(holds_within(10.0, [&] { return row(v2_->counts(), kV1).forged > 1000; }));
  EXPECT_TRUE(v2_->take().empty());
}

TEST_F(DdsFleetLinks, a_flooding_fleet_member_loses_only_its_own_messages) {
  FleetLinkOptions small = options_of(kV2);
  small.queue_bytes_max = 100'000;
  v2_.reset();
  v2_ = open(small);
  auto v3 = open(options_of(kV3));
  ASSERT_TRUE(is_joined());
  ASSERT_TRUE(holds_within(10.0, [&] { return is_matched(*v3, kV2) && is_matched(*v2_, kV3); }));
  for (int i = 0; i < 40; ++i) EXPECT_TRUE(send_in_time(*v3, kV2, message(10'000)));
  EXPECT_TRUE(holds_within(10.0, [&] { return row(v2_->counts(), kV3).arrived == 40; }));
  EXPECT_TRUE(send_in_time(*v1_, kV2, message(20'000)));
  EXPECT_TRUE(holds_within(10.0, [&] { return row(v2_->counts(), kV1).arrived == 1; }));
  std::size_t of_v1 = 0, of_v3 = 0;
  for (const Arrived& one : v2_->take()) ++(one.from == kV1 ? of_v1 : of_v3);
  EXPECT_EQ(of_v1, 1U);
  EXPECT_EQ(of_v3, 10U);
  EXPECT_EQ(row(v2_->counts(), kV3).overflowed, 30U);
  EXPECT_EQ(row(v2_->counts(), kV1).overflowed, 0U);
}

/// A vehicle in a process of its own, which can be killed at once.
class OtherProcess {
 public:
  explicit OtherProcess(const FleetLinkOptions& options) {
    pid_ = ::fork();
    if (pid_ != 0) return;
    const auto link = open_dds_fleet_link(options);
    while (link && ::getppid() != 1) {
      (void)(*link)->wait(Duration::from_s(0.1));
      (void)(*link)->take();
    }
    ::_exit(1);
  }

  ~OtherProcess() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }

  OtherProcess(const OtherProcess&) = delete;
  OtherProcess& operator=(const OtherProcess&) = delete;

  void stop() const { ::kill(pid_, SIGSTOP); }

 private:
  pid_t pid_ = -1;
};

TEST(DdsFleetLink, a_stopped_vehicle_does_not_delay_messages_to_others) {
  const FleetLinkOptions third = options_of(kV3);  // before the fork: the domain is by process
  const OtherProcess v3(third);
  const auto v1 = open_dds_fleet_link(options_of(kV1)), v2 = open_dds_fleet_link(options_of(kV2));
  if (!v1 || !v2) GTEST_SKIP() << "no loopback for DDS";
  ASSERT_TRUE(holds_within(10.0, [&] {
    return is_matched(**v1, kV2) && is_matched(**v1, kV3) && is_matched(**v2, kV1);
  }));
  v3.stop();
  double longest_gap_s = 0.0, longest_send_s = 0.0;
  std::size_t refused = 0;
  for (int i = 0; i < 200; ++i) {
    const double start_s = seconds_now();
    refused += (*v1)->send(kV3, Urgency::kBulk, message(20'000)) ? 0U : 1U;
    longest_send_s = std::max(longest_send_s, seconds_now() - start_s);
    EXPECT_TRUE(send_in_time(**v1, kV2, message(20'000)));
    EXPECT_EQ(take(**v2, 1).size(), 1U);
    longest_gap_s = std::max(longest_gap_s, seconds_now() - start_s);
  }
  EXPECT_GT(refused, 0U) << "the queue to the dead one is bounded";
  EXPECT_LT(longest_gap_s, 1.0);
  EXPECT_LT(longest_send_s, 0.5);
  RecordProperty("longest_gap_ms", static_cast<int>(1000.0 * longest_gap_s));
}

TEST(DdsFleetLink, options_out_of_range_are_refused) {
  const auto refused = [](const FleetLinkOptions& options) {
    const auto link = open_dds_fleet_link(options);
    return !link && link.error().code == ErrorCode::kUsage;
  };
  FleetLinkOptions options = options_of(kV1);
  options.domain = 230;
  EXPECT_TRUE(refused(options));
  options = options_of(kV1);
  options.peers[0].id = kV1;
  EXPECT_TRUE(refused(options)) << "a number twice";
  options = options_of(kV1);
  options.peers[0].address = options.address;
  EXPECT_TRUE(refused(options)) << "an address twice";
  options = options_of(kV1);
  options.peers[0].address = "10.0.0.2";
  EXPECT_TRUE(refused(options)) << "partly on one machine";
  for (const char* address : {"", "here", "0.0.0.0", "239.255.0.1", "127.0.0.101", "127.1.0.1"}) {
    options = options_of(kV1);
    options.address = address;
    EXPECT_TRUE(refused(options)) << address;
  }
}

TEST(DdsFleetLink, an_address_of_another_machine_is_named_in_the_error) {
  FleetLinkOptions options = options_of(kV1);
  options.address = "203.0.113.1";
  options.peers = {{kV2, "203.0.113.2", 0}};
  const auto link = open_dds_fleet_link(options);
  ASSERT_FALSE(link);
  EXPECT_EQ(link.error().code, ErrorCode::kMachine);
  EXPECT_EQ(link.error().where, "203.0.113.1");
}

TEST(DdsFleetLink, a_second_instance_of_a_vehicle_is_refused) {
  const auto first = open_dds_fleet_link(options_of(kV1));
  if (!first) GTEST_SKIP() << "no loopback for DDS";
  const auto second = open_dds_fleet_link(options_of(kV1));
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::kMachine);
}

TEST(DdsFleetLink, cyclone_configuration_has_the_interface_index_peers_and_message_size) {
  FleetLinkOptions options = options_of(kV2);
  options.domain = 77;
  const std::string local = cyclone_config(options);
  EXPECT_NE(local.find("<NetworkInterface address=\"127.0.0.1\" multicast=\"false\"/>"),
            std::string::npos);
  EXPECT_NE(local.find("<ParticipantIndex>1</ParticipantIndex>"), std::string::npos);
  EXPECT_NE(local.find("<Peer address=\"127.0.0.1:26660\"/><Peer address=\"127.0.0.1:26664\"/>"),
            std::string::npos)
      << local;
  options.address = "10.77.0.2";
  options.peers = {{kV1, "10.77.0.1", 0}};
  const std::string radio = cyclone_config(options);
  EXPECT_NE(radio.find("address=\"10.77.0.2\""), std::string::npos);
  EXPECT_NE(radio.find("<ParticipantIndex>0</ParticipantIndex>"), std::string::npos);
  EXPECT_NE(radio.find("<Peer address=\"10.77.0.1\"/>"), std::string::npos);
  EXPECT_NE(radio.find("<MaxMessageSize>1300B</MaxMessageSize>"), std::string::npos);
}

}  // namespace
}  // namespace rali::net
