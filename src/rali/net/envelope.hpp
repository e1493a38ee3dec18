#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <tuple>
#include <vector>

#include "rali/base/ids.hpp"
#include "rali/net/fleet_key.hpp"
#include "rali/net/fleet_link.hpp"
#include "rali/net/seen_counters.hpp"

/// The sealed form of every message between vehicles. Without the fleet's key nobody can forge or
/// replay one.
///
///   0   'R', version (1), urgency, 0
///   4   from, to: uint16 (to: kEveryone for all)
///   8   epoch: uint32, counter: uint64
///   20  four zeros
///   24  XChaCha20 of the message, then the 16 bytes of Poly1305
///
/// All little endian. The first 24 bytes are the nonce, so they are authenticated too: a message
/// cannot be redirected to another vehicle, nor a status be passed off as a role. No nonce is used
/// twice, because the counter of each (to, urgency) only grows and a new start has a new epoch.
namespace rali::net {

inline constexpr std::size_t kEnvelopeHeaderBytes = 24;
inline constexpr std::size_t kEnvelopeBytes = kEnvelopeHeaderBytes + 16;
inline constexpr std::size_t kSampleHeaderBytes = 8;  ///< encapsulation, length
inline constexpr std::uint16_t kEveryone = 0xFFFF;

/// Initialises libsodium; must return true before any function below is used.
[[nodiscard]] bool sodium_is_ready();

/// Seals the messages of one vehicle.
class EnvelopeSealer {
 public:
  EnvelopeSealer(VehicleId self, std::uint32_t epoch, const FleetKey& key)
      : self_(self), epoch_(epoch), key_(key) {}

  /// @param to a vehicle's number or kEveryone
  [[nodiscard]] std::vector<std::uint8_t> seal(std::uint16_t to, Urgency urgency,
                                               std::span<const std::uint8_t> message);

 private:
  VehicleId self_;
  std::uint32_t epoch_;
  FleetKey key_;
  std::map<std::pair<std::uint16_t, Urgency>, std::uint64_t> counters_;
};

/// Counters received from one sender: the newest and the 1023 before it, because best-effort
/// samples may overtake each other. Older ones count as received.
class ReplayWindow {
 public:
  explicit ReplayWindow(std::uint32_t epoch_min = 0) : epoch_(epoch_min) {}

  /// True for a new counter, which is then recorded.
  [[nodiscard]] bool admit(std::uint32_t epoch, std::uint64_t counter);

  /// Marks all counters up to this one as received by an earlier start. Newer state is kept.
  void recall(std::uint32_t epoch, std::uint64_t counter);

  [[nodiscard]] std::uint32_t epoch() const { return epoch_; }

  /// 0: none.
  [[nodiscard]] std::uint64_t newest() const { return newest_; }

 private:
  static constexpr std::size_t kSize = 1024;
  std::uint32_t epoch_;
  std::uint64_t newest_ = 0;
  std::bitset<kSize> seen_;  ///< counter mod kSize
};

enum class EnvelopeVerdict {
  kGenuine,
  kStranger,  ///< too short, another version, or not of a vehicle of the list
  kForged,    ///< claims to come from a vehicle of the list
  kRepeated   ///< genuine, but received before, or of an older start of its sender
};

struct OpenedEnvelope {
  EnvelopeVerdict verdict = EnvelopeVerdict::kStranger;
  VehicleId from;                     ///< only claimed if forged; not set for strangers
  std::vector<std::uint8_t> message;  ///< if genuine
};

/// A vehicle whose messages are opened, with the lowest accepted epoch.
struct KnownSender {
  VehicleId id;
  std::uint32_t epoch_min = 0;
};

/// Opens messages received by one vehicle. Memory does not grow with traffic.
class EnvelopeOpener {
 public:
  EnvelopeOpener(VehicleId self, const FleetKey& key, const std::vector<KnownSender>& senders);

  /// @param urgency of the topic on which it arrived
  [[nodiscard]] OpenedEnvelope open(Urgency urgency, std::span<const std::uint8_t> sealed);

  /// Restores what an earlier start of this vehicle has accepted.
  void recall(std::span<const SeenCounter> seen);

  /// The newest roles and statuses accepted. Facts need none: repeating them has no effect.
  [[nodiscard]] std::vector<SeenCounter> seen() const;

 private:
  using Channel = std::tuple<VehicleId, bool, Urgency>;  ///< from, to everyone, urgency

  VehicleId self_;
  FleetKey key_;
  std::map<Channel, ReplayWindow> windows_;  ///< created at the start; never extended
};

/// The DDS sample with an envelope: `struct Sealed_ { sequence<octet> body_; }` in CDR.
[[nodiscard]] std::vector<std::uint8_t> encode_sealed(std::span<const std::uint8_t> envelope);

/// The envelope in a sample; empty if the sample is malformed.
[[nodiscard]] std::span<const std::uint8_t> decode_sealed(std::span<const std::uint8_t> cdr);

}  // namespace rali::net
