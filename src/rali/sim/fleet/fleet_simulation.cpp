#include "rali/sim/fleet/fleet_simulation.hpp"

#include <algorithm>
#include <limits>
#include <span>
#include <string>
#include <utility>

#include <fmt/core.h>

#include "rali/base/assert.hpp"
#include "rali/sim/fleet/exchanges.hpp"
#include "rali/sim/fleet/vehicle_sensors.hpp"
#include "rali/sim/internal/range_check.hpp"

namespace rali::sim {

using geometry::Vec3;

namespace {

constexpr double kVehicleRadius_m = 0.3;  // as obstacle of radio signals
constexpr double kVehicleHeight_m = 0.45;
constexpr double kPersonRadius_m = 0.21;
constexpr double kPersonHeight_m = 1.75;

/// Antennas on masts: one behind the LiDAR, or one at each side.
std::vector<AntennaMount> mount_antennas(const FleetOptions& o, int vehicle) {
  Rng rng(vehicle_seed(o.vehicle.seed, vehicle), "antennas");
  std::vector<AntennaMount> mounts;
  for (int i = 0; i < o.antennas; ++i) {
    const double side = o.antennas == 1 ? 0.04 : (i == 0 ? 0.18 : -0.18);
    const Vec3 p(-0.15, side, 0.70);
    mounts.push_back({p, p + o.antenna_error_m * random_direction(rng)});
  }
  return mounts;
}

/// Path along which people walk: the route, else the first path of any vehicle.
std::optional<Route> walk_of(const World& world) {
  if (world.route.size() >= 2) return Route(world.route, world.rounding_m);
  for (const RoundPlan& round : world.rounds) {
    for (const std::vector<Vec3>& path : round.routes) {
      if (path.size() >= 2) return Route(path, world.rounding_m);
    }
  }
  return std::nullopt;
}

}  // namespace

struct FleetSimulation::Impl {
  Impl(World world_in, const FleetOptions& o)
      : options(o),
        world(std::move(world_in)),
        caster(world.mesh),
        walk(walk_of(world)),
        motion(world, o.vehicle.motion, o.vehicles, o.vehicle.seed),
        uwb(o.uwb, o.vehicles, o.vehicle.seed, o.vehicle.start),
        radio(o.radio, o.vehicle.seed),
        ranging(ExchangePlan::of_antennas(o.vehicles, o.antennas, o.ranges ? o.uwb.rate_hz : 0.0)),
        links(ExchangePlan::of_links(o.vehicles, o.radio_link ? o.radio.rate_hz : 0.0)) {
    if (walk) people = Pedestrians(*walk, crowd_of(o.vehicle), world.free_width_m, o.vehicle.seed);
    for (const Escort& escort : o.vehicle.escorts) {
      if (escort.vehicle >= o.vehicles) continue;
      people.add_escort(escort, motion.rover(escort.vehicle).trajectory(),
                        o.vehicle.motion.body_height_m);
    }
    for (int v = 0; v < o.vehicles; ++v) {
      antennas.push_back(mount_antennas(o, v));
      MovingScene others(people);
      for (int k = 0; k < o.vehicles; ++k) {
        if (k != v) others.add_vehicle({}, motion.rover(k).trajectory());
      }
      sensors.emplace_back(o.vehicle, v, motion.rover(v).trajectory(), std::move(others));
    }
  }

  [[nodiscard]] Time time(double t_s) const {
    return options.vehicle.start + Duration::from_s(t_s);
  }

  [[nodiscard]] double reach_s() const {
    const double wished_s = options.vehicle.duration_s;
    return options.scripted && wished_s > 0.0 ? wished_s : motion.time_s();
  }

  [[nodiscard]] RadioEnd end(int vehicle, int antenna, double t_s) const {
    const auto v = static_cast<std::size_t>(vehicle);
    return {vehicle, antenna, motion.rover(vehicle).trajectory().pose_at(t_s),
            antennas[v][static_cast<std::size_t>(antenna)].p_true_m};
  }

  /// All vehicles and persons except the two ends.
  std::span<const RadioBody> bodies_between(int a, int b, double t_s) {
    bodies.clear();
    for (int v = 0; v < options.vehicles; ++v) {
      if (v == a || v == b) continue;
      Vec3 foot = motion.rover(v).trajectory().pose_at(t_s).p;
      foot.z() -= options.vehicle.motion.body_height_m;
      bodies.push_back({foot, kVehicleRadius_m, kVehicleHeight_m});
    }
    people.place_at(t_s);
    for (const Vec3& foot : people.positions()) {
      bodies.push_back({foot, kPersonRadius_m, kPersonHeight_m});
    }
    return bodies;
  }

