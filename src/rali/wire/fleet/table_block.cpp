#include "rali/wire/fleet/table_block.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "rali/fleet/facts/rounding.hpp"

namespace rali::wire {

namespace {

using fleet::PoseSigma;
using fleet::TableFrame;
using fleet::TablePose;
using geometry::SE3;

constexpr std::size_t kPosesMax = 100000, kFramesMax = 1024;
constexpr double kPlaceStep_m = 1e-3;
constexpr int kRotationBits = 15;
constexpr std::int64_t kPlaceMax = std::int64_t{1} << 40;

/// One byte for 0.1 mm to 270 m, or rad: steps of 6 %; 0 is 0.
constexpr double kSigmaMin = 1e-4, kSigmaRatio = 1.06;

std::uint8_t sigma_code(double sigma) {
  if (!(sigma > 0.0)) return 0;
  const double steps = std::round(std::log(sigma / kSigmaMin) / std::log(kSigmaRatio)) + 1.0;
  return static_cast<std::uint8_t>(std::clamp(steps, 1.0, 255.0));
}

double sigma_of(std::uint8_t code) {
  return code == 0 ? 0.0 : kSigmaMin * std::pow(kSigmaRatio, code - 1);
}

/// Half a turn in 256 steps.
std::uint8_t azimuth_code(double azimuth_rad) {
  const double turns = azimuth_rad / std::numbers::pi;
  const double fraction = turns - std::floor(turns);
  return static_cast<std::uint8_t>(static_cast<unsigned>(std::lround(fraction * 256.0)) & 0xFFU);
}

void write_sigma(PackWriter& a, const PoseSigma& s) {
  for (const double value : {s.major_m, s.minor_m, s.z_m, s.yaw_rad}) a.number(sigma_code(value));
  a.number(azimuth_code(s.major_azimuth_rad));
}

void read_sigma(PackReader& a, PoseSigma& s) {
  for (double* value : {&s.major_m, &s.minor_m, &s.z_m, &s.yaw_rad}) {
    std::uint8_t code = 0;
    a.number(code);
    *value = sigma_of(code);
  }
  std::uint8_t azimuth = 0;
  a.number(azimuth);
  s.major_azimuth_rad = azimuth * std::numbers::pi / 256.0;
}

/// A rotation: one byte for the index of the largest part, then three parts of 15 bits in two bytes
/// each.
void write_rotation(PackWriter& a, const geometry::Mat3& R) {
  const fleet::RotationCode code = fleet::rotation_code(R, kRotationBits);
  a.number(code.largest);
  for (const std::int32_t part : code.parts) a.number(static_cast<std::int16_t>(part));
}

void read_rotation(PackReader& a, geometry::Mat3& R) {
  fleet::RotationCode code;
  a.number(code.largest);
  if (code.largest > 3) a.fail_with("holds no rotation");
  for (std::int32_t& part : code.parts) {
    std::int16_t narrow = 0;
    a.number(narrow);
    part = narrow;
  }
  if (a.ok()) R = fleet::rotation_of(code, kRotationBits);
}

std::array<std::int64_t, 3> place_code(const SE3& T) {
  std::array<std::int64_t, 3> code{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double steps = std::round(T.p[static_cast<Eigen::Index>(k)] / kPlaceStep_m);
    const auto limit = static_cast<double>(kPlaceMax);
    code[k] =
        std::isfinite(steps) ? static_cast<std::int64_t>(std::clamp(steps, -limit, limit)) : 0;
  }
  return code;
}

/// Poses along a path are near each other: positions are encoded as differences.
void write_pose(PackWriter& a, const SE3& T, std::array<std::int64_t, 3>& before) {
  const auto place = place_code(T);
  for (std::size_t k = 0; k < 3; ++k) a.signed_varint(place[k] - before[k]);
  before = place;
  write_rotation(a, T.R);
}

void read_pose(PackReader& a, SE3& T, std::array<std::int64_t, 3>& before) {
  for (std::size_t k = 0; k < 3; ++k) {
    std::int64_t step = 0;
    a.signed_varint(step);
    if (step > 2 * kPlaceMax || step < -2 * kPlaceMax)
      a.fail_with("holds a place out of all bounds");
    before[k] = a.ok() ? std::clamp(before[k] + step, -kPlaceMax, kPlaceMax) : 0;
    T.p[static_cast<Eigen::Index>(k)] = static_cast<double>(before[k]) * kPlaceStep_m;
  }
  read_rotation(a, T.R);
}

template <class Archive, class Of>
void layout_head(Archive& a, Of& table) {
  a.varint(table.term);
  a.varint(table.revision);
  a.varint(table.base_revision);
  a.varint(table.part);
  a.flag(table.last_part);
  a.number(table.hash);
}

template <class Archive, class Key>
void layout_key(Archive& a, Key& key) {
  a.varint(key.vehicle.value);
  a.varint(key.epoch);
}

}  // namespace

void write_table(BodyWriter& body, const fleet::Table& table) {
  body.section(1, [&](PackWriter& a) { layout_head(a, table); });
  body.section(2, [&](PackWriter& a) {
    a.list(table.frames, kFramesMax, [](PackWriter& b, const TableFrame& frame) {
      layout_key(b, frame.stream);
      b.varint(frame.group);
      b.pose(frame.T_map_odom);
      write_sigma(b, frame.sigma);
    });
  });
  body.section(3, [&](PackWriter& a) {
    fleet::StreamKey stream;
    std::int64_t keyframe = 0;
    std::array<std::int64_t, 3> place{};
    a.list(table.poses, kPosesMax, [&](PackWriter& b, const TablePose& pose) {
      const bool same = pose.stream == stream;
      b.varint(zigzag(pose.keyframe - keyframe) << 1 | (same ? 1U : 0U));
      if (!same) layout_key(b, pose.stream);
      write_pose(b, pose.T_map_body, place);
      write_sigma(b, pose.sigma);
      stream = pose.stream;
      keyframe = pose.keyframe;
    });
  });
}

void read_table(BodyReader& body, fleet::Table& table) {
  body.section(1, [&](PackReader& a) { layout_head(a, table); });
  body.section(2, [&](PackReader& a) {
    a.list(table.frames, kFramesMax, [](PackReader& b, TableFrame& frame) {
      layout_key(b, frame.stream);
      b.varint(frame.group);
      b.pose(frame.T_map_odom);
      read_sigma(b, frame.sigma);
    });
  });
  body.section(3, [&](PackReader& a) {
    fleet::StreamKey stream;
    std::int64_t keyframe = 0;
    std::array<std::int64_t, 3> place{};
    a.list(table.poses, kPosesMax, [&](PackReader& b, TablePose& pose) {
      std::uint64_t head = 0;
      b.varint(head);
      if ((head & 1U) == 0) layout_key(b, stream);
      keyframe += unzigzag(head >> 1);
      constexpr std::int64_t kKeyframeMax = 0xFFFFFFFFLL;
      if (keyframe < 0 || keyframe > kKeyframeMax) {
        keyframe = 0;
        b.fail_with("names a keyframe out of all bounds");
      }
      pose.stream = stream;
      pose.keyframe = static_cast<std::uint32_t>(keyframe);
      read_pose(b, pose.T_map_body, place);
      read_sigma(b, pose.sigma);
    });
  });
}

}  // namespace rali::wire
