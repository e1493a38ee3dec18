#include <cstdio>
#include <filesystem>
#include <memory>
#include <type_traits>

#include <fmt/format.h>
#include <unistd.h>

#include "mission.hpp"

namespace rali::fleet_bench {

namespace {

/// Change with the layout, the simulator or the vehicles' software.
constexpr std::uint64_t kMagic = 0x52414c49464c5431ULL;

struct FileCloser {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

using File = std::unique_ptr<std::FILE, FileCloser>;

/// A keyframe without the name of its file.
struct FileKeyframe {
  KeyframeId id;
  Time t;
  geometry::SE3 T_odom_body, T_body_lidar;
  geometry::Mat6 covariance;
};

/// Writes or reads plain values; structs as bytes, valid on the machine that wrote them. Stops at
/// the first failure.
class Pipe {
 public:
  Pipe(std::FILE* file, bool writing) : file_(file), writing_(writing) {}

  template <class T>
  void value(T& x) {
    block(&x, sizeof(T), 1);
  }

  template <class T>
  void list(std::vector<T>& items) {
    std::uint64_t n = items.size();
    value(n);
    if (!good_) return;
    if (!writing_) items.resize(n);
    block(items.data(), sizeof(T), n);
  }

  [[nodiscard]] bool good() const { return good_; }

  [[nodiscard]] bool writing() const { return writing_; }

 private:
  void block(void* data, std::size_t size, std::size_t n) {
    if (!good_ || n == 0) return;
    good_ = (writing_ ? std::fwrite(data, size, n, file_) : std::fread(data, size, n, file_)) == n;
  }

  std::FILE* file_;
  bool writing_;
  bool good_ = true;
};

void pass(Pipe& pipe, std::vector<drive::KeyframeRecord>& keyframes) {
  std::vector<FileKeyframe> file;
  for (const drive::KeyframeRecord& k : keyframes) {
    file.push_back({k.id, k.t, k.T_local_body, k.T_body_lidar, k.covariance});
  }
  pipe.list(file);
  if (pipe.writing()) return;
  keyframes.clear();
  for (const FileKeyframe& k : file) {
    drive::KeyframeRecord record;
    record.id = k.id;
    record.t = k.t;
    record.T_local_body = k.T_odom_body;
    record.T_body_lidar = k.T_body_lidar;
    record.covariance = k.covariance;
    keyframes.push_back(record);
  }
}

void pass(Pipe& pipe, drive::KeyframeCorrections& corrections) {
  std::vector<vehicle::KeyframeCorrected> file;
  for (const auto& [seq, corrected] : corrections) file.push_back(corrected);
  pipe.list(file);
  if (pipe.writing()) return;
  corrections.clear();
  for (const vehicle::KeyframeCorrected& corrected : file) {
    corrections[corrected.id.seq] = corrected;
  }
}

void pass(Pipe& pipe, Points& points) {
  pipe.list(points.x_m);
  pipe.list(points.y_m);
  pipe.list(points.z_m);
  pipe.list(points.intensity);
  pipe.list(points.ring);
}

template <class T>
void resize(Pipe& pipe, std::vector<T>& items) {
  std::uint64_t n = items.size();
  pipe.value(n);
  if (!pipe.writing() && pipe.good()) items.resize(n);
}

void pass(Pipe& pipe, Mission& mission) {
  std::uint64_t magic = kMagic;
  pipe.value(magic);
  if (magic != kMagic) return;
  pipe.value(mission.duration_s);
  pipe.value(mission.cpu_ms);
  resize(pipe, mission.vehicles);
  for (Driven& v : mission.vehicles) {
    pipe.value(v.T_world_start);
    pipe.value(v.path_m);
    pipe.list(v.truth);
    pipe.list(v.poses);
    pass(pipe, v.smoothed);
    pass(pipe, v.keyframes);
    resize(pipe, v.points);
    for (Points& points : v.points) pass(pipe, points);
    resize(pipe, v.facts);
    for (wire::Bytes& fact : v.facts) pipe.list(fact);
    if (!pipe.good()) return;
  }
}

bool is_current(const std::string& path) {
  const File file(std::fopen(path.c_str(), "rb"));
  std::uint64_t magic = 0;
  return file && std::fread(&magic, sizeof magic, 1, file.get()) == 1 && magic == kMagic;
}

}  // namespace

bool load_mission(const std::string& path, Mission& mission) {
  if (!is_current(path)) return false;
  const File file(std::fopen(path.c_str(), "rb"));
  Pipe pipe(file.get(), false);
  pass(pipe, mission);
  return pipe.good() && !mission.vehicles.empty();
}

Status save_mission(const std::string& path, const Mission& mission) {
  // Written under another name first, so that an interrupted run leaves no partial mission.
  const std::string half = fmt::format("{}.{}", path, getpid());
  bool kept = false;
  {
    const File file(std::fopen(half.c_str(), "wb"));
    if (file) {
      Pipe pipe(file.get(), true);
      Mission copy = mission;
      pass(pipe, copy);
      kept = pipe.good() && std::fflush(file.get()) == 0;
    }
  }
  std::error_code error;
  if (kept) std::filesystem::rename(half, path, error);
  if (kept && !error) return {};
  std::filesystem::remove(half, error);
  return fail(ErrorCode::kMachine, half, "the cache cannot be written", "Is the disk full?");
}

}  // namespace rali::fleet_bench
