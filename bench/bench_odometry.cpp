// Preset robust: cost of each stage of one scan on one core, and of the whole scan.
//
// The data are simulated on first use (a few seconds) and are the same in every run.
#include <map>
#include <memory>
#include <vector>

#include <benchmark/benchmark.h>

#include "rali/degeneracy/information.hpp"
#include "rali/odometry/paper/planar_features.hpp"
#include "rali/odometry/robust/keyframer.hpp"
#include "rali/odometry/robust/scan_sampler.hpp"
#include "rali/odometry/robust/update.hpp"
#include "rali/sim/simulation.hpp"
#include "rali/vehicle/vehicle.hpp"

namespace {

using namespace rali;
using geometry::SE3;
using geometry::Vec3;
using odometry::BodyPoints;
using odometry::ScanMotion;

/// One scan with the true poses of the body during it.
struct Scan {
  std::shared_ptr<const sensor::LidarScan> scan;
  std::vector<odometry::TimedPose> poses;

  [[nodiscard]] const SE3& pose() const { return poses.back().T_odom_body; }
};

struct Recording {
  sensor::Calibration calibration;
  std::vector<vehicle::Event> events;
  std::vector<Scan> scans;
};

enum Place { kLoopRs16, kGarageRs16, kFloorHdl64, kPlaces };

constexpr const char* kPlaceNames[kPlaces] = {"loop_rs16", "garage_rs16", "floor_hdl64e"};

sim::SimOptions options_of(Place place) {
  sim::SimOptions o;
  o.motion.standstill_s = 1.5;
  o.duration_s = place == kFloorHdl64 ? 5.0 : 10.0;
  o.scene = place == kLoopRs16     ? sim::Scene::kLoop
            : place == kGarageRs16 ? sim::Scene::kGarage
                                   : sim::Scene::kFloor;
  o.lidar = place == kFloorHdl64 ? sim::Lidar::kHdl64e : sim::Lidar::kRs16;
  return o;
}

Recording record(const sim::SimOptions& options) {
  const auto sim = sim::make_simulation(options).value();
  Recording out;
  out.calibration = sim->calibration_nominal();
  while (auto message = sim->next()) {
    if (const auto* imu = std::get_if<sensor::ImuSample>(&*message)) {
      out.events.emplace_back(*imu);
      continue;
    }
    Scan scan{std::get<std::shared_ptr<const sensor::LidarScan>>(*message), {}};
    const double span_s = (scan.scan->t_end - scan.scan->t_start).s();
    for (int k = 0; k <= 20; ++k) {
      const Time t =
          k == 20 ? scan.scan->t_end : scan.scan->t_start + Duration::from_s(k * span_s / 20);
      scan.poses.push_back({t, sim->truth(t).state.T_world_body});
    }
    out.events.emplace_back(scan.scan);
    out.scans.push_back(std::move(scan));
  }
  out.events.emplace_back(vehicle::EndOfData{});
  return out;
}

const Recording& recording(Place place) {
  static std::map<Place, Recording> made;
  const auto it = made.find(place);
  return it != made.end() ? it->second
                          : made.emplace(place, record(options_of(place))).first->second;
}

/// Input of the stages: the map of all scans but the last, and the last scan.
struct Stage {
  explicit Stage(Place place)
      : place_data(recording(place)), sampler(settings.sampling), map(settings.map) {
    last = &place_data.scans.back();
    for (const Scan& scan : place_data.scans) {
      sampler.sample(*scan.scan);
      motion_of(scan).apply(*scan.scan, sampler.insert_indices(), points);
      if (&scan != last) insert(map, scan.pose());
    }
    motion_of(*last).apply(*last->scan, sampler.update_indices(), points);
    state.t = last->scan->t_end;
    state.T_odom_body = last->pose();
    state.P.diagonal().setConstant(1e-4);
  }

  [[nodiscard]] ScanMotion motion_of(const Scan& scan) const {
    return {scan.poses, scan.scan->t_start, place_data.calibration.T_body_lidar};
  }

  void insert(odometry::PlaneMap& to, const SE3& T) const {
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vec3 p(points.x_m[i], points.y_m[i], points.z_m[i]);
      const Vec3 ray = (T.R * (p - place_data.calibration.T_body_lidar.p)).normalized();
      to.insert(T * p, ray.cast<float>(), 0.0);
    }
  }

  [[nodiscard]] odometry::Matcher matched() const {
    odometry::Matcher matcher(settings.match);
    matcher.set_points(points, place_data.calibration.T_body_lidar.p);
    matcher.match(map, state.T_odom_body, prior(), odometry::Reach::kPoints);
    return matcher;
  }

  [[nodiscard]] geometry::Mat6 prior() const { return state.P.topLeftCorner<6, 6>(); }

