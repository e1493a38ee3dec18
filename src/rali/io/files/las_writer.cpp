#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/core.h>

#include "rali/base/assert.hpp"
#include "rali/io/files/atomic_file.hpp"
#include "rali/io/files/cloud_writers.hpp"
#include "rali/io/files/record.hpp"

namespace rali::io {
namespace {

// Sizes and codes: ASPRS, "LAS Specification 1.4 - R15".
constexpr std::uint16_t kHeaderBytes = 375;
constexpr std::uint32_t kVlrHeaderBytes = 54;
constexpr std::uint16_t kExtraBytesRecordBytes = 192;
constexpr std::uint16_t kExtraBytesRecordId = 4;
constexpr std::uint8_t kPointFormat = 6;
constexpr std::uint16_t kPointBytes = 30 + 4;  // format 6 and sigma
constexpr std::uint8_t kExtraFloat = 9;
constexpr std::uint16_t kWktBit = 1 << 4;  // required with point formats 6 to 10
constexpr double kScale_m = 0.001;
constexpr std::size_t kLot = 4096;

struct Bounds {
  double min_m[3] = {0.0, 0.0, 0.0};
  double max_m[3] = {0.0, 0.0, 0.0};
  bool empty = true;

  void add(const double (&p)[3]) {
    for (int k = 0; k < 3; ++k) {
      min_m[k] = empty ? p[k] : std::min(min_m[k], p[k]);
      max_m[k] = empty ? p[k] : std::max(max_m[k], p[k]);
    }
    empty = false;
  }
};

void put_header(Record& out, std::uint64_t points, const double (&offset_m)[3],
                const Bounds& bounds) {
  out.put_text("LASF", 4).put(std::uint16_t{0}).put(kWktBit);
  out.put_zeros(16);  // project
  out.put(std::uint8_t{1}).put(std::uint8_t{4});
  out.put_text("RaLI", 32).put_text("rali map", 32);
  out.put(std::uint16_t{0}).put(std::uint16_t{0});  // no date: same input, same bytes
  out.put(kHeaderBytes);
  out.put(std::uint32_t{kHeaderBytes} + kVlrHeaderBytes + kExtraBytesRecordBytes);
  out.put(std::uint32_t{1});  // variable length records
  out.put(kPointFormat).put(kPointBytes);
  out.put_zeros(4 + 5 * 4);  // counts of 32 bits, 0 with these formats
  for (int k = 0; k < 3; ++k) out.put(kScale_m);
  for (int k = 0; k < 3; ++k) out.put(offset_m[k]);
  for (int k = 0; k < 3; ++k) out.put(bounds.max_m[k]).put(bounds.min_m[k]);
  out.put(std::uint64_t{0});                        // waveforms
  out.put(std::uint64_t{0}).put(std::uint32_t{0});  // extended records
  out.put(points).put(points).put_zeros(14 * 8);    // all are first returns
  RALI_ASSERT(out.size() == kHeaderBytes);
}

/// Declares the 4 extra bytes of each point.
void put_extra_bytes_vlr(Record& out) {
  out.put(std::uint16_t{0}).put_text("LASF_Spec", 16);
  out.put(kExtraBytesRecordId).put(kExtraBytesRecordBytes).put_text("Extra Bytes", 32);
  out.put(std::uint16_t{0}).put(kExtraFloat).put(std::uint8_t{0});
  out.put_text("sigma", 32).put_zeros(4 + 3 * 8 * 3 + 3 * 8 * 2);
  out.put_text("position error, 1 sigma [m]", 32);
}

class LasFile {
 public:
  LasFile(AtomicFile& file, const LasOptions& options) : file_(file), options_(options) {}

  Status begin() {
    Record head;
    put_header(head, 0, offset_m_, bounds_);
    put_extra_bytes_vlr(head);
    RALI_ASSERT(head.size() ==
                std::size_t{kHeaderBytes} + kVlrHeaderBytes + kExtraBytesRecordBytes);
    return file_.write(head.bytes());
  }

  Status add(const MapColumns& c) {
    for (std::size_t i = 0; i < c.size(); ++i) {
      if (!put_point(c, i)) {
        return fail(ErrorCode::kInput, file_.path(),
                    fmt::format("point {} is not finite or more than 2147 km from the first, which "
                                "LAS cannot hold",
                                written_));
      }
      ++written_;
      if ((i + 1) % kLot != 0 && i + 1 != c.size()) continue;
      if (auto status = file_.write(lot_.bytes()); !status) return status;
      lot_.clear();
    }
    return {};
  }

  /// Rewrites the header, now that bounds and offset are known.
  Status finish() {
    Record head;
    put_header(head, written_, offset_m_, bounds_);
    return file_.overwrite(0, head.bytes());
  }

  [[nodiscard]] std::uint64_t written() const { return written_; }

 private:
  bool put_point(const MapColumns& c, std::size_t i) {
    const double p[3] = {static_cast<double>(c.x_m[i]) + options_.shift_m[0],
                         static_cast<double>(c.y_m[i]) + options_.shift_m[1],
                         static_cast<double>(c.z_m[i]) + options_.shift_m[2]};
    double stored[3] = {};
    for (int k = 0; k < 3; ++k) {
      if (!std::isfinite(p[k])) return false;
      if (written_ == 0) offset_m_[k] = std::floor(p[k]);
      const double steps = std::round((p[k] - offset_m_[k]) / kScale_m);
      if (!(std::abs(steps) <= 2147483647.0)) return false;
      lot_.put(static_cast<std::int32_t>(steps));
      stored[k] = steps * kScale_m + offset_m_[k];
    }
    bounds_.add(stored);
    const double scaled = static_cast<double>(c.intensity[i]) * options_.intensity_scale;
    const double limited = scaled >= 0.0 ? std::min(std::round(scaled), 65535.0) : 0.0;
    lot_.put(static_cast<std::uint16_t>(limited));
    lot_.put(std::uint8_t{0x11});  // return 1 of 1
    lot_.put_zeros(2);             // flags, class "never classified"
    lot_.put(static_cast<std::uint8_t>(std::min<std::uint16_t>(c.seen[i], 255)));
    lot_.put(std::int16_t{0});  // scan angle
    lot_.put(static_cast<std::uint16_t>(c.vehicle[i] + 1));
    lot_.put(0.0);  // GPS time
    lot_.put(c.sigma_m[i]);
    return true;
  }

  AtomicFile& file_;
  const LasOptions& options_;
  double offset_m_[3] = {0.0, 0.0, 0.0};
  Bounds bounds_;
  std::uint64_t written_ = 0;
  Record lot_;
};

}  // namespace

double las_intensity_scale(std::span<const float> intensity) {
  const float largest =
      intensity.empty() ? 0.0F : *std::max_element(intensity.begin(), intensity.end());
  const double full = largest <= 1.0F ? 1.0 : largest <= 255.0F ? 255.0 : 65535.0;
  return 65535.0 / full;
}

Status write_map_las(const std::string& path, std::uint64_t points, const MapParts& parts,
                     const LasOptions& options) {
  auto file = AtomicFile::create(path);
  if (!file) return tl::make_unexpected(file.error());
  LasFile las(*file, options);
  if (auto status = las.begin(); !status) return status;
  MapColumns columns;
  while (true) {
    const auto more = parts(columns);
    if (!more) return tl::make_unexpected(more.error());
    if (!*more) break;
    if (auto status = las.add(columns); !status) return status;
  }
  RALI_ASSERT(las.written() == points);
  if (auto status = las.finish(); !status) return status;
  return file->commit();
}

}  // namespace rali::io
