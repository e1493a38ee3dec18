#include "rali/drive/state/role_record.hpp"

#include <algorithm>

#include "rali/wire/fleet/pack.hpp"

namespace rali::drive {

namespace {

constexpr std::uint8_t kVersion = 1;
/// As many as fit a slot with space to spare.
constexpr std::size_t kFleetMax = 1024;

/// The order of fields, shared by writing and reading.
template <class Archive, class Record>
void layout(Archive& a, Record& r) {
  a.number(r.self.value);
  a.number(r.epoch);
  a.number(r.durable.term);
  a.flag(r.durable.confirmed);
  const auto id = [](auto& b, auto& vehicle) { b.number(vehicle.value); };
  a.maybe(r.durable.granted_to, id);
  a.maybe(r.durable.anchor, id);
  a.list(r.durable.fleet, kFleetMax, id);
}

}  // namespace

wire::Bytes encode_role(const RoleRecord& record) {
  wire::PackWriter out;
  out.number(kVersion);
  layout(out, record);
  return out.take();
}

Result<RoleRecord> decode_role(std::span<const std::byte> bytes) {
  wire::PackReader in(bytes);
  std::uint8_t version = 0;
  in.number(version);
  if (in.ok() && version != kVersion) {
    return fail(ErrorCode::kNoAnswer, "role slot", "was written by a newer program",
                "Run that program, or give this one a folder of its own.");
  }
  RoleRecord record;
  layout(in, record);
  const auto& ids = record.durable.fleet;
  if (!in.ok() || in.remaining() != 0 || !std::is_sorted(ids.begin(), ids.end())) {
    return fail(ErrorCode::kInput, "role slot", "holds no role");
  }
  return record;
}

}  // namespace rali::drive
