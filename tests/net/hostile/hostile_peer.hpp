#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include <sys/types.h>

#include "rali/net/dds_fleet_link.hpp"

namespace rali::test {

/// An attacker in the network of a fleet without its key, in its own process. It reads all messages
/// of the vehicles. On every topic it sends forged roles and facts, statuses and tables, recorded
/// samples (unchanged, truncated, altered, on other topics), false lengths, and noise.
class HostilePeer {
 public:
  /// Create it before this process opens any link of its own.
  /// @param vehicles of the fleet, numbered from 0, as in the first one's options
  HostilePeer(const net::FleetLinkOptions& first, std::uint64_t seed);
  ~HostilePeer();
  HostilePeer(const HostilePeer&) = delete;
  HostilePeer& operator=(const HostilePeer&) = delete;

  void attack(bool on) { shared_->on.store(on); }

  /// Number of samples written so far.
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
