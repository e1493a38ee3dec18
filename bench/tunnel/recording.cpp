#include "recording.hpp"

#include <cstdio>
#include <filesystem>

#include <fmt/format.h>
#include <unistd.h>

#include "common/option_hash.hpp"
#include "rali/sim/fleet/vehicle_sensors.hpp"

namespace rali::tunnel {

namespace {

constexpr std::uint64_t kMagic = 0x52414c4954554e31ULL;  // change with the layout or the simulator

struct FileCloser {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

using File = std::unique_ptr<std::FILE, FileCloser>;

/// Header of each scan; plain numbers, so that a struct can be written as its bytes.
struct FileScan {
  std::int64_t number;
  std::int64_t t_start_ns;
  std::uint64_t rays;
};

template <class T>
bool put(std::FILE* file, const T& value) {
  return std::fwrite(&value, sizeof(T), 1, file) == 1;
}

template <class T>
bool get(std::FILE* file, T& value) {
  return std::fread(&value, sizeof(T), 1, file) == 1;
}

sim::FleetOptions without_lidar(const Setup& setup) {
  sim::FleetOptions o = setup.options;
  o.vehicle.with_lidar = false;
  return o;
}

RecordingHead head_of(const sim::FleetSimulation& sim) {
  RecordingHead head;
  head.calibration = sim.calibration_nominal(kDriver);
  head.own_antenna_m = sim.antennas(kDriver).front().p_nominal_m;
  head.peer_antenna_m = sim.antennas(kAnchor).front().p_nominal_m;
  head.T_world_self = sim.truth(kDriver, sim.t_start()).state.T_world_body;
  head.T_world_peer = sim.truth(kAnchor, sim.t_start()).state.T_world_body;
  head.t_start = sim.t_start();
  head.t_end = sim.t_end();
  head.path_m = sim.path_m(kDriver);
  return head;
}

}  // namespace

std::string Recording::file_name() const {
  bench::OptionHash hash;
  bench::add_options(setup_.options.vehicle, hash);
  hash.add(setup_.anchor_arc_m);
  hash.add(setup_.anchor_side_m);
  return fmt::format("fleet_{}_{}_{:016x}.sweeps",
                     sim::kSceneNames[static_cast<std::size_t>(place_.scene)], place_.seed,
                     hash.value());
}

Result<Recording> Recording::make(const Place& place, const std::string& cache_dir) {
  auto setup = make_setup(place);
  if (!setup) return tl::make_unexpected(setup.error());
  Recording recording(place, std::move(*setup));
  std::string path;
  if (!cache_dir.empty()) {
    std::error_code ignored;
    std::filesystem::create_directories(cache_dir, ignored);
    path = cache_dir + "/" + recording.file_name();
    if (recording.load(path)) return recording;
  }
  if (auto ok = recording.cast(); !ok) return tl::make_unexpected(ok.error());
  if (!path.empty()) {
    if (auto ok = recording.save(path); !ok) return tl::make_unexpected(ok.error());
  }
  return recording;
}

/// Only the driver's scans: those of the stationary vehicle are not used.
Status Recording::cast() {
  auto made = sim::make_fleet_simulation(setup_.world, without_lidar(setup_));
  if (!made) return tl::make_unexpected(made.error());
  sim::FleetSimulation& sim = **made;
  sim::MovingScene others;
  others.add_vehicle({}, sim.motion().rover(kAnchor).trajectory());
  sim::VehicleSensors sensors(setup_.options.vehicle, kDriver,
                              sim.motion().rover(kDriver).trajectory(), std::move(others));
  SerialExecutor executor;
  const double end_s = seconds_between(sim.t_start(), sim.t_end());
  scans_.clear();
  while (sensors.next_scan_s() <= end_s) {
    const auto scan = sensors.take_scan(sim.ray_caster(), executor);
    scans_.push_back({scan->t_start, sensors.raw_scan()});
  }
  return {};
}

bool Recording::load(const std::string& path) {
  const File file(std::fopen(path.c_str(), "rb"));
  std::uint64_t magic = 0;
  std::uint64_t count = 0;
  if (!file || !get(file.get(), magic) || magic != kMagic || !get(file.get(), count)) return false;
  const sim::LidarModel model(place_.lidar);
  const auto rays =
      static_cast<std::size_t>(model.rings()) * static_cast<std::size_t>(model.firings());
  scans_.clear();
  for (std::uint64_t i = 0; i < count; ++i) {
    FileScan head{};
    if (!get(file.get(), head) || head.rays != rays) return false;
    Scan scan{Time::from_ns(head.t_start_ns), {}};
    scan.raw.number = head.number;
    scan.raw.range_steps.resize(rays);
    scan.raw.intensity.resize(rays);
    if (std::fread(scan.raw.range_steps.data(), 2, rays, file.get()) != rays ||
        std::fread(scan.raw.intensity.data(), 1, rays, file.get()) != rays) {
      return false;
    }
    scans_.push_back(std::move(scan));
  }
  return true;
}

Status Recording::save(const std::string& path) const {
  // Written under another name first, so that an interrupted run leaves no partial recording.
  const std::string half = fmt::format("{}.{}", path, getpid());
  bool kept = false;
  {
    const File file(std::fopen(half.c_str(), "wb"));
    kept = file && put(file.get(), kMagic) && put(file.get(), std::uint64_t{scans_.size()});
    for (const Scan& s : scans_) {
      const std::size_t n = s.raw.range_steps.size();
      kept = kept && put(file.get(), FileScan{s.raw.number, s.t_start.ns, n}) &&
             std::fwrite(s.raw.range_steps.data(), 2, n, file.get()) == n &&
             std::fwrite(s.raw.intensity.data(), 1, n, file.get()) == n;
    }
    kept = kept && std::fflush(file.get()) == 0;
  }
  std::error_code error;
  if (kept) std::filesystem::rename(half, path, error);
  if (kept && !error) return {};
  std::filesystem::remove(half, error);
  return fail(ErrorCode::kMachine, half, "the cache cannot be written", "Is the disk full?");
}

Status Recording::play(const sim::UwbOptions& uwb, const Listener& listener) const {
  sim::FleetOptions options = without_lidar(setup_);
  options.uwb = uwb;
  auto made = sim::make_fleet_simulation(setup_.world, options);
  if (!made) return tl::make_unexpected(made.error());
  sim::FleetSimulation& sim = **made;
  listener.on_head(head_of(sim));
  const sim::LidarModel model(place_.lidar);
  std::size_t next = 0;
  const auto report_scans_until = [&](Time t) {
    for (; next < scans_.size(); ++next) {
      const Scan& s = scans_[next];
      if (s.t_start + Duration::from_s(model.scan_s()) > t) return;
      auto scan = sim::expand(s.raw, model, options.vehicle.ranging.resolution_m, s.t_start);
      const eval::StampedPose truth{scan->t_end,
                                    sim.truth(kDriver, scan->t_end).state.T_world_body};
      listener.on_scan(std::move(scan), truth);
    }
  };
  while (auto message = sim.next()) {
    if (const auto* range = std::get_if<sensor::RangeSample>(&message->data)) {
      listener.on_range(*range, sim.last_range_truth());
    } else if (const auto* imu = std::get_if<sensor::ImuSample>(&message->data);
               imu != nullptr && message->vehicle == kDriver) {
      report_scans_until(imu->t);
      listener.on_imu(*imu);
    }
  }
  report_scans_until(sim.t_end());
  return {};
}

}  // namespace rali::tunnel
