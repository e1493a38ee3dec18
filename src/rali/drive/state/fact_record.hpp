#pragma once

#include <span>

#include "rali/base/result.hpp"
#include "rali/factlog/record.hpp"
#include "rali/fleet/facts/fact_store.hpp"

namespace rali::drive {

/// The name under which a log keeps a fact.
[[nodiscard]] factlog::RecordKey record_key(const fleet::FactKey& key);

/// The fact of a record. Errors: kInput for bytes that are no fact, or one of another name.
[[nodiscard]] Result<fleet::FactPtr> decode_record(const factlog::RecordKey& key,
                                                   std::span<const std::byte> bytes);

}  // namespace rali::drive
