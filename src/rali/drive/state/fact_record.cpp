#include "rali/drive/state/fact_record.hpp"

#include <variant>

#include "rali/wire/fleet/codec.hpp"

namespace rali::drive {

factlog::RecordKey record_key(const fleet::FactKey& key) {
  return {key.vehicle, key.epoch, key.seq};
}

Result<fleet::FactPtr> decode_record(const factlog::RecordKey& key,
                                     std::span<const std::byte> bytes) {
  const auto envelope = wire::decode_envelope(bytes);
  if (!envelope) return tl::make_unexpected(envelope.error());
  const auto* message = std::get_if<fleet::FactMessage>(&envelope->message);
  if (message == nullptr) return fail(ErrorCode::kInput, "log", "a record is not a fact");
  if (record_key(message->fact->key) != key) {
    return fail(ErrorCode::kInput, "log", "it has another name than its record");
  }
  return message->fact;
}

}  // namespace rali::drive
