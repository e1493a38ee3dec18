#include "case.hpp"

#include <cmath>

#include <fmt/format.h>

#include "rali/sim/lidar_model.hpp"

namespace rali::campaign {

using sim::FleetOptions;
using sim::SimOptions;

namespace {

/// Draws the groups of a case one after the other. Each has its own random stream, so that widening
/// one range does not change draws of the others.
class Draw {
 public:
  Draw(const Ranges& ranges, std::uint64_t seed) : ranges_(ranges) { case_.seed = seed; }

  Case run() {
    place();
    motion();
    inertial();
    calibration();
    people();
    dropouts();
    if (vehicles() > 1) fleet();
    return std::move(case_);
  }

 private:
  [[nodiscard]] int vehicles() const { return case_.setup.fleet.vehicles; }

  [[nodiscard]] Rng stream(const char* name) const { return Rng(case_.seed, name); }

  [[nodiscard]] SimOptions& options() { return case_.setup.fleet.vehicle; }

  void has(const std::string& feature) { case_.features.insert(feature); }

  void place();
  void tunnel(Rng& rng, bool pieces);
  void motion();
  void inertial();
  void shaking(Rng& rng);
  void calibration();
  void people();
  void dropouts();
  void fleet();
  void radios();
  void range_faults();
  void priors();
  [[nodiscard]] Span span(const char* key, Rng& rng) const;

