#include "hostile_peer.hpp"

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <thread>

#include <gtest/gtest.h>
#include <unistd.h>

#include "rali/fleet/facts/quantise.hpp"
#include "rali/host/exact_vehicle_for_test.hpp"
#include "rali/net/internal/dds_for_test.hpp"

// Unauthenticated messages have no effect: a fleet of three agents over DDS, and an attacker
// without the key who sends everything that can be sent.

namespace rali::test {
namespace {

using geometry::SE3;
using geometry::Vec3;

constexpr int kVehicles = 3;
constexpr double kStep_s = 0.1;
constexpr double kSpeed = 4.0;  ///< simulated seconds per real second

/// One attack takes some seconds; `make soak` repeats it with other seeds.
int attacks() { return std::getenv("RALI_SOAK") == nullptr ? 1 : 12; }

net::FleetLinkOptions options_of(int self) {
  net::FleetLinkOptions out;
  out.self = VehicleId{static_cast<std::uint16_t>(self)};
  out.epoch = 1;
  out.domain = net::domain_for_test();
  out.key.bytes.fill(0x33);
  for (int v = 0; v < kVehicles; ++v) {
    const std::string address = "127.0.0." + std::to_string(v + 1);
    if (v == self) {
      out.address = address;
    } else {
      out.peers.push_back({VehicleId{static_cast<std::uint16_t>(v)}, address, 0});
    }
  }
  return out;
}

/// Memory of this process that is in use [MiB].
double resident_mib() {
  std::ifstream file("/proc/self/statm");
  double pages = 0.0;
  file >> pages >> pages;
  return pages * static_cast<double>(::sysconf(_SC_PAGESIZE)) / (1024.0 * 1024.0);
}

/// Three vehicles in the hall: the first is stationary, the others drive eight metres.
class Fleet {
 public:
  /// False: DDS is not available.
  bool open() {
    for (int v = 0; v < kVehicles; ++v) {
      auto link = net::open_dds_fleet_link(options_of(v));
      if (!link) return false;
      vehicles_.push_back(std::make_unique<host::ExactVehicle>(
          v, names_, starts_, v == 0 ? 0.0 : 0.5, std::move(*link), host::HostTime{now_, now_}));
    }
    return true;
  }

  void run(double duration_s) {
    for (int k = 0; k < static_cast<int>(duration_s / kStep_s); ++k) {
      const auto next =
          std::chrono::steady_clock::now() + std::chrono::duration_cast<std::chrono::nanoseconds>(
                                                 std::chrono::duration<double>(kStep_s / kSpeed));
      t_s_ += kStep_s;
      now_ = kBegin + Duration::from_s(t_s_);
      for (const auto& vehicle : vehicles_) vehicle->step({now_, now_}, t_s_);
      std::this_thread::sleep_until(next);
    }
  }

  [[nodiscard]] host::ExactVehicle& vehicle(int v) {
    return *vehicles_[static_cast<std::size_t>(v)];
  }

  [[nodiscard]] const fleet::Node& node(int v) { return vehicle(v).side.agent()->node(); }

  [[nodiscard]] SE3 T_map_start(int v) const {
    return starts_[0].inverse() * starts_[static_cast<std::size_t>(v)];
  }

