#include "rali/net/envelope.hpp"

#include <algorithm>

#include <sodium.h>

namespace rali::net {
namespace {

constexpr std::uint8_t kMagic = 'R';
constexpr std::uint8_t kVersion = 1;
/// Messages to all are sent once a second: this many may have been received but not saved. A
/// restart takes longer than sending them. Messages to one vehicle are rare, and each is saved.
constexpr std::uint64_t kUnsaved = 3;

static_assert(kEnvelopeHeaderBytes == crypto_aead_xchacha20poly1305_ietf_NPUBBYTES);
static_assert(kEnvelopeBytes - kEnvelopeHeaderBytes == crypto_aead_xchacha20poly1305_ietf_ABYTES);
static_assert(sizeof(FleetKey::bytes) == crypto_aead_xchacha20poly1305_ietf_KEYBYTES);

struct Header {
  Urgency urgency = Urgency::kRole;
  std::uint16_t from = 0, to = 0;
  std::uint32_t epoch = 0;
  std::uint64_t counter = 0;
};

template <class T>
void put(std::uint8_t* at, T value) {
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    at[i] = static_cast<std::uint8_t>((static_cast<std::uint64_t>(value) >> (8 * i)) & 0xFFU);
  }
}

template <class T>
T get(const std::uint8_t* at) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) value |= std::uint64_t{at[i]} << (8 * i);
  return static_cast<T>(value);
}

void write_header(const Header& header, std::uint8_t* at) {
  std::fill_n(at, kEnvelopeHeaderBytes, std::uint8_t{0});
  at[0] = kMagic;
  at[1] = kVersion;
  at[2] = static_cast<std::uint8_t>(header.urgency);
  put(at + 4, header.from);
  put(at + 6, header.to);
  put(at + 8, header.epoch);
  put(at + 12, header.counter);
}

Header read_header(const std::uint8_t* at) {
  return {static_cast<Urgency>(at[2]), get<std::uint16_t>(at + 4), get<std::uint16_t>(at + 6),
          get<std::uint32_t>(at + 8), get<std::uint64_t>(at + 12)};
}

}  // namespace

bool sodium_is_ready() { return sodium_init() >= 0; }

std::vector<std::uint8_t> EnvelopeSealer::seal(std::uint16_t to, Urgency urgency,
                                               std::span<const std::uint8_t> message) {
  std::vector<std::uint8_t> sealed(kEnvelopeBytes + message.size());
  write_header({urgency, self_.value, to, epoch_, ++counters_[{to, urgency}]}, sealed.data());
  crypto_aead_xchacha20poly1305_ietf_encrypt(sealed.data() + kEnvelopeHeaderBytes, nullptr,
                                             message.data(), message.size(), nullptr, 0, nullptr,
                                             sealed.data(), key_.bytes.data());
  return sealed;
}

bool ReplayWindow::admit(std::uint32_t epoch, std::uint64_t counter) {
  if (epoch < epoch_ || counter == 0) return false;
  if (epoch > epoch_) {
    epoch_ = epoch;
    newest_ = 0;
    seen_.reset();
  }
  if (counter > newest_) {
    const std::uint64_t steps = std::min<std::uint64_t>(counter - newest_, kSize);
    for (std::uint64_t i = 0; i < steps; ++i) seen_.reset((counter - i) % kSize);
    newest_ = counter;
  } else if (newest_ - counter >= kSize || seen_.test(counter % kSize)) {
    return false;
  }
  seen_.set(counter % kSize);
  return true;
}

void ReplayWindow::recall(std::uint32_t epoch, std::uint64_t counter) {
  const bool newer = epoch > epoch_ || (epoch == epoch_ && counter > newest_);
  if (!newer) return;
  epoch_ = epoch;
  newest_ = counter;
  seen_.set();  // which of them had arrived is unknown: all are rejected
}

EnvelopeOpener::EnvelopeOpener(VehicleId self, const FleetKey& key,
                               const std::vector<KnownSender>& senders)
    : self_(self), key_(key) {
  for (const KnownSender& sender : senders) {
    for (const bool to_all : {false, true}) {
      for (const Urgency urgency : {Urgency::kRole, Urgency::kStatus, Urgency::kBulk}) {
        windows_.emplace(Channel{sender.id, to_all, urgency}, ReplayWindow(sender.epoch_min));
      }
    }
  }
}

OpenedEnvelope EnvelopeOpener::open(Urgency urgency, std::span<const std::uint8_t> sealed) {
  OpenedEnvelope out;
  if (sealed.size() < kEnvelopeBytes || sealed[0] != kMagic || sealed[1] != kVersion) return out;
  const Header header = read_header(sealed.data());
  const bool to_all = header.to == kEveryone;
  const auto window = windows_.find({VehicleId{header.from}, to_all, urgency});
  if (window == windows_.end()) return out;
  out.from = VehicleId{header.from};
  out.verdict = EnvelopeVerdict::kForged;
  if (header.urgency != urgency || (!to_all && header.to != self_.value)) return out;
  const auto body = sealed.subspan(kEnvelopeHeaderBytes);
  std::vector<std::uint8_t> message(sealed.size() - kEnvelopeBytes);
  if (crypto_aead_xchacha20poly1305_ietf_decrypt(message.data(), nullptr, nullptr, body.data(),
                                                 body.size(), nullptr, 0, sealed.data(),
                                                 key_.bytes.data()) != 0) {
    return out;
  }
  out.verdict = EnvelopeVerdict::kRepeated;
  if (!window->second.admit(header.epoch, header.counter)) return out;
  out.verdict = EnvelopeVerdict::kGenuine;
  out.message = std::move(message);
  return out;
}

void EnvelopeOpener::recall(std::span<const SeenCounter> seen) {
  for (const SeenCounter& one : seen) {
    const auto window = windows_.find({one.from, one.to_all, one.urgency});
    if (window == windows_.end()) continue;
    window->second.recall(one.epoch, one.counter + (one.to_all ? kUnsaved : 0));
  }
}

std::vector<SeenCounter> EnvelopeOpener::seen() const {
  std::vector<SeenCounter> out;
  for (const auto& [channel, window] : windows_) {
    const auto& [from, to_all, urgency] = channel;
    if (urgency == Urgency::kBulk || window.newest() == 0) continue;
    out.push_back({from, to_all, urgency, window.epoch(), window.newest()});
  }
  return out;
}

std::vector<std::uint8_t> encode_sealed(std::span<const std::uint8_t> envelope) {
  std::vector<std::uint8_t> out(kSampleHeaderBytes + envelope.size());
  out[1] = 1;  // CDR, little endian
  for (std::size_t i = 0; i < 4; ++i) {
    out[4 + i] = static_cast<std::uint8_t>((envelope.size() >> (8 * i)) & 0xFFU);
  }
  std::copy(envelope.begin(), envelope.end(), out.begin() + kSampleHeaderBytes);
  return out;
}

std::span<const std::uint8_t> decode_sealed(std::span<const std::uint8_t> cdr) {
  constexpr std::array<std::uint8_t, 2> kLittleEndian{0, 1};
  if (cdr.size() < kSampleHeaderBytes ||
      !std::equal(kLittleEndian.begin(), kLittleEndian.end(), cdr.begin())) {
    return {};
  }
  std::size_t size = 0;
  for (std::size_t i = 0; i < 4; ++i) size |= std::size_t{cdr[4 + i]} << (8 * i);
  const auto body = cdr.subspan(kSampleHeaderBytes);
  return size <= body.size() ? body.first(size) : std::span<const std::uint8_t>{};
}

}  // namespace rali::net
