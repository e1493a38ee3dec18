#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include <sys/types.h>

#include "rali/net/dds_fleet_link.hpp"

namespace rali::test {

/// Somebody in the network of a fleet who lacks its key, in a process of its own: reads all that
/// the vehicles send, and sends them, on every topic, forged roles and facts, statuses and tables,
/// what it has stolen (as it was, cut, turned, on other topics), lengths that lie, and noise.
class HostilePeer {
 public:
  /// To be made before this process opens any link of its own.
  /// @param vehicles of the fleet, numbered from 0, as the first one's options have them
  HostilePeer(const net::FleetLinkOptions& first, std::uint64_t seed);
  ~HostilePeer();
  HostilePeer(const HostilePeer&) = delete;
  HostilePeer& operator=(const HostilePeer&) = delete;

  void attack(bool on) { shared_->on.store(on); }

  /// Samples that it has written so far.
  [[nodiscard]] std::uint64_t sent() const { return shared_->sent.load(); }

  [[nodiscard]] std::uint64_t stolen() const { return shared_->stolen.load(); }

 private:
  struct Shared {
    std::atomic<bool> on{false};
    std::atomic<std::uint64_t> sent{0}, stolen{0};
  };

  friend class Attack;

  Shared* shared_ = nullptr;
  pid_t pid_ = -1;
};

}  // namespace rali::test