  std::optional<FleetMessage> exchange_range() {
    const double t_s = ranging.next_s();
    const ExchangePlan::Exchange e = ranging.take();
    const std::optional<sensor::RangeSample> sample =
        uwb.measure(time(t_s), end(e.from, e.from_antenna, t_s), end(e.to, e.to_antenna, t_s),
                    caster, bodies_between(e.from, e.to, t_s));
    if (!sample) return std::nullopt;
    range_truth = uwb.last_truth();
    return FleetMessage{e.from, *sample};
  }

  std::optional<FleetMessage> exchange_radio() {
    const double t_s = links.next_s();
    const ExchangePlan::Exchange e = links.take();
    const std::optional<sensor::RadioSample> sample =
        radio.measure(time(t_s), end(e.from, 0, t_s), end(e.to, 0, t_s), caster,
                      bodies_between(e.from, e.to, t_s));
    if (!sample) return std::nullopt;
    return FleetMessage{e.to, *sample};
  }

  /// The next message. At equal times scans precede inertial samples (as in Simulation), lower
  /// vehicles precede higher ones, and exchanges come last.
  struct Due {
    double t_s = std::numeric_limits<double>::infinity();
    enum class Kind { kScan, kImu, kRange, kRadio } kind = Kind::kScan;
    std::size_t vehicle = 0;
  };

  [[nodiscard]] Due due() const {
    constexpr double kSame_s = 1e-9;
    Due best;
    const auto consider = [&](double t_s, Due::Kind kind, std::size_t vehicle) {
      if (t_s < best.t_s - kSame_s) best = {t_s, kind, vehicle};
    };
    for (std::size_t v = 0; v < sensors.size(); ++v) {
      if (options.vehicle.with_lidar) consider(sensors[v].next_scan_s(), Due::Kind::kScan, v);
      if (options.vehicle.with_imu) consider(sensors[v].next_imu_s(), Due::Kind::kImu, v);
    }
    consider(ranging.next_s(), Due::Kind::kRange, 0);
    consider(links.next_s(), Due::Kind::kRadio, 0);
    return best;
  }

  std::optional<FleetMessage> take(const Due& d) {
    VehicleSensors& s = sensors[d.vehicle];
    const int vehicle = static_cast<int>(d.vehicle);
    switch (d.kind) {
      case Due::Kind::kScan:
        raw = &s;
        return FleetMessage{vehicle, s.take_scan(caster, *executor)};
      case Due::Kind::kImu:
        return FleetMessage{vehicle, s.take_imu()};
      case Due::Kind::kRange:
        return exchange_range();
      case Due::Kind::kRadio:
        return exchange_radio();
    }
    return std::nullopt;
  }

