#include "rali/wire/fleet/point_block.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include <zstd.h>

#include "rali/fleet/facts/quantise.hpp"

namespace rali::wire {

namespace {

using fleet::PointCode;

constexpr std::uint8_t kHeadSection = 1, kPointSection = 2;
constexpr int kZstdLevel = 9;
/// A coordinate has 21 bits and a sign: three bytes.
constexpr std::size_t kBytesPerAxis = 3;
constexpr std::size_t kAxisPlanes = 3 * kBytesPerAxis;

template <class Archive, class Points>
void layout_head(Archive& a, Points& points) {
  a.varint(points.keyframe);
  a.flag(points.refinement);
  a.rotation(points.T_body_lidar.R);
  a.float3(points.T_body_lidar.p);
}

std::array<std::int32_t, 3> axes(const PointCode& p) { return {p.x, p.y, p.z}; }

std::vector<std::uint8_t> planes_of(const std::vector<PointCode>& codes, bool with_intensity) {
  const std::size_t n = codes.size();
  std::vector<std::uint8_t> planes(n * (kAxisPlanes + (with_intensity ? 1 : 0)));
  std::array<std::int32_t, 3> before{};
  for (std::size_t i = 0; i < n; ++i) {
    const auto now = axes(codes[i]);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::uint64_t step = zigzag(now[axis] - before[axis]);
      for (std::size_t b = 0; b < kBytesPerAxis; ++b) {
        planes[(3 * b + axis) * n + i] = static_cast<std::uint8_t>(step >> (8 * b));
      }
    }
    before = now;
    if (with_intensity) planes[kAxisPlanes * n + i] = codes[i].intensity;
  }
  return planes;
}

std::vector<PointCode> codes_of(const std::vector<std::uint8_t>& planes, std::size_t n,
                                bool with_intensity) {
  std::vector<PointCode> codes(n);
  std::array<std::int32_t, 3> at{};
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::uint64_t step = 0;
      for (std::size_t b = 0; b < kBytesPerAxis; ++b) {
        step |= std::uint64_t{planes[(3 * b + axis) * n + i]} << (8 * b);
      }
      at[axis] += static_cast<std::int32_t>(unzigzag(step));
      // Steps of 2^23 sum beyond 32 bits after 256 points; no valid point is out of bounds.
      at[axis] = std::clamp(at[axis], -fleet::kPointSteps, fleet::kPointSteps - 1);
    }
    codes[i] = {at[0], at[1], at[2],
                with_intensity ? planes[kAxisPlanes * n + i] : std::uint8_t{0}};
  }
  return codes;
}

Bytes compressed(const std::vector<std::uint8_t>& planes) {
  Bytes out(ZSTD_compressBound(planes.size()));
  const std::size_t size =
      ZSTD_compress(out.data(), out.size(), planes.data(), planes.size(), kZstdLevel);
  // Fails only without memory; the reader then refuses the empty section.
  out.resize(ZSTD_isError(size) != 0 ? 0 : size);
  return out;
}

}  // namespace

void write_point_block(BodyWriter& body, const fleet::KeyframePoints& points) {
  const bool with_intensity = points.points.has_intensity();
  const std::vector<PointCode> codes = points.points.codes();
  body.section(kHeadSection, [&](PackWriter& a) { layout_head(a, points); });
  body.section(kPointSection, [&](PackWriter& a) {
    a.varint(codes.size());
    a.flag(with_intensity);
    a.bytes(compressed(planes_of(codes, with_intensity)));
  });
}

void read_point_block(BodyReader& body, fleet::KeyframePoints& points) {
  body.section(kHeadSection, [&](PackReader& a) { layout_head(a, points); });
  body.section(kPointSection, [&](PackReader& a) {
    std::size_t n = 0;
    bool with_intensity = false;
    a.varint(n);
    a.flag(with_intensity);
    const std::span<const std::byte> raw = a.rest();
    if (!a.ok()) return;
    if (n > fleet::kPointsMax) return a.fail_with("holds too many points");
    std::vector<std::uint8_t> planes(n * (kAxisPlanes + (with_intensity ? 1 : 0)));
    const std::size_t got = ZSTD_decompress(planes.data(), planes.size(), raw.data(), raw.size());
    if (ZSTD_isError(got) != 0 || got != planes.size()) {
      return a.fail_with("holds points that cannot be unpacked");
    }
    points.points = fleet::PackedPoints(codes_of(planes, n, with_intensity), with_intensity);
  });
}

}  // namespace rali::wire
