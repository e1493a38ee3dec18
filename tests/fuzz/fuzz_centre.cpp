// Well-formed facts of two vehicles with any content, into the fleet's joint estimate: no crash, no
// hang, no NaN in it. Input: a sequence of (2 bytes length, message).
#include <cstddef>
#include <cstdint>
#include <span>
#include <variant>

#include "message_bytes.hpp"
#include "rali/base/assert.hpp"
#include "rali/fleet/centre/centre.hpp"
#include "rali/fleet/facts/fact_store.hpp"
#include "rali/wire/fleet/codec.hpp"

namespace {

using namespace rali;

constexpr std::size_t kFactsMax = 200;

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::span<const std::byte> rest = std::as_bytes(std::span(data, size));
  fleet::FactStore store(VehicleId{1}, {VehicleId{1}, VehicleId{3}});
  for (std::size_t k = 0; k < kFactsMax && rest.size() >= 2; ++k) {
    const std::size_t length = fuzz::take_number(rest);
    const auto envelope =
        wire::decode_envelope(fuzz::with_checksum(fuzz::take_bytes(rest, length)));
    if (!envelope) continue;
    if (const auto* fact = std::get_if<fleet::FactMessage>(&envelope->message)) {
      static_cast<void>(store.add(fact->fact));
    }
  }
  fleet::FleetKnowledge known;
  known.starts.push_back({VehicleId{1}, VehicleId{3}, {}, 0.2, 0.05});
  fleet::Centre centre(fleet::FleetSettings{}, known);
  for (const fleet::FactPtr& fact : store.take_new()) centre.add(fact);
  SerialExecutor executor;
  const fleet::FleetEstimate estimate = centre.estimate(executor);
  for (const fleet::VehicleFrame& frame : estimate.frames) {
    RALI_ASSERT(frame.T_map_odom.p.allFinite() && frame.T_map_odom.R.allFinite());
  }
  for (const auto& [id, pose] : estimate.keyframes) {
    RALI_ASSERT(pose.T_map_body.p.allFinite() && pose.T_map_body.R.allFinite());
  }
  return 0;
}
