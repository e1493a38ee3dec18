// A consistent sequence of facts of three vehicles, in which any fields are replaced by false
// values, into the joint estimate: no crash, no hang, no NaN in it. Mutated bytes seldom pass the
// decoder with more than one message intact (fuzz_centre); here all facts stay readable.
//
// Input: 1 byte of settings, then a sequence of replacements (fact, field, value).
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>
#include <memory>
#include <variant>
#include <vector>

#include <fuzzer/FuzzedDataProvider.h>

#include "rali/base/assert.hpp"
#include "rali/fleet/centre/round_centre.hpp"
#include "rali/fleet/centre/rounds_for_test.hpp"
#include "rali/fleet/facts/fact_store.hpp"
#include "rali/fleet/facts/quantise.hpp"

namespace {

using namespace rali;
using geometry::Mat3;
using geometry::Vec3;

constexpr int kLiesMax = 24;

/// Replacement values: at and beyond the accepted bounds, and harmless ones.
constexpr double kValues[] = {0.0, -0.0, 1.0,  -1.0, 1e-30, -1e-30, 1e-12, 1e-6, 0.1,
                              3.0, -7.0, 50.0, 1e3,  -1e4,  9e4,    1e5,   9e6,  -9e6,
                              1e7, 1e9,  1e12, 1e20, 1e30,  -1e30,  1e300};

class Liar {
 public:
  Liar(FuzzedDataProvider& data, std::vector<fleet::Fact>& facts) : data_(data), facts_(facts) {}

  void lie() {
    fleet::Fact& fact = facts_[number() % facts_.size()];
    field_ = number() % 24;
    if (field_ == 23) fact.t = time();
    std::visit([this](auto& body) { about(body); }, fact.body);
  }

 private:
  std::size_t number() { return data_.ConsumeIntegral<std::uint16_t>(); }

  double value() { return kValues[data_.ConsumeIntegral<std::uint8_t>() % std::size(kValues)]; }

  Time time() {
    const double s = value();
    if (s >= 1e9) return Time::from_ns(std::numeric_limits<std::int64_t>::max());
    if (s <= -1e9) return Time::from_ns(std::numeric_limits<std::int64_t>::min());
    return Time::from_s(s);
  }

  template <class Matrix>
  void entry_of(Matrix& m) {
    m(static_cast<Eigen::Index>(number()) % m.size()) = value();
  }

  /// Keeps the matrix symmetric: the decoder gives no other matrices.
  template <int N>
  void symmetric(Eigen::Matrix<double, N, N>& m) {
    const auto i = static_cast<Eigen::Index>(number()) % N;
    const auto j = static_cast<Eigen::Index>(number()) % N;
    m(i, j) = m(j, i) = value();
  }

  void pose(geometry::SE3& T) {
    entry_of(T.p);
    if (number() % 2 == 0)
      T.R = T.R * geometry::so3_exp(Vec3(value(), 0.3, 0.1).cwiseMin(3.0).cwiseMax(-3.0));
  }

  void about(fleet::EpochStart& start) {
    if (field_ % 2 == 0) start.antennas_body_m.clear();
    for (Vec3& antenna : start.antennas_body_m) entry_of(antenna);
  }

  void about(fleet::Increment& step) {
    switch (field_) {
      case 0:
        step.node = static_cast<std::uint32_t>(number() * number());
        break;
      case 1:
        step.keyframe = static_cast<std::uint32_t>(number() % 64);
        break;
      case 2:
        step.keyframe.reset();
        break;
      case 3:
        step.begins = !step.begins;
        break;
      case 4:
        step.at_rest = !step.at_rest;
        break;
      case 5:
        step.degenerate = !step.degenerate;
        break;
      case 6:
        step.levelled = !step.levelled;
        break;
      case 7:
        entry_of(step.v_odom_mps);
        break;
      case 8:
        entry_of(step.gyro_bias_radps);
        break;
      case 9:
        entry_of(step.accel_bias_mps2);
        break;
      case 10:
        entry_of(step.g_odom_mps2);
        break;
      case 11:
        symmetric<6>(step.covariance);
        break;
      case 12:
        symmetric<6>(step.lidar_information);
        break;
      case 13:
        step.lidar_information *= value();
        break;
      case 14:
        step.inertial.reset();
        break;
      case 15:
      case 16:
      case 17:
      case 18:
      case 19:
        if (step.inertial) about(*step.inertial);
        break;
      default:
        pose(step.T_odom_body);
    }
  }

  void about(graph::InertialFactor& f) {
    Mat3* const slopes[] = {&f.d_rotation_d_gyro, &f.d_velocity_d_gyro, &f.d_velocity_d_accel,
                            &f.d_position_d_gyro, &f.d_position_d_accel};
    switch (number() % 9) {
      case 0:
        f.duration_s = value();
        break;
      case 1:
        entry_of(f.dv_mps);
        break;
      case 2:
        entry_of(f.dp_m);
        break;
      case 3:
        entry_of(*slopes[number() % std::size(slopes)]);
        break;
      case 4:
        symmetric<9>(f.covariance);
        break;
      case 5:
        f.gyro_walk_radps_rts = value();
        break;
      case 6:
        f.accel_walk_mps2_rts = value();
        break;
      case 7:
        entry_of(f.g_odom_mps2);
        break;
      default:
        pose(f.T_body_imu);
    }
  }