  const Recording& place_data;
  const Scan* last = nullptr;
  odometry::RobustSettings settings;
  odometry::ScanSampler sampler;  ///< state after the last scan
  odometry::PlaneMap map;
  BodyPoints points;  ///< registration points of the last scan
  odometry::FilterState state;
};

const Stage& stage(const benchmark::State& state) {
  static std::map<Place, Stage> made;
  const auto place = static_cast<Place>(state.range(0));
  return made.try_emplace(place, place).first->second;
}

void label(benchmark::State& state) { state.SetLabel(kPlaceNames[state.range(0)]); }

/// Items are scans: 1 / items_per_second is the cost of one scan.
void vehicle_scans(benchmark::State& state) {
  const Recording& r = recording(static_cast<Place>(state.range(0)));
  vehicle::VehicleSettings settings;
  settings.calibration = r.calibration;
  SerialExecutor executor;
  for (auto _ : state) {
    vehicle::Vehicle v(VehicleId{1}, settings);
    vehicle::OutputList out;
    for (const vehicle::Event& event : r.events) {
      v.step(event, executor, out);
      out.clear();
    }
    benchmark::DoNotOptimize(v.state_hash());
  }
  const auto scans = static_cast<double>(r.scans.size());
  state.counters["per_sweep"] =
      benchmark::Counter(scans * static_cast<double>(state.iterations()),
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
  label(state);
}

void sample(benchmark::State& state) {
  const Stage& s = stage(state);
  odometry::ScanSampler sampler = s.sampler;
  for (auto _ : state) {
    sampler.sample(*s.last->scan);
    benchmark::DoNotOptimize(sampler.update_indices().data());
  }
  state.counters["points"] = static_cast<double>(s.last->scan->size());
  state.counters["insert"] = static_cast<double>(sampler.insert_indices().size());
  state.counters["update"] = static_cast<double>(sampler.update_indices().size());
  label(state);
}

void deskew(benchmark::State& state) {
  const Stage& s = stage(state);
  BodyPoints out;
  for (auto _ : state) {
    s.motion_of(*s.last).apply(*s.last->scan, s.sampler.insert_indices(), out);
    benchmark::DoNotOptimize(out.x_m.data());
  }
  state.counters["points"] = static_cast<double>(out.size());
  label(state);
}

void deskew_all(benchmark::State& state) {
  const Stage& s = stage(state);
  BodyPoints out;
  for (auto _ : state) {
    s.motion_of(*s.last).apply(*s.last->scan, {}, out);
    benchmark::DoNotOptimize(out.x_m.data());
  }
  state.counters["points"] = static_cast<double>(out.size());
  label(state);
}

void map_insert(benchmark::State& state) {
  const Stage& s = stage(state);
  Stage other = s;  // for its points
  other.motion_of(*s.last).apply(*s.last->scan, s.sampler.insert_indices(), other.points);
  odometry::PlaneMap map = s.map;
  for (auto _ : state) {
    state.PauseTiming();
    map = s.map;
    state.ResumeTiming();
    other.insert(map, s.last->pose());
    benchmark::DoNotOptimize(map.root_count());
  }
  state.counters["points"] = static_cast<double>(other.points.size());
  state.counters["roots"] = static_cast<double>(s.map.root_count());
  state.counters["planes"] = static_cast<double>(s.map.plane_count());
  label(state);
}

void map_find(benchmark::State& state) {
  const Stage& s = stage(state);
  std::vector<Vec3> odom;
  for (std::size_t i = 0; i < s.points.size(); ++i) {
    odom.push_back(s.last->pose() * Vec3(s.points.x_m[i], s.points.y_m[i], s.points.z_m[i]));
  }
  const bool near = state.range(1) != 0;
  int found = 0;
  for (auto _ : state) {
    found = 0;
    for (const Vec3& p : odom) found += (near ? s.map.find_near(p) : s.map.find(p)) >= 0 ? 1 : 0;
    benchmark::DoNotOptimize(found);
  }
  state.counters["points"] = static_cast<double>(odom.size());
  state.counters["found"] = found;
  label(state);
}

void map_prune(benchmark::State& state) {
  const Stage& s = stage(state);
  odometry::PlaneMapSettings settings = s.settings.map;
  settings.roots_max = 1000;
  settings.keep_radius_m = 10.0;
  odometry::PlaneMap full(settings);
  s.insert(full, s.last->pose());
  for (const Scan& scan : s.place_data.scans) s.insert(full, scan.pose());
  odometry::PlaneMap map = full;
  for (auto _ : state) {
    state.PauseTiming();
    map = full;
    state.ResumeTiming();
    benchmark::DoNotOptimize(map.prune(s.last->pose().p));
  }
  state.counters["roots"] = static_cast<double>(full.root_count());
  state.counters["kept"] = static_cast<double>(map.root_count());
  label(state);
}

void match(benchmark::State& state) {
  const Stage& s = stage(state);
  odometry::Matcher matcher(s.settings.match);
  for (auto _ : state) {
    matcher.set_points(s.points, s.place_data.calibration.T_body_lidar.p);
    matcher.match(s.map, s.state.T_odom_body, s.prior(), odometry::Reach::kPoints);
  }
  state.counters["points"] = static_cast<double>(s.points.size());
  label(state);
}

void accumulate(benchmark::State& state) {
  const Stage& s = stage(state);
  odometry::Matcher matcher = s.matched();
  int matches = 0;
  for (auto _ : state) {
    const odometry::LidarSystem system = matcher.accumulate(s.map, s.state.T_odom_body);
    matches = system.matches;
    benchmark::DoNotOptimize(system.I.data());
  }
  state.counters["matches"] = matches;
  state.counters["planes"] = static_cast<double>(matcher.evidence().size());
  label(state);
}

void detector(benchmark::State& state) {
  const Stage& s = stage(state);
  odometry::Matcher matcher = s.matched();
  const odometry::LidarSystem system = matcher.accumulate(s.map, s.state.T_odom_body);
  const Vec3 g(0.0, 0.0, -9.81);
  const auto& R = s.state.T_odom_body.R;
  for (auto _ : state) {
    geometry::Mat6 I = system.I;
    geometry::Vec6 b = system.b;
    const auto axes =
        degeneracy::physical_axes(I, g, R, degeneracy::Axes::Identity(), s.settings.aware);
    const auto directions =
        degeneracy::direction_information(I, matcher.evidence(), R, axes, s.settings.aware);
    degeneracy::remove_spurious(I, b, R, directions);
    benchmark::DoNotOptimize(I.data());
  }
  state.counters["planes"] = static_cast<double>(matcher.evidence().size());
  label(state);
}

void update(benchmark::State& state) {
  const Stage& s = stage(state);
  odometry::Matcher matcher(s.settings.match);
  odometry::UpdateResult done;
  for (auto _ : state) {
    odometry::FilterState x = s.state;
    x.T_odom_body.p += Vec3(0.01, -0.01, 0.005);
    matcher.set_points(s.points, s.place_data.calibration.T_body_lidar.p);
    done = odometry::update_with_scan(x, matcher, s.map, x.T_odom_body, s.settings,
                                      degeneracy::Axes::Identity(), {}, false);
    benchmark::DoNotOptimize(x.P.data());
  }
  state.counters["iterations"] = done.iterations;
  state.counters["matches"] = done.matches;
  label(state);
}

void keyframe(benchmark::State& state) {
  const Stage& s = stage(state);
  BodyPoints all;
  s.motion_of(*s.last).apply(*s.last->scan, {}, all);
  odometry::Keyframer keyframer(s.settings.keyframe);
  odometry::ScanResult result;
  std::size_t kept = 0;
  for (auto _ : state) {
    const auto made =
        keyframer.make(*s.last->scan, all, result, s.place_data.calibration.T_body_lidar);
    kept = made->cloud.size();
    benchmark::DoNotOptimize(kept);
  }
  state.counters["kept"] = static_cast<double>(kept);
  label(state);
}

/// The features of the paper's detector, which runs beside the odometry.
void paper_features(benchmark::State& state) {
  const Stage& s = stage(state);
  odometry::paper::PlanarFeatureExtractor extractor;
  odometry::paper::PlanarFeatures features;
  for (auto _ : state) {
    extractor.extract(odometry::paper::view_of(*s.last->scan), {}, features);
    benchmark::DoNotOptimize(features.nx.data());
  }
  state.counters["features"] = static_cast<double>(features.size());
  label(state);
}

constexpr auto kEverywhere = [](auto* b) {
  for (int place = 0; place < kPlaces; ++place) b->Arg(place);
  b->Unit(benchmark::kMicrosecond);
};

BENCHMARK(vehicle_scans)->DenseRange(0, kPlaces - 1)->Unit(benchmark::kMillisecond);
BENCHMARK(sample)->Apply(kEverywhere);
BENCHMARK(deskew)->Apply(kEverywhere);
BENCHMARK(deskew_all)->Apply(kEverywhere);
BENCHMARK(map_insert)->Apply(kEverywhere);
BENCHMARK(map_find)->ArgsProduct({{0, 1, 2}, {0, 1}})->Unit(benchmark::kMicrosecond);
BENCHMARK(map_prune)->Apply(kEverywhere);
BENCHMARK(match)->Apply(kEverywhere);
BENCHMARK(accumulate)->Apply(kEverywhere);
BENCHMARK(detector)->Apply(kEverywhere);
BENCHMARK(update)->Apply(kEverywhere);
BENCHMARK(keyframe)->Apply(kEverywhere);
BENCHMARK(paper_features)->Apply(kEverywhere);

}  // namespace

BENCHMARK_MAIN();
