#include "hostile_peer.hpp"

#include <array>
#include <chrono>
#include <csignal>
#include <deque>
#include <memory>
#include <new>
#include <string>
#include <thread>

#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include "rali/base/rng.hpp"
#include "rali/fleet/messages/messages.hpp"
#include "rali/net/envelope.hpp"
#include "rali/net/internal/dds_config.hpp"
#include "rali/net/internal/dds_for_test.hpp"
#include "rali/wire/fleet/codec.hpp"

namespace rali::test {

namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::array<net::Urgency, 3> kUrgencies = {net::Urgency::kRole, net::Urgency::kStatus,
                                                    net::Urgency::kBulk};
constexpr std::array<const char*, 3> kTopics = {"rt/rali/role", "rt/rali/status", "rt/rali/bulk"};
constexpr std::size_t kVehicles = 3;
constexpr std::size_t kLoot = 300;  ///< stored samples per topic

/// Publishes to all, and to each vehicle alone.
net::QosPtr everywhere(bool is_reliable) {
  net::QosPtr qos = net::qos_for_test(is_reliable);
  std::array<const char*, 4> partitions = {"all", "v0", "v1", "v2"};
  dds_qset_partition(qos.get(), partitions.size(), partitions.data());
  return qos;
}

}  // namespace

/// Main part of the attacking process.
class Attack {
 public:
  Attack(const net::FleetLinkOptions& first, std::uint64_t seed, HostilePeer::Shared& shared)
      : rng_(seed, "hostile peer"), shared_(shared) {
    for (std::size_t k = 0; k < kTopics.size(); ++k) {
      net::FleetLinkOptions options = first;
      options.self = VehicleId{static_cast<std::uint16_t>(9 + k)};
      options.address = "127.0.0." + std::to_string(9 + k);
      options.peers.push_back({first.self, first.address, 0});
      doors_[k] = std::make_unique<net::OutsiderForTest>(net::cyclone_config(options), kTopics[k],
                                                         "rali_msgs::msg::dds_::Sealed_");
      if (!doors_[k]->error().empty()) ::_exit(1);
      const bool is_reliable = kUrgencies[k] == net::Urgency::kBulk;
      doors_[k]->open_reader(everywhere(is_reliable));
      doors_[k]->open_writer(everywhere(is_reliable));
    }
  }

  void run() {
    constexpr int kBurst = 20;
    while (::getppid() != 1) {
      steal();
      for (int k = 0; shared_.on.load() && k < kBurst; ++k) {
        const std::size_t door = rng_.below(doors_.size());
        if (doors_[door]->write(sample(door))) shared_.sent.fetch_add(1);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  }

 private:
  void steal() {
    for (std::size_t k = 0; k < doors_.size(); ++k) {
      for (Bytes& one : doors_[k]->take()) {
        loot_[k].push_back(std::move(one));
        if (loot_[k].size() > kLoot) loot_[k].pop_front();
        shared_.stolen.fetch_add(1);
      }
    }
  }

  Bytes sample(std::size_t door) {
    if (rng_.below(4000) == 0) return net::encode_sealed(Bytes(std::size_t{2} << 20));
    switch (rng_.below(8)) {
      case 0:
        return net::encode_sealed(sealed_with_another_key(door));
      case 1:
        return net::encode_sealed(message());  // not sealed at all
      case 2:
        return stolen(door);
      case 3:
        return stolen(rng_.below(doors_.size()));  // of another topic
      case 4:
        return turned(stolen(door));
      case 5:
        return cut(stolen(door));
      case 6:
        return net::encode_sealed(noise(rng_.below(400)));
      default:
        return noise(rng_.below(60));
    }
  }

  [[nodiscard]] VehicleId someone() { return {static_cast<std::uint16_t>(rng_.below(kVehicles))}; }

  Bytes sealed_with_another_key(std::size_t door) {
    net::FleetKey key;
    key.bytes.fill(0x44);
    net::EnvelopeSealer liar(someone(), static_cast<std::uint32_t>(rng_.below(3)), key);
    const auto to = rng_.below(2) == 0 ? net::kEveryone : someone().value;
    return liar.seal(to, kUrgencies[door], message());
  }

  /// Bytes that a vehicle would accept if they were sealed with the key.
  Bytes message() {
    fleet::Message reported;
    switch (rng_.below(5)) {
      case 0: {
        fleet::RoleMessage role;
        role.op = static_cast<fleet::RoleOp>(rng_.below(8));
        role.term = 2 + rng_.below(1000);
        role.candidate = someone();
        role.lease = Duration::from_s(1000.0);
        reported = role;
        break;
      }
      case 1:
        reported = fleet::VehicleStatus{};
        break;
      case 2:
        reported = fleet::Table{};
        break;
      default: {
        fleet::Fact fact{{someone(), static_cast<std::uint32_t>(rng_.below(2)),
                          static_cast<std::uint32_t>(rng_.below(500))},
                         Time::from_s(1.0),
                         fleet::EpochStart{"liar", {geometry::Vec3::Ones()}},
                         {}};
        reported = fleet::FactMessage{std::make_shared<const fleet::Fact>(std::move(fact))};
      }
    }
    const auto bytes = wire::encode_envelope({someone(), std::nullopt, std::move(reported)});
    if (!bytes) return {};
    const auto* first = reinterpret_cast<const std::uint8_t*>(bytes->data());
    return {first, first + bytes->size()};
  }

  Bytes stolen(std::size_t door) {
    if (loot_[door].empty()) return noise(50);
    return loot_[door][rng_.below(loot_[door].size())];
  }

  Bytes turned(Bytes bytes) {
    if (!bytes.empty()) {
      bytes[rng_.below(bytes.size())] ^= static_cast<std::uint8_t>(1U << rng_.below(8));
    }
    return bytes;
  }

  Bytes cut(Bytes bytes) {
    bytes.resize(rng_.below(bytes.size() + 1));
    return bytes;
  }

  Bytes noise(std::size_t size) {
    Bytes bytes(size);
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(rng_.below(256));
    return bytes;
  }

  Rng rng_;
  HostilePeer::Shared& shared_;
  std::array<std::unique_ptr<net::OutsiderForTest>, 3> doors_;
  std::array<std::deque<Bytes>, 3> loot_;
};

HostilePeer::HostilePeer(const net::FleetLinkOptions& first, std::uint64_t seed) {
  void* memory =
      ::mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  shared_ = new (memory) Shared;
  pid_ = ::fork();
  if (pid_ != 0) return;
  Attack(first, seed, *shared_).run();
  ::_exit(0);
}

HostilePeer::~HostilePeer() {
  ::kill(pid_, SIGKILL);
  ::waitpid(pid_, nullptr, 0);
  ::munmap(shared_, sizeof(Shared));
}

}  // namespace rali::test