  const Ranges& ranges_;
  Case case_;
};

void Draw::place() {
  Rng rng = stream("place");
  const Ranges& r = ranges_;
  case_.scene = r.choice("scenes", rng);
  case_.duration_s = r.number("duration_s", rng);
  scenario::SceneSetup& setup = case_.setup;
  setup.fleet.vehicles = std::stoi(r.choice("vehicles", rng));
  options().seed = case_.seed;
  options().duration_s = case_.duration_s;
  options().lidar = sim::lidar_of(r.choice("lidars", rng)).value();
  options().ranging = sim::LidarOptions::of(options().lidar);
  options().ranging.noise_m = r.number("lidar_noise_m", rng);
  Rng lasers = stream("lasers");
  options().ranging.laser_offset_m = r.number("laser_offset_m", lasers);
  options().ranging.laser_elevation_deg = r.number("laser_elevation_deg", lasers);
  if (case_.scene == "tunnel" || case_.scene == "tunnel_pieces") {
    tunnel(rng, case_.scene == "tunnel_pieces");
  } else {
    setup.place = scenario::PlaceKind::kScene;
    setup.scene = sim::scene_of(case_.scene).value();
    options().scene = setup.scene;
  }
  if (r.happens("lidar_only", rng)) {
    options().with_imu = false;
    has("lidar only");
  }
  has("scene " + case_.scene);
  has(fmt::format("{} vehicles", vehicles()));
}

void Draw::tunnel(Rng& rng, bool pieces) {
  const Ranges& r = ranges_;
  case_.setup.place = scenario::PlaceKind::kTunnel;
  sim::TunnelOptions& t = case_.setup.tunnel;
  t.length_m = r.number("tunnel.length_m", rng);
  t.width_m = r.number("tunnel.width_m", rng);
  t.wall_height_m = r.number("tunnel.wall_height_m", rng);
  t.roughness_m = r.number("tunnel.roughness_m", rng);
  if (pieces) {
    t.segment_m = r.number("tunnel.segment_m", rng);
    t.segment_curvature_per_m = r.number("tunnel.segment_curvature_per_m", rng);
    t.segment_gradient = r.number("tunnel.segment_gradient", rng);
  } else {
    t.curvature_per_m = r.number("tunnel.curvature_per_m", rng);
  }
  t.closed_ends = rng.uniform() < 0.3;
  if (r.happens("tunnel.cabinet", rng)) {
    t.cabinet_every_m = r.number("tunnel.cabinet_every_m", rng);
    has("cabinets");
  }
  if (r.happens("tunnel.niche", rng)) t.niche_every_m = r.number("tunnel.niche_every_m", rng);
}

void Draw::motion() {
  Rng rng = stream("motion");
  const Ranges& r = ranges_;
  sim::MotionOptions& m = options().motion;
  m.speed_mps = r.number("motion.speed_mps", rng);
  m.acceleration_mps2 = r.number("motion.acceleration_mps2", rng);
  m.yaw_rate_max_radps = r.number("motion.yaw_rate_max_radps", rng);
  m.suspension = r.number("motion.suspension", rng);
  m.wander_m = r.number("motion.wander_m", rng);
  m.standstill_s = std::max(0.5, r.number("motion.standstill_s", rng));
  case_.in_motion = r.happens("motion.in_motion", rng);
  case_.in_turn = case_.in_motion && r.happens("motion.in_turn", rng);
  if (case_.in_motion) has(case_.in_turn ? "starts in a turn" : "starts in motion");
  if (m.speed_mps < 0.4) has("slow");
  if (m.speed_mps > 1.8) has("fast");
}

void Draw::inertial() {
  if (!case_.has_imu()) return;
  Rng rng = stream("imu");
  const Ranges& r = ranges_;
  sim::ImuOptions& imu = options().imu;
  imu.rate_hz = r.number("imu.rate_hz", rng);
  imu.accel_mps2_rthz = r.number("imu.accel_mps2_rthz", rng);
  imu.gyro_radps_rthz = r.number("imu.gyro_radps_rthz", rng);
  imu.accel_bias_mps2 = r.number("imu.accel_bias_mps2", rng);
  imu.gyro_bias_radps = r.number("imu.gyro_bias_radps", rng);
  imu.accel_walk_mps3_rthz = r.number("imu.accel_walk_mps3_rthz", rng);
  imu.gyro_walk_radps2_rthz = r.number("imu.gyro_walk_radps2_rthz", rng);
  if (r.happens("imu.noise_given", rng)) {
    const double accel = r.number("imu.true_to_claimed", rng);
    const double gyro = r.number("imu.true_to_claimed", rng);
    case_.noise = ClaimedNoise{imu.accel_mps2_rthz / accel, imu.gyro_radps_rthz / gyro};
    if (std::max(accel, gyro) > 5.0) has("noise claimed too small");
    if (std::min(accel, gyro) < 0.3) has("noise claimed too large");
  }
  shaking(rng);
  if (r.happens("imu.saturation", rng)) {
    imu.accel_limit_mps2 = r.number("imu.accel_limit_mps2", rng);
    imu.gyro_limit_radps = r.number("imu.gyro_limit_radps", rng);
    has("imu saturates");
  }
  imu.scale_error = r.number("imu.scale_error", rng);
  imu.misalignment_deg = r.number("imu.misalignment_deg", rng);
}

void Draw::shaking(Rng& rng) {
  const Ranges& r = ranges_;
  sim::ImuOptions& imu = options().imu;
  imu.vibration_accel_mps2 = r.number("imu.vibration_accel_mps2", rng);
  imu.vibration_gyro_radps = r.number("imu.vibration_gyro_radps", rng);
  if (r.happens("imu.resonance", rng)) {
    imu.resonance_accel_mps2 = r.number("imu.resonance_accel_mps2", rng);
    imu.resonance_gyro_radps = r.number("imu.resonance_gyro_radps", rng);
    imu.resonance_low_hz = r.number("imu.resonance_low_hz", rng);
    imu.resonance_high_hz = r.number("imu.resonance_high_hz", rng);
    has("resonances");
  }
  if (!r.happens("imu.jolts", rng)) return;
  sim::JoltOptions& jolts = options().motion.jolts;
  jolts.joint_every_m = r.number("imu.joint_every_m", rng);
  jolts.joint_m = r.number("imu.joint_m", rng);
  jolts.slip_every_m = r.number("imu.slip_every_m", rng);
  jolts.slip_m = r.number("imu.slip_m", rng);
  jolts.step_s = r.number("imu.step_s", rng);
  jolts.measured_ratio = r.number("imu.measured_ratio", rng);
  has("jolts");
}

void Draw::calibration() {
  Rng rng = stream("calibration");
  const Ranges& r = ranges_;
  options().calibration_error_m = r.number("calibration.error_m", rng);
  options().calibration_error_deg = r.number("calibration.error_deg", rng);
  options().imu_apart = rng.uniform() < 0.5;
  if (case_.has_imu() && r.happens("calibration.time_offset", rng)) {
    case_.time_offset_s = r.number("calibration.time_offset_s", rng);
    options().imu.time_offset_s = case_.time_offset_s;
    has("time offset");
  }
}

void Draw::people() {
  Rng rng = stream("people");
  const Ranges& r = ranges_;
  SimOptions& o = options();
  if (r.happens("people.walking", rng)) o.pedestrians = r.count("people.walking_count", rng);
  if (r.happens("people.standing", rng)) o.standing_people = r.count("people.standing_count", rng);
  if (r.happens("people.crossing", rng)) o.crossing_people = r.count("people.crossing_count", rng);
  if (o.pedestrians > 0) has("people walk");
  if (o.standing_people > 0) has("people stand");
  if (o.crossing_people > 0) has("people cross");
  if (!r.happens("people.escort", rng)) return;
  const int count = r.count("people.escort_count", rng);
  for (int i = 0; i < count; ++i) {
    sim::Escort e;
    e.vehicle = static_cast<int>(rng.below(static_cast<std::uint64_t>(vehicles())));
    e.gap_m = r.number("people.escort_gap_m", rng);
    if (r.happens("people.escort_behind", rng)) e.gap_m = -e.gap_m;
    e.side_m = r.number("people.escort_side_m", rng);
    e.start_s = r.number("people.escort_begin_s", rng);
    e.end_s = e.start_s + r.number("people.escort_span_s", rng);
    e.cart = r.happens("people.escort_cart", rng);
    has(e.cart ? "a cart keeps its distance" : "somebody walks along");
    o.escorts.push_back(e);
  }
}

Span Draw::span(const char* key, Rng& rng) const {
  const double length_s = ranges_.number(key, rng);
  const double start_s = rng.uniform(5.0, std::max(6.0, case_.duration_s - length_s));
  return {start_s, start_s + length_s};
}

void Draw::dropouts() {
  Rng rng = stream("dropouts");
  if (ranges_.happens("dropouts.lidar", rng)) {
    case_.lidar_missing.push_back(span("dropouts.lidar_s", rng));
    has("lidar drops out");
  }
  if (case_.has_imu() && ranges_.happens("dropouts.imu", rng)) {
    case_.imu_missing.push_back(span("dropouts.imu_s", rng));
    has("imu drops out");
  }
  Rng dust = stream("cover");  // its own: the recordings of earlier blocks stay the same otherwise
  if (ranges_.happens("dropouts.cover", dust)) {
    case_.lidar_covered.push_back(span("dropouts.cover_s", dust));
    has("lidar covered");
  }
}

void Draw::fleet() {
  Rng rng = stream("fleet");
  const Ranges& r = ranges_;
  FleetOptions& o = case_.setup.fleet;
  case_.plan = r.choice("fleet.plan", rng);
  has("plan " + case_.plan);
  o.pause_s = r.number("fleet.pause_s", rng);
  o.antenna_error_m = r.number("fleet.antenna_error_m", rng);
  o.ranges = r.happens("fleet.ranges", rng);
  o.radio_link = false;
  if (o.ranges) {
    radios();
    range_faults();
  }
  priors();
}

void Draw::radios() {
  Rng rng = stream("radios");
  const Ranges& r = ranges_;
  sim::UwbOptions& uwb = case_.setup.fleet.uwb;
  uwb.rate_hz = r.number("ranges.rate_hz", rng);
  uwb.sigma_m = r.number("ranges.sigma_m", rng);
  uwb.pair_bias_m = r.number("ranges.pair_bias_m", rng);
  uwb.pair_bias_sd_m = r.number("ranges.pair_bias_sd_m", rng);
  uwb.slow_sigma_m = r.number("ranges.slow_sigma_m", rng);
  uwb.clear_burst_fraction = r.number("ranges.clear_burst_fraction", rng);
  uwb.outlier_fraction = r.number("ranges.outlier_fraction", rng);
  uwb.stamp_offset_s = r.number("ranges.stamp_offset_s", rng);
}

void Draw::range_faults() {
  Rng rng = stream("range faults");
  const Ranges& r = ranges_;
  RangeFaults& f = case_.ranges;
  if (r.happens("dropouts.ranges", rng)) {
    f.missing.push_back(span("dropouts.ranges_s", rng));
    has("ranges drop out");
  }
  if (r.happens("ranges.late", rng)) {
    f.stamp_shift_s = r.number("ranges.late_s", rng);
    has("ranges late");
  } else if (r.happens("ranges.early", rng)) {
    f.stamp_shift_s = -r.number("ranges.early_s", rng);
    has("ranges early");
  }
  if (r.happens("ranges.frozen", rng)) {
    f.frozen.push_back(span("ranges.frozen_s", rng));
    has("ranges frozen");
  }
  if (r.happens("ranges.biased", rng)) {
    f.biased.push_back(span("ranges.biased_s", rng));
    f.biased_m = r.number("ranges.biased_m", rng);
    has("ranges biased");
  }
  if (r.happens("ranges.obstructed", rng)) {
    f.obstructed.push_back(span("ranges.obstructed_s", rng));
    f.obstructed_m = r.number("ranges.obstructed_m", rng);
    has("ranges obstructed");
  }
}

void Draw::priors() {
  Rng rng = stream("priors");
  const Ranges& r = ranges_;
  case_.prior_kind = r.choice("priors.kind", rng);
  has("priors " + case_.prior_kind);
  if (case_.prior_kind == "none") return;
  for (int v = 1; v < vehicles(); ++v) {
    GivenPrior p;
    p.vehicle = v;
    if (r.happens("priors.reversed", rng)) {
      std::swap(p.vehicle, p.relative_to);
      has("prior reversed");
    }
    p.sigma_m = r.number("priors.sigma_m", rng);
    p.sigma_deg = r.number("priors.sigma_deg", rng);
    for (double& x : p.error_m) x = p.sigma_m * rng.normal();
    p.error_m.z() *= 0.3;
    p.error_deg = p.sigma_deg * rng.normal();
    if (case_.prior_kind == "wrong") {
      const double heading = rng.uniform(0.0, 6.283185307179586);
      p.error_m += r.number("priors.wrong_m", rng) *
                   geometry::Vec3(std::cos(heading), std::sin(heading), 0.0);
      if (rng.uniform() < 0.5) {
        p.error_deg += (rng.uniform() < 0.5 ? -1.0 : 1.0) * r.number("priors.wrong_deg", rng);
      }
    }
    case_.priors.push_back(p);
  }
}

}  // namespace

Case draw_case(const Ranges& ranges, std::uint64_t seed) { return Draw(ranges, seed).run(); }

}  // namespace rali::campaign
