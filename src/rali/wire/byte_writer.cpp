#include "rali/wire/byte_writer.hpp"

#include "rali/base/assert.hpp"

namespace rali::wire {

ByteWriter::ByteWriter(Encoding encoding, bool big_endian)
    : encoding_(encoding), big_endian_(big_endian && encoding == Encoding::kCdr) {
  RALI_ASSERT(encoding != Encoding::kOther);
  if (encoding != Encoding::kCdr) return;
  out_ = {std::byte{0}, big_endian_ ? std::byte{0} : std::byte{1}, std::byte{0}, std::byte{0}};
  origin_ = out_.size();
}

void ByteWriter::align(std::size_t size) {
  if (encoding_ != Encoding::kCdr) return;
  const std::size_t past = (out_.size() - origin_) % size;
  if (past != 0) out_.resize(out_.size() + size - past, std::byte{0});
}

void ByteWriter::string(std::string_view text) {
  const bool with_nul = encoding_ == Encoding::kCdr;
  sequence(text.size() + (with_nul ? 1U : 0U));
  bytes(std::as_bytes(std::span(text.data(), text.size())));
  if (with_nul) out_.push_back(std::byte{0});
}

void ByteWriter::time(Time t) {
  // Rounds down, so that the nanoseconds stay in [0, 1e9) for times before 1970 too.
  constexpr std::int64_t kSecond = 1'000'000'000;
  std::int64_t seconds = t.ns / kSecond;
  std::int64_t rest = t.ns % kSecond;
  if (rest < 0) {
    rest += kSecond;
    seconds -= 1;
  }
  put(static_cast<std::uint32_t>(static_cast<std::uint64_t>(seconds)));
  put(static_cast<std::uint32_t>(rest));
}

void ByteWriter::header(Time stamp, std::string_view frame_id) {
  if (encoding_ == Encoding::kRos1) put(std::uint32_t{0});
  time(stamp);
  string(frame_id);
}

}  // namespace rali::wire