 private:
  static constexpr Time kBegin = Time::from_ns(1'700'000'000'000'000'000);
  double t_s_ = 0.0;
  Time now_ = kBegin;
  std::vector<std::string> names_ = {"v1", "v2", "v3"};
  std::vector<SE3> starts_ = {{geometry::Mat3::Identity(), Vec3(5.0, 6.0, 0.8)},
                              {geometry::Mat3::Identity(), Vec3(5.0, 4.0, 0.8)},
                              {geometry::Mat3::Identity(), Vec3(5.0, 7.5, 0.8)}};
  std::vector<std::unique_ptr<host::ExactVehicle>> vehicles_;
};

/// Every stored fact must be the one created by its author. @return the number of facts
std::size_t expect_genuine_facts(Fleet& fleet, int holder) {
  std::size_t facts = 0;
  const fleet::FactStore& held = fleet.node(holder).store();
  for (const fleet::StreamInventory& stream : held.streams()) {
    EXPECT_EQ(stream.stream.epoch, 0U) << "no vehicle has started twice";
    const fleet::FactStore& of_author = fleet.node(stream.stream.vehicle.value).store();
    held.for_each(stream.stream, 0, 1'000'000, [&](const fleet::FactPtr& fact) {
      const fleet::FactPtr made = of_author.find(fact->key);
      const bool same = made && fleet::content_hash(*made) == fleet::content_hash(*fact);
      EXPECT_TRUE(same) << "vehicle " << fact->key.vehicle.value << ", fact " << fact->key.seq;
      ++facts;
      return same;
    });
  }
  EXPECT_EQ(held.streams().size(), static_cast<std::size_t>(kVehicles));
  return facts;
}

struct Dropped {
  std::uint64_t forged = 0, repeated = 0, strangers = 0;
};

Dropped dropped_by(host::ExactVehicle& vehicle) {
  Dropped sum;
  for (const net::LinkCounts& counts : vehicle.link->counts()) {
    sum.forged += counts.forged;
    sum.repeated += counts.repeated;
  }
  sum.strangers = vehicle.link->strangers();
  return sum;
}

void expect_unmoved(Fleet& fleet, std::uint64_t term) {
  for (int v = 0; v < kVehicles; ++v) {
    const fleet::Node& node = fleet.node(v);
    EXPECT_EQ(node.mode() == fleet::Mode::kAnchor, v == 0) << v;
    EXPECT_EQ(node.term(), term) << v;
    ASSERT_TRUE(node.T_map_odom()) << v;
    EXPECT_LT((node.T_map_odom()->p - fleet.T_map_start(v).p).norm(), 0.05) << v;
    EXPECT_EQ(fleet.vehicle(v).side.agent()->tally().unreadable, 0U) << v;
    EXPECT_EQ(fleet.vehicle(v).side.agent()->tally().wrong_sender, 0U) << v;
    for (const auto& reported : fleet.vehicle(v).side.findings()) {
      EXPECT_NE(reported.finding.id, "fleet.conflict") << v;
    }
    EXPECT_GT(expect_genuine_facts(fleet, v), 60U) << v << ": they go round as before";
  }
}

void attack_once(std::uint64_t seed) {
  HostilePeer hostile(options_of(0), seed);  // its process starts before this one has threads
  Fleet fleet;
  if (!fleet.open()) GTEST_SKIP() << "no loopback for DDS";
  fleet.run(15.0);
  ASSERT_EQ(fleet.node(0).mode(), fleet::Mode::kAnchor);
  ASSERT_GT(hostile.stolen(), 0U) << "it reads along";
  const std::uint64_t term = fleet.node(0).term();
  const double before_mib = resident_mib();
  for (int v = 0; v < kVehicles; ++v) fleet.vehicle(v).receive_s_max = 0.0;

  hostile.attack(true);
  fleet.run(20.0);
  hostile.attack(false);
  fleet.run(3.0);

  expect_unmoved(fleet, term);
  EXPECT_GT(hostile.sent(), 2000U);
  for (int v = 0; v < kVehicles; ++v) {
    const Dropped dropped = dropped_by(fleet.vehicle(v));
    EXPECT_GT(dropped.forged, 100U) << v;
    EXPECT_GT(dropped.repeated, 20U) << v;
    EXPECT_GT(dropped.strangers, 100U) << v;
    EXPECT_LT(fleet.vehicle(v).receive_s_max, 0.1) << v << ": seconds of work in one step";
  }
  EXPECT_LT(resident_mib() - before_mib, 64.0);
}

TEST(HostilePeer, without_the_key_changes_no_role_map_pose_or_fact) {
  for (int k = 0; k < attacks() && !HasFatalFailure() && !IsSkipped(); ++k) {
    attack_once(static_cast<std::uint64_t>(7 + k));
  }
}

}  // namespace
}  // namespace rali::test
