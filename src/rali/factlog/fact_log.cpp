#include "rali/factlog/fact_log.hpp"

#include <fmt/format.h>

#include "rali/base/crc32c.hpp"

namespace rali::factlog {

namespace {

std::string text_of(const RecordKey& key) {
  return fmt::format("vehicle {}, epoch {}, number {}", key.vehicle.value, key.epoch, key.seq);
}

std::pair<std::uint32_t, std::uint64_t> rank(const RecordPlace& place) {
  return {place.segment, place.offset};
}

}  // namespace

Result<Appended> FactLog::append(const RecordKey& key, std::uint8_t kind,
                                 std::span<const std::byte> body) {
  if (body.size() > kBodyMax) {
    return fail(ErrorCode::kInput, text_of(key),
                fmt::format("has {} bytes; {} may be logged", body.size(), kBodyMax));
  }
  const RecordHead head{key, kind, static_cast<std::uint32_t>(body.size()), crc32c(body)};
  if (const auto known = index_.find(key); known != index_.end()) {
    const RecordHead& there = known->second.head;
    const bool same = there.kind == kind && there.body_bytes == head.body_bytes &&
                      there.body_crc == head.body_crc;
    if (same) return Appended::kKnown;
    report_conflict(key);
    return Appended::kConflict;
  }
  const auto place = write(key, kind, body);
  if (!place) return tl::make_unexpected(place.error());
  if (!*place) return Appended::kFull;
  index({head, **place});
  return Appended::kWritten;
}

Result<Bytes> FactLog::read(const RecordKey& key) const {
  const auto found = index_.find(key);
  if (found == index_.end()) {
    return fail(ErrorCode::kNoAnswer, text_of(key), "is not in the log");
  }
  Result<Bytes> body = body_of(found->second);
  if (body && crc32c(*body) != found->second.head.body_crc) {
    return fail(ErrorCode::kInput, text_of(key), "was damaged on the disk (checksum)",
                "Other vehicles may still have it.");
  }
  return body;
}

void FactLog::for_each(const Visit& visit) {
  for (const auto& [place, key] : by_place_) {
    const Result<Bytes> body = read(key);
    if (body) {
      if (!visit(key, index_.at(key).head.kind, *body)) return;
      continue;
    }
    Finding finding;
    finding.id = "log.damaged";
    finding.severity = Severity::kWarning;
    finding.text = body.error().message();
    finding.effect = "the fact is left out";
    report(std::move(finding));
  }
}

bool FactLog::index(const Entry& entry) {
  const auto [known, added] = index_.emplace(entry.head.key, entry);
  if (added) {
    by_place_.emplace(rank(entry.place), entry.head.key);
    return true;
  }
  if (known->second.head.body_crc != entry.head.body_crc) report_conflict(entry.head.key);
  return false;
}

void FactLog::forget_from(const RecordPlace& place) {
  const auto first = by_place_.lower_bound(rank(place));
  for (auto it = first; it != by_place_.end(); ++it) index_.erase(it->second);
  by_place_.erase(first, by_place_.end());
}

/// Once per stream: a cloned disk causes as many conflicts as facts.
void FactLog::report_conflict(const RecordKey& key) {
  if (!conflicts_.emplace(key.vehicle, key.epoch).second) return;
  Finding finding;
  finding.id = "log.conflict";
  finding.severity = Severity::kError;
  finding.text = "two different facts have one name: " + text_of(key);
  finding.effect = "the first one is kept";
  finding.remedy =
      "Look for two vehicles with one number, a cloned disk, or an epoch that was not raised.";
  report(std::move(finding));
}

}  // namespace rali::factlog
