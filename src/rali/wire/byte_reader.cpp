#include "rali/wire/byte_reader.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace rali::wire {
namespace {

constexpr std::size_t kCdrHeaderBytes = 4;
constexpr const char* kTooShort = "ends before its fields do";

}  // namespace

ByteReader::ByteReader(std::span<const std::byte> message, Encoding encoding)
    : message_(message), encoding_(encoding) {
  if (encoding == Encoding::kCdr) {
    read_cdr_header();
  } else if (encoding != Encoding::kRos1) {
    fail_with("is neither ROS 1 nor CDR");
  }
}

void ByteReader::read_cdr_header() {
  if (message_.size() < kCdrHeaderBytes) {
    fail_with("is shorter than a CDR header");
    return;
  }
  // Representation identifier, big endian: 0/1 XCDR1, 6/7 XCDR2 (plain); odd = little endian.
  const auto high = std::to_integer<unsigned>(message_[0]);
  const auto low = std::to_integer<unsigned>(message_[1]);
  const bool xcdr1 = high == 0 && low <= 1;
  const bool xcdr2 = high == 0 && (low == 6 || low == 7);
  if (!xcdr1 && !xcdr2) {
    fail_with("has a CDR header of an unknown kind");
    return;
  }
  big_endian_ = (low & 1U) == 0;
  align_max_ = xcdr1 ? 8 : 4;
  at_ = origin_ = kCdrHeaderBytes;
}

void ByteReader::fail_with(const char* fault) {
  if (fault_ != nullptr) return;
  fault_ = fault;
  fault_at_ = at_;
}

bool ByteReader::need(std::size_t bytes) {
  if (fault_ == nullptr && bytes <= remaining()) return true;
  fail_with(kTooShort);
  return false;
}

void ByteReader::align(std::size_t size) {
  if (fault_ != nullptr) return;
  const std::size_t step = std::min(size, align_max_);
  const std::size_t past = (at_ - origin_) % step;
  // Padding at the very end may be missing: then only a following field is an error.
  if (past != 0) at_ = std::min(at_ + step - past, message_.size());
}

void ByteReader::skip(std::size_t bytes) {
  if (need(bytes)) at_ += bytes;
}

std::span<const std::byte> ByteReader::bytes(std::size_t bytes) {
  if (!need(bytes)) return {};
  const std::span<const std::byte> found = message_.subspan(at_, bytes);
  at_ += bytes;
  return found;
}

std::string ByteReader::string() {
  const auto length = get<std::uint32_t>();
  const std::span<const std::byte> raw = bytes(length);
  std::string text(reinterpret_cast<const char*>(raw.data()), raw.size());
  if (encoding_ == Encoding::kCdr && !text.empty() && text.back() == '\0') text.pop_back();
  return text;
}

std::uint32_t ByteReader::sequence(std::size_t element_bytes) {
  const auto length = get<std::uint32_t>();
  if (!ok()) return 0;
  if (length <= remaining() / element_bytes) return length;
  fail_with("claims more elements than it has bytes");
  return 0;
}

Time ByteReader::time() {
  const auto seconds = get<std::uint32_t>();
  const auto nanoseconds = get<std::uint32_t>();
  const std::int64_t whole = encoding_ == Encoding::kCdr
                                 ? static_cast<std::int64_t>(static_cast<std::int32_t>(seconds))
                                 : static_cast<std::int64_t>(seconds);
  return Time::from_ns(whole * 1'000'000'000 + nanoseconds);
}

ByteReader::Header ByteReader::header() {
  if (encoding_ == Encoding::kRos1) static_cast<void>(get<std::uint32_t>());
  Header header;
  header.stamp = time();
  header.frame_id = string();
  return header;
}

Error ByteReader::error(std::string_view type) const {
  return Error{ErrorCode::kInput,
               fmt::format("a {} message of {} bytes {}", type, message_.size(),
                           fault_ == nullptr ? kTooShort : fault_),
               fmt::format("byte {}", fault_at_), "The message is left out."};
}

}  // namespace rali::wire
