#include "rali/fleet/facts/packed_points.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "rali/base/assert.hpp"

namespace rali::fleet {

namespace {

constexpr std::uint8_t kMore = 0x80;  ///< another byte of the step follows
constexpr int kBitsPerByte = 7;

std::uint64_t spread(std::uint64_t v) {
  v &= 0x1FFFFFULL;
  v = (v | v << 32) & 0x1F00000000FFFFULL;
  v = (v | v << 16) & 0x1F0000FF0000FFULL;
  v = (v | v << 8) & 0x100F00F00F00F00FULL;
  v = (v | v << 4) & 0x10C30C30C30C30C3ULL;
  return (v | v << 2) & 0x1249249249249249ULL;
}

std::int32_t gathered(std::uint64_t v) {
  v &= 0x1249249249249249ULL;
  v = (v | v >> 2) & 0x10C30C30C30C30C3ULL;
  v = (v | v >> 4) & 0x100F00F00F00F00FULL;
  v = (v | v >> 8) & 0x1F0000FF0000FFULL;
  v = (v | v >> 16) & 0x1F00000000FFFFULL;
  v = (v | v >> 32) & 0x1FFFFFULL;
  return static_cast<std::int32_t>(v) - kPointSteps;
}

bool usable(float v) {
  constexpr auto kLimit_m = static_cast<float>((kPointSteps - 1) * kPointStep_m);
  return std::abs(v) <= kLimit_m;  // also false for NaN
}

std::int32_t code_of(float v) {
  return static_cast<std::int32_t>(std::lround(static_cast<double>(v) / kPointStep_m));
}

float value_of(std::int32_t code) { return static_cast<float>(code * kPointStep_m); }

std::uint8_t intensity_code(std::uint8_t intensity) {
  constexpr int kTop = 255 / kIntensityStep;
  return static_cast<std::uint8_t>(
      std::min((intensity + kIntensityStep / 2) / kIntensityStep, kTop));
}

std::vector<PointCode> codes_of(const PointArrays& points) {
  const bool with_intensity = !points.intensity.empty();
  RALI_ASSERT(points.y_m.size() == points.size() && points.z_m.size() == points.size());
  RALI_ASSERT(!with_intensity || points.intensity.size() == points.size());
  std::vector<PointCode> codes;
  codes.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const float x = points.x_m[i], y = points.y_m[i], z = points.z_m[i];
    if (!usable(x) || !usable(y) || !usable(z)) continue;
    PointCode code{code_of(x), code_of(y), code_of(z)};
    if (with_intensity) code.intensity = intensity_code(points.intensity[i]);
    codes.push_back(code);
  }
  return codes;
}

void append_step(std::vector<std::uint8_t>& bytes, std::uint64_t step) {
  for (; step >= kMore; step >>= kBitsPerByte) {
    bytes.push_back(static_cast<std::uint8_t>(step | kMore));
  }
  bytes.push_back(static_cast<std::uint8_t>(step));
}

std::uint64_t read_step(const std::uint8_t*& byte) {
  std::uint64_t step = 0;
  for (int shift = 0;; shift += kBitsPerByte) {
    const std::uint8_t b = *byte++;
    step |= static_cast<std::uint64_t>(b & (kMore - 1)) << shift;
    if ((b & kMore) == 0) return step;
  }
}

}  // namespace

std::uint64_t curve_place(const PointCode& point) {
  const auto part = [](std::int32_t v) {
    return spread(static_cast<std::uint64_t>(v + kPointSteps));
  };
  return part(point.x) | part(point.y) << 1 | part(point.z) << 2;
}

PointCode point_at(std::uint64_t curve_place) {
  return {gathered(curve_place), gathered(curve_place >> 1), gathered(curve_place >> 2), 0};
}

PackedPoints::PackedPoints(const PointArrays& points)
    : PackedPoints(codes_of(points), !points.intensity.empty()) {}

PackedPoints::PackedPoints(std::vector<PointCode> codes, bool with_intensity)
    : size_(codes.size()), with_intensity_(with_intensity) {
  std::vector<std::pair<std::uint64_t, std::uint8_t>> places;
  places.reserve(codes.size());
  for (const PointCode& code : codes) {
    places.emplace_back(curve_place(code), with_intensity ? code.intensity : std::uint8_t{0});
  }
  std::sort(places.begin(), places.end());
  std::vector<std::uint8_t> bytes;
  std::uint64_t before = 0;
  for (const auto& [place, intensity] : places)
    append_step(bytes, place - std::exchange(before, place));
  for (std::size_t i = 0; with_intensity && i < places.size(); i += 2) {
    const int second = i + 1 < places.size() ? places[i + 1].second : 0;
    bytes.push_back(static_cast<std::uint8_t>(places[i].second | second << 4));
  }
  bytes.shrink_to_fit();
  bytes_ = std::make_shared<const std::vector<std::uint8_t>>(std::move(bytes));
}

std::vector<PointCode> PackedPoints::codes() const {
  std::vector<PointCode> codes;
  codes.reserve(size_);
  const std::uint8_t* byte = bytes().data();
  std::uint64_t place = 0;
  for (std::size_t i = 0; i < size_; ++i) codes.push_back(point_at(place += read_step(byte)));
  for (std::size_t i = 0; with_intensity_ && i < size_; ++i) {
    codes[i].intensity = byte[i / 2] >> 4 * (i % 2) & 0xF;
  }
  return codes;
}

PointArrays PackedPoints::unpacked() const {
  PointArrays points;
  points.x_m.reserve(size_);
  points.y_m.reserve(size_);
  points.z_m.reserve(size_);
  if (with_intensity_) points.intensity.reserve(size_);
  for (const PointCode& code : codes()) {
    points.push_back(value_of(code.x), value_of(code.y), value_of(code.z));
    if (with_intensity_) {
      points.intensity.push_back(static_cast<std::uint8_t>(code.intensity * kIntensityStep));
    }
  }
  return points;
}

const std::vector<std::uint8_t>& PackedPoints::bytes() const {
  static const std::vector<std::uint8_t> kNone;
  return bytes_ ? *bytes_ : kNone;
}

}  // namespace rali::fleet