  FleetOptions options;
  World world;
  RayCaster caster;
  std::optional<Route> walk;
  Pedestrians people;
  FleetMotion motion;
  std::vector<std::vector<AntennaMount>> antennas;
  std::vector<VehicleSensors> sensors;
  UwbModel uwb;
  RadioModel radio;
  ExchangePlan ranging, links;
  std::vector<RadioBody> bodies;
  std::vector<RoundTimes> rounds;
  SerialExecutor serial;
  Executor* executor = &serial;
  const VehicleSensors* raw = nullptr;  ///< that made the last scan
  RangeTruth range_truth;
};

FleetSimulation::FleetSimulation(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

FleetSimulation::~FleetSimulation() = default;

std::optional<FleetMessage> FleetSimulation::next() {
  while (true) {
    const Impl::Due due = impl_->due();
    if (due.t_s > impl_->reach_s() + 1e-9) return std::nullopt;
    // Lost exchanges give no message.
    if (std::optional<FleetMessage> message = impl_->take(due)) return message;
  }
}

void FleetSimulation::use(Executor& executor) { impl_->executor = &executor; }

const RawScan& FleetSimulation::last_raw_scan() const {
  RALI_ASSERT(impl_->raw != nullptr);
  return impl_->raw->raw_scan();
}

const RangeTruth& FleetSimulation::last_range_truth() const { return impl_->range_truth; }

Truth FleetSimulation::truth(int vehicle, Time t) const {
  const double t_s = seconds_between(impl_->options.vehicle.start, t);
  return {t, impl_->motion.rover(vehicle).trajectory().at(t_s)};
}

Time FleetSimulation::t_start() const { return impl_->options.vehicle.start; }

Time FleetSimulation::t_end() const { return impl_->time(impl_->reach_s()); }

int FleetSimulation::vehicles() const { return impl_->options.vehicles; }

bool FleetSimulation::scripted() const { return impl_->options.scripted; }

double FleetSimulation::path_m(int vehicle) const {
  return impl_->motion.rover(vehicle).trajectory().length_m();
}

const sensor::Calibration& FleetSimulation::calibration_true(int vehicle) const {
  return impl_->sensors[static_cast<std::size_t>(vehicle)].calibration_true();
}

const sensor::Calibration& FleetSimulation::calibration_nominal(int vehicle) const {
  return impl_->sensors[static_cast<std::size_t>(vehicle)].calibration_nominal();
}

const std::vector<AntennaMount>& FleetSimulation::antennas(int vehicle) const {
  return impl_->antennas[static_cast<std::size_t>(vehicle)];
}

ImuBias FleetSimulation::imu_bias(int vehicle) const {
  const ImuModel& imu = impl_->sensors[static_cast<std::size_t>(vehicle)].imu();
  return {imu.gyro_bias_radps(), imu.accel_bias_mps2()};
}

const LidarModel& FleetSimulation::lidar_model() const {
  return impl_->sensors.front().lidar_model();
}

const UwbModel& FleetSimulation::uwb() const { return impl_->uwb; }

const std::vector<RoundTimes>& FleetSimulation::rounds() const { return impl_->rounds; }

const World& FleetSimulation::world() const { return impl_->world; }

const RayCaster& FleetSimulation::ray_caster() const { return impl_->caster; }

RadioModel& FleetSimulation::radio() { return impl_->radio; }

FleetMotion& FleetSimulation::motion() { return impl_->motion; }

namespace {

Status check_fleet(const World& world, const FleetOptions& o) {
  if (const Status vehicle = check_options(o.vehicle); !vehicle) return vehicle;
  const auto refuse = [](const char* key, std::string what) {
    return fail(ErrorCode::kUsage, key, std::move(what),
                "`rali simulate --help` lists the ranges.");
  };
  if (o.vehicles < 1 || o.vehicles > kVehiclesMax) {
    return refuse("vehicles", fmt::format("is {}, not 1 to {}", o.vehicles, kVehiclesMax));
  }
  if (o.antennas < 1 || o.antennas > 2) return refuse("antennas", "is neither 1 nor 2");
  FleetOptions ranges = o;
  RangeCheck check;
  ranges.visit(check);
  if (!check.bad.empty()) return refuse(check.bad.c_str(), "is outside its range");
  if (static_cast<int>(world.starts.size()) < o.vehicles) {
    return fail(
        ErrorCode::kUsage, "vehicles",
        fmt::format("the world has {} starts for {} vehicles", world.starts.size(), o.vehicles),
        "Give a start for each vehicle, or ask for fewer vehicles.");
  }
  if (world.mesh.triangles.empty()) {
    return fail(ErrorCode::kUsage, "mesh", "has no triangle", "Give the world a surface.");
  }
  return {};
}

}  // namespace

Result<std::unique_ptr<FleetSimulation>> make_fleet_simulation(World world,
                                                               const FleetOptions& options) {
  if (const Status checked = check_fleet(world, options); !checked) {
    return tl::make_unexpected(checked.error());
  }
  FleetOptions o = options;
  // Vehicles that drive to goals through doors must not swing laterally.
  constexpr double kSwing_m = 0.04;
  if (!o.scripted) o.vehicle.motion.wander_m = std::min(o.vehicle.motion.wander_m, kSwing_m);
  auto impl = std::make_unique<FleetSimulation::Impl>(std::move(world), o);
  if (options.scripted) {
    Result<std::vector<RoundTimes>> rounds = drive_rounds(
        impl->motion, impl->world, options.vehicle.motion.standstill_s, options.pause_s);
    if (!rounds) return tl::make_unexpected(rounds.error());
    impl->rounds = std::move(*rounds);
  }
  return std::unique_ptr<FleetSimulation>(new FleetSimulation(std::move(impl)));
}

}  // namespace rali::sim
