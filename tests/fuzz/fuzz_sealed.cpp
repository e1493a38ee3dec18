// Any bytes as a sample of the fleet's DDS domain: without the key none is opened. Any bytes sealed
// with the key: they are opened unchanged, once, and their content is decoded.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

#include "message_bytes.hpp"
#include "rali/net/envelope.hpp"
#include "rali/wire/fleet/codec.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace rali;
  using net::EnvelopeVerdict;
  using net::Urgency;
  constexpr VehicleId kSender{1}, kReceiver{2};
  static const bool kReady = net::sodium_is_ready();
  if (!kReady) std::abort();
  net::FleetKey key;
  key.bytes.fill(0x5A);
  net::EnvelopeOpener opener(kReceiver, key, {{kSender, 0}});
  const std::span<const std::uint8_t> input(data, size);

  const auto strange = opener.open(Urgency::kBulk, net::decode_sealed(input));
  if (strange.verdict == EnvelopeVerdict::kGenuine || !strange.message.empty()) std::abort();
  if (opener.open(Urgency::kRole, input).verdict == EnvelopeVerdict::kGenuine) std::abort();

  net::EnvelopeSealer sealer(kSender, 1, key);
  const auto sample = net::encode_sealed(sealer.seal(kReceiver.value, Urgency::kBulk, input));
  const auto opened = opener.open(Urgency::kBulk, net::decode_sealed(sample));
  const std::vector<std::uint8_t> expected(input.begin(), input.end());
  if (opened.verdict != EnvelopeVerdict::kGenuine || opened.message != expected) std::abort();
  const auto again = opener.open(Urgency::kBulk, net::decode_sealed(sample));
  if (again.verdict != EnvelopeVerdict::kRepeated) std::abort();
  const auto message = fuzz::with_checksum(std::as_bytes(std::span(opened.message)));
  static_cast<void>(wire::decode_envelope(message));
  return 0;
}
