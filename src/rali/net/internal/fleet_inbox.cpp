#include "rali/net/internal/fleet_inbox.hpp"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <new>
#include <utility>

namespace rali::net {
namespace {

constexpr std::size_t kOthersMax = 64;  ///< per vehicle; they are repeated, so the newest are kept
constexpr std::size_t kBulkMax = 4096;  ///< per vehicle, whatever their size

}  // namespace

FleetInbox::FleetInbox(EnvelopeOpener opener, const std::vector<VehicleId>& peers,
                       std::size_t queue_bytes_max)
    : opener_(std::move(opener)), queue_bytes_max_(queue_bytes_max) {
  for (const VehicleId peer : peers) peers_[peer];
}

void FleetInbox::put(Urgency urgency, Time t, std::span<const std::uint8_t> cdr) noexcept {
  const std::lock_guard lock(mutex_);
  try {
    sort_in(urgency, t, cdr);
  } catch (const std::bad_alloc&) {
    ++strangers_;  // not opened: its sender is unknown
  }
}

void FleetInbox::sort_in(Urgency urgency, Time t, std::span<const std::uint8_t> cdr) {
  OpenedEnvelope opened = opener_.open(urgency, decode_sealed(cdr));
  const auto peer = peers_.find(opened.from);
  if (opened.verdict == EnvelopeVerdict::kStranger || peer == peers_.end()) {
    ++strangers_;
    return;
  }
  LinkCounts& counts = peer->second.counts;
  if (opened.verdict == EnvelopeVerdict::kForged) {
    ++counts.forged;
  } else if (opened.verdict == EnvelopeVerdict::kRepeated) {
    ++counts.repeated;
  } else {
    ++counts.arrived;
    counts.arrived_bytes += opened.message.size();
    keep(peer->second, urgency, {t, opened.from, std::move(opened.message)});
  }
}

void FleetInbox::keep(Peer& peer, Urgency urgency, Arrived arrived) {
  if (urgency == Urgency::kBulk) {
    if (peer.bulk.size() >= kBulkMax || peer.bulk_bytes + arrived.bytes.size() > queue_bytes_max_) {
      ++peer.counts.overflowed;  // its receiver requests it again
      return;
    }
    peer.bulk_bytes += arrived.bytes.size();
    peer.bulk.push_back({order_++, std::move(arrived)});
    ++waiting_;
  } else {
    peer.others.push_back({order_++, std::move(arrived)});
    ++waiting_;
    if (peer.others.size() > kOthersMax) {
      peer.others.pop_front();
      ++peer.counts.overflowed;
      --waiting_;
    }
  }
  changed_.notify_one();
}

std::vector<Arrived> FleetInbox::take() {
  std::vector<Waiting> taken;
  {
    const std::lock_guard lock(mutex_);
    taken.reserve(waiting_);
    for (auto& [id, peer] : peers_) {
      std::move(peer.others.begin(), peer.others.end(), std::back_inserter(taken));
      std::move(peer.bulk.begin(), peer.bulk.end(), std::back_inserter(taken));
      peer.others.clear();
      peer.bulk.clear();
      peer.bulk_bytes = 0;
    }
    waiting_ = 0;
  }
  std::sort(taken.begin(), taken.end(),
            [](const Waiting& a, const Waiting& b) { return a.order < b.order; });
  std::vector<Arrived> out;
  out.reserve(taken.size());
  for (Waiting& waiting : taken) out.push_back(std::move(waiting.arrived));
  return out;
}

bool FleetInbox::wait(Duration timeout) {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, std::chrono::nanoseconds(timeout.ns),
                           [&] { return waiting_ > 0; });
}

void FleetInbox::add_counts(LinkCounts& row) const {
  const std::lock_guard lock(mutex_);
  const auto peer = peers_.find(row.peer);
  if (peer == peers_.end()) return;
  const LinkCounts& counts = peer->second.counts;
  row.arrived = counts.arrived;
  row.arrived_bytes = counts.arrived_bytes;
  row.forged = counts.forged;
  row.repeated = counts.repeated;
  row.overflowed = counts.overflowed;
}

std::vector<SeenCounter> FleetInbox::seen() const {
  const std::lock_guard lock(mutex_);
  return opener_.seen();
}

std::uint64_t FleetInbox::strangers() const {
  const std::lock_guard lock(mutex_);
  return strangers_;
}

}  // namespace rali::net
