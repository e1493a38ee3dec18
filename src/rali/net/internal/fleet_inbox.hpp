#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <span>
#include <vector>

#include "rali/net/envelope.hpp"
#include "rali/net/fleet_link.hpp"

namespace rali::net {

/// Opens messages on the thread on which they arrive, so that no message without the fleet's key
/// ever enters a queue. Each vehicle has its own queues: one that floods loses only its own
/// messages.
class FleetInbox {
 public:
  FleetInbox(EnvelopeOpener opener, const std::vector<VehicleId>& peers,
             std::size_t queue_bytes_max);

  /// Called by DDS threads. @param cdr a sample: sequence<octet> with the envelope
  void put(Urgency urgency, Time t, std::span<const std::uint8_t> cdr) noexcept;

  [[nodiscard]] std::vector<Arrived> take();
  bool wait(Duration timeout);

  /// Fills in the counts of messages from `row.peer`.
  void add_counts(LinkCounts& row) const;
  [[nodiscard]] std::uint64_t strangers() const;
  [[nodiscard]] std::vector<SeenCounter> seen() const;

 private:
  struct Waiting {
    std::uint64_t order = 0;
    Arrived arrived;
  };

  struct Peer {
    LinkCounts counts;
    std::deque<Waiting> bulk, others;
    std::size_t bulk_bytes = 0;
  };

  void sort_in(Urgency urgency, Time t, std::span<const std::uint8_t> cdr);
  void keep(Peer& peer, Urgency urgency, Arrived arrived);

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  EnvelopeOpener opener_;
  std::map<VehicleId, Peer> peers_;
  std::size_t queue_bytes_max_;
  std::uint64_t order_ = 0, strangers_ = 0;
  std::size_t waiting_ = 0;
};

}  // namespace rali::net
