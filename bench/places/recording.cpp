#include "recording.hpp"

#include <cstdio>
#include <filesystem>
#include <memory>

#include <fmt/format.h>

#include "rali/cloud/voxel_sampler.hpp"
#include "rali/odometry/make_odometry.hpp"
#include "rali/sim/fleet/fleet_simulation.hpp"

namespace rali::recognition {

using geometry::SE3;
using geometry::Vec3;

namespace {

constexpr double kSpacing_m = 0.2;  // of the points that vehicles send
constexpr std::uint64_t kMagic = 0x52414c49504c4333ULL;

struct FileCloser {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

using File = std::unique_ptr<std::FILE, FileCloser>;

template <class T>
bool put(std::FILE* file, const T& value) {
  return std::fwrite(&value, sizeof(T), 1, file) == 1;
}

template <class T>
bool get(std::FILE* file, T& value) {
  return std::fread(&value, sizeof(T), 1, file) == 1;
}

struct FileHead {
  KeyframeId id;
  SE3 T_odom_body, T_world_body, T_body_lidar;
  Vec3 up_body;
  std::uint64_t points;
};

Kept thinned(const odometry::Keyframe& k, KeyframeId id, const Vec3& g_odom, const SE3& truth) {
  const SE3 T_lidar_body = k.T_body_lidar.inverse();
  const odometry::KeyframeCloud& c = k.cloud;
  std::vector<float> x(c.size()), y(c.size()), z(c.size());
  for (std::size_t i = 0; i < c.size(); ++i) {
    const Vec3 p = T_lidar_body * Vec3(c.x_m[i], c.y_m[i], c.z_m[i]);
    x[i] = static_cast<float>(p.x());
    y[i] = static_cast<float>(p.y());
    z[i] = static_cast<float>(p.z());
  }
  std::vector<std::uint32_t> chosen;
  cloud::VoxelSampler().sample_rays({x.data(), y.data(), z.data(), x.size()}, {}, kSpacing_m,
                                    chosen);
  Kept out;
  out.id = id;
  out.T_odom_body = k.T_odom_body;
  out.T_world_body = truth;
  out.T_body_lidar = k.T_body_lidar;
  out.up_body = k.T_odom_body.R.transpose() * -g_odom.normalized();
  for (const std::uint32_t i : chosen) {
    out.x_m.push_back(c.x_m[i]);
    out.y_m.push_back(c.y_m[i]);
    out.z_m.push_back(c.z_m[i]);
  }
  return out;
}

/// Input and state of one odometry.
struct Rover {
  int source = 0;  ///< vehicle of the simulation
  Time begin, end;
  std::unique_ptr<odometry::Odometry> odometry;
  std::uint32_t made = 0;

