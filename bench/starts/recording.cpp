#include "recording.hpp"

#include <array>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <sstream>

#include <Eigen/Geometry>
#include <fmt/format.h>

namespace rali::bench {

namespace {

using sensor::LidarScan;

std::shared_ptr<LidarScan> read_scan(const std::string& file, Time t) {
  constexpr float kUnit_m = 0.0025F;
  std::ifstream in(file, std::ios::binary);
  if (!in) return nullptr;
  auto scan = std::make_shared<LidarScan>();
  scan->t_start = t;
  scan->t_end = t;
  std::array<char, 8> record{};
  while (in.read(record.data(), record.size())) {
    std::array<std::int16_t, 3> p{};
    std::memcpy(p.data(), record.data(), 6);
    scan->push_back(kUnit_m * p[0], kUnit_m * p[1], kUnit_m * p[2], 0.0F, 0.0F, 0);
  }
  return scan;
}

}  // namespace

Result<ReferencedScans> read_compact_scans(const std::string& folder) {
  ReferencedScans scans;
  std::ifstream poses(folder + "/poses.tum");
  std::string line;
  while (std::getline(poses, line)) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream in(line);
    double t = 0.0;
    geometry::Vec3 p;
    Eigen::Quaterniond q;
    in >> t >> p.x() >> p.y() >> p.z() >> q.x() >> q.y() >> q.z() >> q.w();
    const std::string file = fmt::format("{}/scans/{:06d}.xyzi", folder, scans.size());
    const std::shared_ptr<const LidarScan> scan = read_scan(file, Time::from_s(t));
    if (!scan) return fail(ErrorCode::kInput, file, "cannot be read");
    scans.push_back({scan, {q.normalized().toRotationMatrix(), p}});
  }
  if (scans.empty()) return fail(ErrorCode::kInput, folder + "/poses.tum", "holds no pose");
  return scans;
}

ReferencedScans reversed(const ReferencedScans& scans) {
  ReferencedScans out;
  if (scans.empty()) return out;
  const Time first = scans.front().scan->t_end;
  const Time last = scans.back().scan->t_end;
  for (auto s = scans.rbegin(); s != scans.rend(); ++s) {
    auto scan = std::make_shared<LidarScan>(*s->scan);
    scan->t_end = first + (last - scan->t_end);
    scan->t_start = scan->t_end;
    out.push_back({scan, s->T_map_lidar});
  }
  return out;
}

ReferencedScans halved(const ReferencedScans& scans) {
  ReferencedScans out;
  for (std::size_t k = 0; k < scans.size(); k += 2) out.push_back(scans[k]);
  return out;
}

}  // namespace rali::bench
