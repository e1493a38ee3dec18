#include "recording.hpp"

#include <cstdio>
#include <filesystem>
#include <vector>

#include <fmt/format.h>
#include <unistd.h>

#include "common/option_hash.hpp"

namespace rali::accuracy {

namespace {

constexpr std::uint64_t kMagic = 0x52414c4953494d34ULL;  // change with the layout or the simulator

std::uint64_t hash_of(const sim::SimOptions& options) {
  bench::OptionHash hash;
  bench::add_options(options, hash);
  return hash.value();
}

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

// Plain numbers only, so that a struct can be written as its bytes.
struct FileHead {
  std::uint64_t magic;
  sensor::Calibration calibration;
  double path_m;
};

struct FileScan {
  std::int64_t number;
  std::int64_t t_start_ns;
  eval::StampedPose truth;
};

enum class Tag : std::uint8_t { kEnd, kImu, kScan };

bool put_scan(std::FILE* file, const sim::RawScan& raw, Time t_start,
              const eval::StampedPose& truth) {
  const FileScan head{raw.number, t_start.ns, truth};
  const std::size_t n = raw.range_steps.size();
  return put(file, Tag::kScan) && put(file, head) &&
         std::fwrite(raw.range_steps.data(), 2, n, file) == n &&
         std::fwrite(raw.intensity.data(), 1, n, file) == n;
}

/// Simulates the recording, calls the listener and, if `file` is open, stores it.
Status cast(const sim::SimOptions& options, std::FILE* file, const Listener& listener) {
  auto made = sim::make_simulation(options);
  if (!made) return tl::make_unexpected(made.error());
  sim::Simulation& sim = **made;
  bool kept = true;
  if (file != nullptr) kept = put(file, FileHead{kMagic, sim.calibration_nominal(), sim.path_m()});
  listener.on_head({sim.calibration_nominal(), sim.path_m()});
  while (auto message = sim.next()) {
    if (const auto* imu = std::get_if<sensor::ImuSample>(&*message)) {
      if (file != nullptr) kept = kept && put(file, Tag::kImu) && put(file, *imu);
      listener.on_imu(*imu);
      continue;
    }
    auto& scan = std::get<std::shared_ptr<const sensor::LidarScan>>(*message);
    const eval::StampedPose truth{scan->t_end, sim.truth(scan->t_end).state.T_world_body};
    if (file != nullptr) kept = kept && put_scan(file, sim.last_raw_scan(), scan->t_start, truth);
    listener.on_scan(std::move(scan), truth);
  }
  if (file != nullptr) kept = kept && put(file, Tag::kEnd) && std::fflush(file) == 0;
  if (!kept)
    return fail(ErrorCode::kMachine, {}, "the cache cannot be written", "Is the disk full?");
  return {};
}

Status damaged(const std::string& path) {
  return fail(ErrorCode::kInput, path, "this kept recording ends early", "Delete it.");
}

Status read_scan(std::FILE* file, const sim::LidarModel& model, double resolution_m,
                 const std::string& path, const Listener& listener) {
  FileScan head{};
  sim::RawScan raw;
  const auto n =
      static_cast<std::size_t>(model.rings()) * static_cast<std::size_t>(model.firings());
  raw.range_steps.resize(n);
  raw.intensity.resize(n);
  if (!get(file, head) || std::fread(raw.range_steps.data(), 2, n, file) != n ||
      std::fread(raw.intensity.data(), 1, n, file) != n) {
    return damaged(path);
  }
  raw.number = head.number;
  listener.on_scan(sim::expand(raw, model, resolution_m, Time::from_ns(head.t_start_ns)),
                   head.truth);
  return {};
}

Status replay(const sim::SimOptions& options, std::FILE* file, const std::string& path,
              const Listener& listener) {
  FileHead head{};
  if (!get(file, head) || head.magic != kMagic) return damaged(path);
  listener.on_head({head.calibration, head.path_m});
  const sim::LidarModel model(options.lidar);
  for (Tag tag{}; get(file, tag);) {
    if (tag == Tag::kEnd) return {};
    if (tag == Tag::kScan) {
      if (auto ok = read_scan(file, model, options.ranging.resolution_m, path, listener); !ok)
        return ok;
    } else {
      sensor::ImuSample imu;
      if (!get(file, imu)) return damaged(path);
      listener.on_imu(imu);
    }
  }
  return damaged(path);
}

bool is_current(const std::string& path) {
  const File file(std::fopen(path.c_str(), "rb"));
  std::uint64_t magic = 0;
  return file && get(file.get(), magic) && magic == kMagic;
}

}  // namespace

Status play(const sim::SimOptions& options, const std::string& cache_dir,
            const Listener& listener) {
  if (cache_dir.empty()) return cast(options, nullptr, listener);
  std::error_code ignored;
  std::filesystem::create_directories(cache_dir, ignored);
  const std::string path = fmt::format("{}/{}_{}_{:016x}.rec", cache_dir,
                                       sim::kSceneNames[static_cast<std::size_t>(options.scene)],
                                       options.seed, hash_of(options));
  if (is_current(path)) {
    const File file(std::fopen(path.c_str(), "rb"));
    return replay(options, file.get(), path, listener);
  }
  // Written under another name first, so that an interrupted run leaves no partial recording.
  const std::string half = fmt::format("{}.{}", path, getpid());
  const File file(std::fopen(half.c_str(), "wb"));
  if (!file) return fail(ErrorCode::kMachine, half, "the file cannot be opened", "Check --cache.");
  auto done = cast(options, file.get(), listener);
  if (done) {
    std::filesystem::rename(half, path, ignored);
  } else {
    std::filesystem::remove(half, ignored);
  }
  return done;
}

}  // namespace rali::accuracy