  [[nodiscard]] bool sees(int vehicle, Time from, Time until) const {
    return vehicle == source && from >= begin && until <= end;
  }
};

std::vector<Rover> rovers_of(const sim::FleetSimulation& fleet, const RecordOptions& o) {
  constexpr double kFirstUntil = 0.6, kSecondFrom = 0.4;
  const Time begin = fleet.t_start(), end = fleet.t_end();
  const auto at = [&](double fraction) {
    return begin + Duration::from_s(fraction * seconds_between(begin, end));
  };
  std::vector<Rover> rovers(static_cast<std::size_t>(o.halves ? 2 : o.vehicles));
  for (std::size_t k = 0; k < rovers.size(); ++k) {
    rovers[k].source = o.halves ? 0 : static_cast<int>(k);
    rovers[k].begin = o.halves && k == 1 ? at(kSecondFrom) : begin;
    rovers[k].end = o.halves && k == 0 ? at(kFirstUntil) : end;
    rovers[k].odometry =
        odometry::make_odometry({}, fleet.calibration_nominal(rovers[k].source), true);
  }
  return rovers;
}

Result<std::vector<Kept>> drive(const RecordOptions& o) {
  const int vehicles = o.halves ? 1 : o.vehicles;
  const auto world = sim::world_for(sim::make_world(o.scene, o.seed), vehicles);
  if (!world) return tl::make_unexpected(world.error());
  sim::FleetOptions options;
  options.vehicle.seed = o.seed;
  options.vehicle.lidar = o.lidar;
  options.vehicle.ranging = sim::LidarOptions::of(o.lidar);
  options.vehicle.pedestrians = o.pedestrians;
  options.vehicle.duration_s = o.duration_s;
  options.vehicles = vehicles;
  options.ranges = options.radio_link = false;
  auto made = sim::make_fleet_simulation(*world, options);
  if (!made) return tl::make_unexpected(made.error());
  sim::FleetSimulation& fleet = **made;
  std::vector<Rover> rovers = rovers_of(fleet, o);
  SerialExecutor serial;
  FindingList findings;
  std::vector<Kept> out;
  while (auto message = fleet.next()) {
    for (std::size_t r = 0; r < rovers.size(); ++r) {
      Rover& rover = rovers[r];
      if (const auto* imu = std::get_if<sensor::ImuSample>(&message->data)) {
        if (rover.sees(message->vehicle, imu->t, imu->t)) rover.odometry->add_imu(*imu);
      } else if (const auto* scan =
                     std::get_if<std::shared_ptr<const sensor::LidarScan>>(&message->data)) {
        if (!rover.sees(message->vehicle, (*scan)->t_start, (*scan)->t_end)) continue;
        const auto result = rover.odometry->process(**scan, serial, findings);
        if (!result.keyframe) continue;
        const KeyframeId id{{static_cast<std::uint16_t>(r)}, rover.made++};
        out.push_back(thinned(*result.keyframe, id, rover.odometry->gravity_odom(),
                              fleet.truth(message->vehicle, result.t).state.T_world_body));
      }
    }
  }
  return out;
}

bool load(const std::string& path, std::vector<Kept>& out) {
  const File file(std::fopen(path.c_str(), "rb"));
  std::uint64_t magic = 0, n = 0;
  if (!file || !get(file.get(), magic) || magic != kMagic || !get(file.get(), n)) return false;
  for (std::uint64_t k = 0; k < n; ++k) {
    FileHead h;
    if (!get(file.get(), h) || h.points > 1'000'000) return false;
    Kept kept{h.id, h.T_odom_body, h.T_world_body, h.T_body_lidar, h.up_body, {}, {}, {}};
    for (std::vector<float>* a : {&kept.x_m, &kept.y_m, &kept.z_m}) {
      a->resize(h.points);
      if (std::fread(a->data(), sizeof(float), h.points, file.get()) != h.points) return false;
    }
    out.push_back(std::move(kept));
  }
  return true;
}

void save(const std::string& path, const std::vector<Kept>& keyframes) {
  const File file(std::fopen(path.c_str(), "wb"));
  if (!file) return;
  bool ok = put(file.get(), kMagic) && put(file.get(), std::uint64_t{keyframes.size()});
  for (const Kept& k : keyframes) {
    const FileHead h{k.id, k.T_odom_body, k.T_world_body, k.T_body_lidar, k.up_body, k.x_m.size()};
    ok = ok && put(file.get(), h);
    for (const std::vector<float>* a : {&k.x_m, &k.y_m, &k.z_m}) {
      ok = ok && std::fwrite(a->data(), sizeof(float), a->size(), file.get()) == a->size();
    }
  }
  std::error_code ignored;
  if (!ok) std::filesystem::resize_file(path, 0, ignored);  // a partial file must not be read
}

}  // namespace

Result<std::vector<Kept>> record(const RecordOptions& o, const std::string& cache_dir) {
  std::string path;
  if (!cache_dir.empty()) {
    std::error_code ignored;
    std::filesystem::create_directories(cache_dir, ignored);
    path = fmt::format("{}/{}_{}_{}_{}_{}_{}.kf", cache_dir,
                       sim::kSceneNames[static_cast<std::size_t>(o.scene)], o.seed,
                       sim::kLidarNames[static_cast<std::size_t>(o.lidar)],
                       o.halves ? std::string("halves") : fmt::format("{}", o.vehicles),
                       o.pedestrians, o.duration_s);
    std::vector<Kept> kept;
    if (load(path, kept)) return kept;
  }
  auto made = drive(o);
  if (made && !path.empty()) save(path, *made);
  return made;
}

}  // namespace rali::recognition