  void about(fleet::RangeBlock& block) {
    if (block.ranges.empty()) return;
    fleet::RangeEntry& entry = block.ranges[number() % block.ranges.size()];
    switch (field_ % 8) {
      case 0:
        entry.t = time();
        break;
      case 1:
        entry.from.value = static_cast<std::uint16_t>(number() % 5);
        break;
      case 2:
        entry.to.value = static_cast<std::uint16_t>(number() % 5);
        break;
      case 3:
        entry.from_antenna = static_cast<std::uint8_t>(number());
        break;
      case 4:
        entry.range_m = value();
        break;
      case 5:
        entry.sigma_m = value();
        break;
      case 6:
        entry.at_rest = !entry.at_rest;
        break;
      default:
        pose(entry.T_odom_body);
    }
  }

  void about(fleet::KeyframePoints& points) {
    switch (field_ % 4) {
      case 0:
        points.keyframe = static_cast<std::uint32_t>(number() % 64);
        break;
      case 1:
        points.refinement = !points.refinement;
        break;
      case 2:
        move_all(points);
        break;
      default:
        pose(points.T_body_lidar);
    }
  }

  void move_all(fleet::KeyframePoints& points) {
    fleet::PointArrays arrays = points.points.unpacked();
    arrays.x_m.assign(arrays.size(), static_cast<float>(value()));
    points.points = fleet::PackedPoints(arrays);
  }

  void about(fleet::Loop& loop) {
    switch (field_ % 6) {
      case 0:
        loop.from.seq = static_cast<std::uint32_t>(number() % 64);
        break;
      case 1:
        loop.to.vehicle.value = static_cast<std::uint16_t>(number() % 5);
        break;
      case 2:
        loop.from_epoch = loop.from_epoch + 1;
        break;
      case 3:
        symmetric<6>(loop.information);
        break;
      case 4:
        loop.information *= value();
        break;
      default:
        pose(loop.T_from_to);
    }
  }

  void about(fleet::UnreadBody&) {}

  FuzzedDataProvider& data_;
  std::vector<fleet::Fact>& facts_;
  std::size_t field_ = 0;
};

/// The round as reported, with points of a room's corner at some keyframes and a loop.
std::vector<fleet::Fact> story(fleet::FleetForTest& fleet) {
  std::vector<fleet::Fact> facts = fleet.round();
  std::vector<fleet::Fact> more;
  for (const fleet::Fact& fact : facts) {
    const auto* step = std::get_if<fleet::Increment>(&fact.body);
    if (step == nullptr || !step->keyframe || *step->keyframe % 3 != 0) continue;
    fleet::KeyframePoints points;
    points.keyframe = *step->keyframe;
    fleet::PointArrays arrays;
    for (int k = 0; k < 64; ++k) {
      const float a = 0.4F * static_cast<float>(k % 8), b = 0.4F * static_cast<float>(k / 8);
      arrays.push_back(a, 3.0F, b);
      arrays.push_back(4.0F, a, b);
    }
    points.points = fleet::PackedPoints(arrays);
    more.push_back({{fact.key.vehicle, 0, fact.key.seq + 5000}, fact.t, points});
  }
  fleet::Loop loop;
  loop.from = {VehicleId{0}, 2};
  loop.to = {VehicleId{1}, 2};
  loop.T_from_to.p = {2.0, 4.0, 0.0};
  loop.information = geometry::Mat6::Identity() * 1e4;
  more.push_back({{VehicleId{0}, 0, 9999}, fleet.now(), loop});
  facts.insert(facts.end(), more.begin(), more.end());
  return facts;
}

void check(const fleet::FleetEstimate& estimate) {
  for (const fleet::VehicleFrame& frame : estimate.frames) {
    RALI_ASSERT(frame.T_map_odom.p.allFinite() && frame.T_map_odom.R.allFinite());
  }
  for (const auto& [id, pose] : estimate.keyframes) {
    RALI_ASSERT(pose.T_map_body.p.allFinite() && pose.T_map_body.R.allFinite());
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  FuzzedDataProvider data(bytes, size);
  const auto mode = data.ConsumeIntegral<std::uint8_t>();
  fleet::RoundsForTest options;
  options.steps = 3;
  options.stand_s = 1.0;
  options.degenerate = (mode & 1U) != 0;
  fleet::FleetForTest fleet(options);
  std::vector<fleet::Fact> facts = story(fleet);
  Liar liar(data, facts);
  for (int k = 0; k < kLiesMax && data.remaining_bytes() > 0; ++k) liar.lie();

  fleet::FactStore store(VehicleId{0}, {VehicleId{0}, VehicleId{1}, VehicleId{2}});
  for (const fleet::Fact& fact : facts) {
    const auto quantised = fleet::quantised(fact);
    if (quantised) store.add(std::make_shared<const fleet::Fact>(*quantised));
  }
  fleet::FleetSettings settings;
  if ((mode & 2U) != 0) settings.solve = fleet::SolveWhat::kRounds;
  if ((mode & 4U) != 0) settings.loops.use = false;
  fleet::FleetKnowledge known;
  if ((mode & 8U) == 0) known = fleet.knowledge();
  known.common_clock = (mode & 16U) == 0;
  fleet::RoundCentre centre(settings, known);
  for (const fleet::FactPtr& fact : store.take_new()) centre.add(fact);
  SerialExecutor executor;
  check((mode & 2U) != 0 ? centre.end_round(fleet.now(), executor) : centre.estimate(executor));
  return 0;
}
