#pragma once

#include <span>

#include "rali/base/result.hpp"
#include "rali/factlog/record.hpp"
#include "rali/fleet/facts/fact_store.hpp"

namespace rali::drive {

/// The key of a fact in a log.
[[nodiscard]] factlog::RecordKey record_key(const fleet::FactKey& key);

/// The fact of a record. Errors: kInput for bytes that are no fact, or one with another key.
[[nodiscard]] Result<fleet::FactPtr> decode_record(const factlog::RecordKey& key,
                                                   std::span<const std::byte> bytes);

}  // namespace rali::drive
