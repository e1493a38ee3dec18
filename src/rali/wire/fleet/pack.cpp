#include "rali/wire/fleet/pack.hpp"

#include <algorithm>
#include <bit>

namespace rali::wire {

using geometry::Mat3;
using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3;

namespace {

constexpr unsigned kMore = 0x80U;
constexpr unsigned kVarintBitsMax = 63;
constexpr std::int32_t kCorrelationMax = 8388607;
constexpr std::size_t kSectionsMax = 64;

}  // namespace

void PackWriter::varint(std::uint64_t value) {
  while (value >= kMore) {
    out_.put(static_cast<std::uint8_t>((value & (kMore - 1)) | kMore));
    value >>= 7;
  }
  out_.put(static_cast<std::uint8_t>(value));
}

void PackWriter::text(const std::string& value, std::size_t maximum) {
  const std::string_view kept = std::string_view(value).substr(0, maximum);
  varint(kept.size());
  out_.bytes(std::as_bytes(std::span(kept.data(), kept.size())));
}

void PackWriter::float3(const Vec3& v) {
  for (int k = 0; k < 3; ++k) as_float(v[k]);
}

void PackWriter::double3(const Vec3& v) {
  for (int k = 0; k < 3; ++k) real(v[k]);
}

void PackWriter::rotation(const Mat3& R) {
  const fleet::RotationCode code = fleet::rotation_code(R, fleet::kPoseBits);
  number(code.largest);
  for (const std::int32_t part : code.parts) number(part);
}

void PackWriter::pose(const SE3& T) {
  rotation(T.R);
  double3(T.p);
}

void PackWriter::scaled(const Mat3& m) {
  const fleet::ScaledCode code = fleet::scaled_code(m);
  number(code.scale);
  for (const std::int16_t entry : code.entries) number(entry);
}

void PackWriter::information(const Mat6& m) {
  const Mat6 rounded = fleet::rounded_information(m);
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j <= i; ++j) {
      const auto bits = std::bit_cast<std::uint64_t>(rounded(i, j)) >> 16;
      number(static_cast<std::uint32_t>(bits));
      number(static_cast<std::uint16_t>(bits >> 32));
    }
  }
}

template <int N>
void PackWriter::covariance(const fleet::SquareMatrix<N>& m) {
  const fleet::CovarianceCode<N> code = fleet::covariance_code<N>(m);
  for (const float sigma : code.sigma) number(sigma);
  for (const std::int32_t c : code.correlation) {
    number(static_cast<std::uint16_t>(c & 0xFFFF));
    number(static_cast<std::int8_t>(c >> 16));
  }
}

template void PackWriter::covariance<3>(const fleet::SquareMatrix<3>&);
template void PackWriter::covariance<6>(const fleet::SquareMatrix<6>&);
template void PackWriter::covariance<9>(const fleet::SquareMatrix<9>&);

std::uint64_t PackReader::get_varint() {
  std::uint64_t value = 0;
  for (unsigned shift = 0; shift <= kVarintBitsMax && ok(); shift += 7) {
    const auto byte = in_.get<std::uint8_t>();
    const std::uint64_t bits = byte & (kMore - 1);
    if (shift == kVarintBitsMax && bits > 1) break;
    value |= bits << shift;
    if ((byte & kMore) != 0) continue;
    // Each number has exactly one encoding: otherwise forwarding a message could change its bytes.
    if (bits == 0 && shift != 0) break;
    return value;
  }
  fail_with("holds a number with too many bytes");
  return 0;
}

void PackReader::text(std::string& value, std::size_t maximum) {
  const std::uint64_t n = get_varint();
  if (n > maximum || n > remaining()) return fail_with("holds too long a text");
  const auto raw = in_.bytes(static_cast<std::size_t>(n));
  value.assign(reinterpret_cast<const char*>(raw.data()), raw.size());
}

void PackReader::float3(Vec3& v) {
  for (int k = 0; k < 3; ++k) as_float(v[k]);
}

void PackReader::double3(Vec3& v) {
  for (int k = 0; k < 3; ++k) real(v[k]);
}

void PackReader::rotation(Mat3& R) {
  fleet::RotationCode code;
  number(code.largest);
  if (code.largest > 3) fail_with("holds no rotation");
  for (std::int32_t& part : code.parts) number(part);
  if (ok()) R = fleet::rotation_of(code, fleet::kPoseBits);
}

void PackReader::pose(SE3& T) {
  rotation(T.R);
  double3(T.p);
}

void PackReader::scaled(Mat3& m) {
  fleet::ScaledCode code;
  number(code.scale);
  for (std::int16_t& entry : code.entries) number(entry);
  m = fleet::scaled_of(code);
}

void PackReader::information(Mat6& m) {
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j <= i; ++j) {
      std::uint32_t low = 0;
      std::uint16_t high = 0;
      number(low);
      number(high);
      m(i, j) = m(j, i) = std::bit_cast<double>((std::uint64_t{high} << 32 | low) << 16);
      if (!std::isfinite(m(i, j))) fail_with("holds a value that is not a number");
    }
  }
}

std::int32_t PackReader::get24() {
  const auto low = in_.get<std::uint16_t>();
  const auto high = in_.get<std::int8_t>();
  const std::int32_t value = high * 65536 + low;
  if (value < -kCorrelationMax) fail_with("holds a correlation beyond 1");
  return value;
}

template <int N>
void PackReader::covariance(fleet::SquareMatrix<N>& m) {
  fleet::CovarianceCode<N> code;
  for (float& sigma : code.sigma) {
    number(sigma);
    if (sigma < 0.0F) fail_with("holds a negative standard deviation");
  }
  for (std::int32_t& c : code.correlation) c = get24();
  m = fleet::covariance_of<N>(code);
}

template void PackReader::covariance<3>(fleet::SquareMatrix<3>&);
template void PackReader::covariance<6>(fleet::SquareMatrix<6>&);
template void PackReader::covariance<9>(fleet::SquareMatrix<9>&);

BodyReader::BodyReader(std::span<const std::byte> body) {
  PackReader in(body);
  while (in.ok() && in.remaining() > 0) {
    Section section;
    const std::size_t begin = in.offset();
    std::uint64_t length = 0;
    in.number(section.tag);
    in.varint(length);
    if (!in.ok() || length > in.remaining()) {
      fault_ = "ends within a section";
      return;
    }
    section.content = in.bytes(static_cast<std::size_t>(length));
    section.whole = body.subspan(begin, in.offset() - begin);
    sections_.push_back(section);
    if (sections_.size() > kSectionsMax) {
      fault_ = "has too many sections";
      return;
    }
  }
}

std::span<const std::byte> BodyReader::take(std::uint8_t tag) {
  std::span<const std::byte> content;
  int found = 0;
  for (Section& section : sections_) {
    if (section.tag != tag) continue;
    content = section.content;
    section.read = true;
    ++found;
  }
  if (found == 0 && ok()) fault_ = "lacks a section";
  if (found > 1 && ok()) fault_ = "has a section twice";
  return content;
}

bool BodyReader::has(std::uint8_t tag) const {
  return std::any_of(sections_.begin(), sections_.end(),
                     [tag](const Section& section) { return section.tag == tag; });
}

std::vector<std::uint8_t> BodyReader::unread() const {
  std::vector<std::uint8_t> out;
  for (const Section& section : sections_) {
    if (section.read) continue;
    for (const std::byte b : section.whole) out.push_back(std::to_integer<std::uint8_t>(b));
  }
  return out;
}

}  // namespace rali::wire
