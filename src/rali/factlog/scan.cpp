#include "rali/factlog/scan.hpp"

#include <algorithm>
#include <optional>

#include "rali/base/crc32c.hpp"

namespace rali::factlog {

namespace {

/// Limit of bytes checked without success, in units of the segment's size: forged heads could each
/// claim the longest body.
constexpr std::uint64_t kVainMax = 8;

class Scan {
 public:
  Scan(std::span<const std::byte> bytes, std::uint32_t segment)
      : bytes_(bytes), segment_(segment) {}

  SegmentScan run() {
    SegmentScan out;
    out.head = check_segment_head(bytes_);
    if (bytes_.size() < kSegmentHeadBytes) return out;
    std::size_t at = kSegmentHeadBytes;
    out.whole_end = at;
    while (at < bytes_.size()) {
      if (const auto head = whole_at(at)) {
        if (at > out.whole_end) out.damages.push_back({out.whole_end, at - out.whole_end});
        out.records.push_back({*head, at});
        at += head->bytes();
        out.whole_end = at;
      } else if (vain_ > kVainMax * bytes_.size()) {
        break;
      } else {
        at = next_magic(bytes_, at + 1);
      }
    }
    return out;
  }

 private:
  [[nodiscard]] std::optional<RecordHead> whole_at(std::size_t at) {
    const auto head = decode_head(bytes_.subspan(at), {segment_, at});
    if (!head || head->bytes() > bytes_.size() - at) return std::nullopt;
    if (crc32c(bytes_.subspan(at + kRecordHeadBytes, head->body_bytes)) == head->body_crc) {
      return head;
    }
    vain_ += head->body_bytes;
    return std::nullopt;
  }

  std::span<const std::byte> bytes_;
  std::uint32_t segment_;
  std::uint64_t vain_ = 0;
};

}  // namespace

SegmentScan scan_segment(std::span<const std::byte> bytes, std::uint32_t segment) {
  return Scan(bytes, segment).run();
}

}  // namespace rali::factlog
