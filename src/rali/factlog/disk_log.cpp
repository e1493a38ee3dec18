#include "rali/factlog/disk_log.hpp"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <set>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "rali/base/assert.hpp"
#include "rali/base/finding_of.hpp"
#include "rali/factlog/scan.hpp"

namespace rali::factlog {

namespace {

namespace fs = std::filesystem;

/// The number in `facts-000012.log`.
std::optional<std::uint32_t> number_of(const std::string& name) {
  constexpr std::string_view kBegin = "facts-", kEnd = ".log";
  if (name.size() <= kBegin.size() + kEnd.size()) return std::nullopt;
  if (!name.starts_with(kBegin) || !name.ends_with(kEnd)) return std::nullopt;
  const char* first = name.data() + kBegin.size();
  const char* last = name.data() + name.size() - kEnd.size();
  std::uint32_t number = 0;
  const auto [end, error] = std::from_chars(first, last, number);
  if (error != std::errc{} || end != last) return std::nullopt;
  return number;
}

Result<std::set<std::uint32_t>> numbers_in(const std::string& folder) {
  std::set<std::uint32_t> numbers;
  std::error_code error;
  fs::directory_iterator it(folder, error);
  for (; !error && it != fs::directory_iterator{}; it.increment(error)) {
    if (const auto number = number_of(it->path().filename().string())) numbers.insert(*number);
  }
  if (error) {
    return fail(ErrorCode::kMachine, folder, "could not be listed: " + error.message(),
                "Check the folder's permissions and its disk.");
  }
  return numbers;
}

}  // namespace

Result<std::unique_ptr<DiskLog>> DiskLog::open(const std::string& folder,
                                               const DiskLogSettings& settings) {
  auto opened = File::open(folder, File::Mode::kFolder);
  if (!opened) return tl::make_unexpected(opened.error());
  const Result<bool> locked = opened->lock();
  if (!locked) return tl::make_unexpected(locked.error());
  if (!*locked) {
    return fail(ErrorCode::kUsage, folder, "is in use by another process",
                "Stop that one, or give this one a folder of its own.");
  }
  std::unique_ptr<DiskLog> log(new DiskLog(std::move(*opened), settings, Use::kKeep));
  if (const Status read = log->read_segments(); !read) return tl::make_unexpected(read.error());
  // A killed program may leave directory entries only in the page cache: this syncs them.
  if (const Status synced = log->folder_.sync(); !synced) {
    return tl::make_unexpected(synced.error());
  }
  return log;
}

Result<std::unique_ptr<FactLog>> DiskLog::open_to_read(const std::string& folder) {
  auto opened = File::open(folder, File::Mode::kFolder);
  if (!opened) return tl::make_unexpected(opened.error());
  std::unique_ptr<DiskLog> log(new DiskLog(std::move(*opened), {}, Use::kRead));
  if (const Status read = log->read_segments(); !read) return tl::make_unexpected(read.error());
  return log;
}

Finding DiskLog::damaged(const std::string& path, std::uint64_t bytes, std::uint64_t offset) const {
  return finding_of("log.damaged", Severity::kWarning,
                    fmt::format("{}: {} bytes from offset {} on are damaged", path, bytes, offset),
                    use_ == Use::kRead
                        ? "the facts in them are missing"
                        : "the facts in them are missing here and requested from other vehicles");
}

std::string DiskLog::path_of(std::uint32_t number) const {
  return fmt::format("{}/facts-{:06}.log", folder_.path(), number);
}

Status DiskLog::read_segments() {
  const auto numbers = numbers_in(folder_.path());
  if (!numbers) return tl::make_unexpected(numbers.error());
  std::uint32_t expected = 0;
  for (const std::uint32_t number : *numbers) {
    if (number != expected) {
      report(finding_of("log.missing", Severity::kWarning,
                        fmt::format("{} is missing", path_of(expected)),
                        use_ == Use::kRead ? "the facts in it are missing"
                                           : "the facts in it are requested from other vehicles"));
    }
    expected = number + 1;
    if (auto status = read_segment(number, number == *numbers->rbegin()); !status) return status;
  }
  return {};
}

Status DiskLog::read_segment(std::uint32_t number, bool last) {
  const bool keep = use_ == Use::kKeep;
  auto file = File::open(path_of(number), keep ? File::Mode::kExisting : File::Mode::kRead);
  if (!file) return tl::make_unexpected(file.error());
  const auto size = file->size();
  if (!size) return tl::make_unexpected(size.error());
  const auto bytes = file->read(0, static_cast<std::size_t>(*size));
  if (!bytes) return tl::make_unexpected(bytes.error());
  const SegmentScan scan = scan_segment(*bytes, number);
  if (scan.head == SegmentHead::kOtherVersion) {
    return fail(ErrorCode::kInput, file->path(), "was written by a newer program",
                "Run that program, or give this one a folder of its own.");
  }
  const std::string path = file->path();
  Segment segment{std::move(*file), scan.whole_end, scan.whole_end, !last};
  if (scan.head == SegmentHead::kDamaged && scan.whole_end > 0) {
    report(damaged(path, kSegmentHeadBytes, 0));
    segment.closed = true;
  }
  for (const SegmentScan::Damage& d : scan.damages) report(damaged(path, d.bytes, d.offset));
  for (const SegmentScan::Record& r : scan.records) index({r.head, {number, r.offset}});
  const std::uint64_t rest = bytes->size() - std::min<std::uint64_t>(bytes->size(), scan.whole_end);
  if (rest > 0 && last) {
    if (auto status = end_at(segment, rest); !status) return status;
  } else if (rest > 0) {
    report(damaged(path, rest, scan.whole_end));
  }
  // The file was created, but its head is incomplete.
  if (scan.whole_end == 0) segment.closed = true;
  // A killed program may leave records only in the page cache: this syncs them.
  if (keep) {
    if (auto status = segment.file.sync(); !status) return status;
  }
  segments_.emplace(number, std::move(segment));
  return {};
}

/// The log ends within a record: bytes after the last whole one are invalid.
Status DiskLog::end_at(Segment& segment, std::uint64_t rest) {
  const bool keep = use_ == Use::kKeep;
  report(finding_of("log.torn", Severity::kInfo,
                    fmt::format("{}: the last {} bytes are no whole record and were {}",
                                segment.file.path(), rest, keep ? "cut" : "left out"),
                    keep ? "the fact that was being written when the program stopped is missing"
                         : "the fact that was being written is missing"));
  return keep ? segment.file.cut(segment.end) : Status{};
}

Result<DiskLog::Segment*> DiskLog::segment_for(std::uint64_t bytes) {
  if (!segments_.empty()) {
    Segment& last = segments_.rbegin()->second;
    const bool fits = last.end + bytes <= settings_.segment_bytes || last.end == kSegmentHeadBytes;
    if (!last.closed && fits) return &last;
    last.closed = true;
  }
  const std::uint32_t number = segments_.empty() ? 0 : segments_.rbegin()->first + 1;
  auto file = File::open(path_of(number), File::Mode::kCreate);
  if (!file) return tl::make_unexpected(file.error());
  const Bytes head = encode_segment_head();
  const auto written = file->write(0, head);
  if (!written) return tl::make_unexpected(written.error());
  if (*written == File::Written::kNoRoom) return nullptr;
  names_dirty_ = true;
  Segment segment{std::move(*file), head.size(), 0, false};
  return &segments_.emplace(number, std::move(segment)).first->second;
}

Result<std::optional<RecordPlace>> DiskLog::write(const RecordKey& key, std::uint8_t kind,
                                                  std::span<const std::byte> body) {
  RALI_ASSERT(use_ == Use::kKeep);
  const auto segment = segment_for(kRecordHeadBytes + body.size());
  if (!segment) return tl::make_unexpected(segment.error());
  if (*segment == nullptr) return std::optional<RecordPlace>{};
  Segment& to = **segment;
  const RecordPlace place{segments_.rbegin()->first, to.end};
  const Bytes record = encode_record(key, kind, body, place);
  const auto written = to.file.write(place.offset, record);
  if (written && *written == File::Written::kAll) {
    to.end += record.size();
    return std::optional(place);
  }
  // A part may be written. The next record overwrites it; any rest is cut at the next start.
  static_cast<void>(to.file.cut(to.end));
  if (!written) return tl::make_unexpected(written.error());
  return std::optional<RecordPlace>{};
}

Result<Bytes> DiskLog::body_of(const Entry& entry) const {
  const Segment& segment = segments_.at(entry.place.segment);
  const auto read = segment.file.read(entry.place.offset + kRecordHeadBytes, entry.head.body_bytes);
  if (read && read->size() < entry.head.body_bytes) {
    return fail(ErrorCode::kInput, segment.file.path(), "has become shorter",
                "Nothing but this program may write into its folder.");
  }
  return read;
}

Status DiskLog::sync() {
  Status status = sync_dirty();
  if (!status) forget_unsynced();
  return status;
}

Status DiskLog::sync_dirty() {
  if (names_dirty_) {
    if (auto status = folder_.sync(); !status) return status;
    names_dirty_ = false;
  }
  for (auto& [number, segment] : segments_) {
    if (segment.synced == segment.end) continue;
    if (auto status = segment.file.sync(); !status) return status;
    segment.synced = segment.end;
  }
  return {};
}

/// After a failed sync it is unknown which pages are on the disk, and a second sync may succeed
/// without writing them. So unsynced records must be appended again, elsewhere.
void DiskLog::forget_unsynced() {
  for (auto& [number, segment] : segments_) {
    if (segment.synced == segment.end) continue;
    forget_from({number, segment.synced});
    static_cast<void>(segment.file.cut(segment.synced));
    segment.end = segment.synced;
    segment.closed = true;
  }
}

}  // namespace rali::factlog
