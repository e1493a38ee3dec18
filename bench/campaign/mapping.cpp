#include "mapping.hpp"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "rali/config/load_fleet.hpp"
#include "rali/io/files/atomic_file.hpp"
#include "rali/io/files/csv_writer.hpp"
#include "rali/jobs/map_job.hpp"

namespace rali::campaign {

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

std::string point_text(const geometry::Vec3& p) {
  return fmt::format("[{:.4f}, {:.4f}, {:.4f}]", p.x(), p.y(), p.z());
}

std::string pose_text(const geometry::SE3& T) {
  const Eigen::Quaterniond q(T.R);
  return fmt::format("{{xyz_m: {}, quat_xyzw: [{:.6f}, {:.6f}, {:.6f}, {:.6f}]}}", point_text(T.p),
                     q.x(), q.y(), q.z(), q.w());
}

double yaw_of(const geometry::SE3& T) { return std::atan2(T.R(1, 0), T.R(0, 0)); }

geometry::SE3 level(geometry::SE3 T) {
  T.R = geometry::rotation_from_rpy(0.0, 0.0, yaw_of(T));
  return T;
}

std::string priors_text(const Recording& recording) {
  std::string text;
  const std::vector<Track>& tracks = recording.tracks();
  for (const GivenPrior& p : recording.description().priors) {
    const Track& v = tracks[static_cast<std::size_t>(p.vehicle)];
    const Track& other = tracks[static_cast<std::size_t>(p.relative_to)];
    const geometry::SE3 T = level(other.truth.front().T).inverse() * level(v.truth.front().T);
    const geometry::Vec3 at = T.p + p.error_m;
    text += fmt::format(
        "  - {{vehicle: {}, relative_to: {}, xyz_m: [{:.2f}, {:.2f}, {:.2f}], yaw_deg: {:.1f}, "
        "sigma_m: {:.3f}, sigma_deg: {:.2f}}}\n",
        v.name, other.name, at.x(), at.y(), at.z(),
        std::remainder(yaw_of(T) / kDegree + p.error_deg, 360.0), p.sigma_m, p.sigma_deg);
  }
  return text;
}

/// Campaigns run unattended: progress is not shown.
class Silent final : public drive::ProgressSink {
 public:
  void progress(const drive::Progress& /*progress*/) override {}

  void finding(const Finding& /*finding*/) override {}
};

Status write_ranges(const Recording& recording, const std::string& path) {
  auto csv = io::CsvWriter::create(path, {"stamp_s", "from", "to", "range_m"});
  if (!csv) return tl::make_unexpected(csv.error());
  for (const sensor::RangeSample& r : recording.ranges()) {
    io::CsvRow row;
    row.stamp(r.t);
    row.text(recording.tracks()[r.from.value].name);
    row.text(recording.tracks()[r.to.value].name);
    row.fixed(r.range_m, 3);
    if (Status s = csv->add(row, r.t); !s) return s;
  }
  return csv->finish();
}

}  // namespace

std::string fleet_text(const Recording& recording, const std::string& preset) {
  const Case& c = recording.description();
  std::string text = fmt::format("schema: 1\npreset: {}\nvehicles:\n", preset);
  for (const Track& track : recording.tracks()) {
    text += fmt::format("  {}:\n    recording: {}.mcap\n", track.name, track.name);
    text +=
        fmt::format("    lidar: {{T_body_lidar: {}}}\n", pose_text(track.calibration.T_body_lidar));
    std::string noise;
    if (c.noise) {
      noise = fmt::format("noise: {{accel_mps2_rthz: {:.3g}, gyro_radps_rthz: {:.3g}}}, ",
                          c.noise->accel_mps2_rthz, c.noise->gyro_radps_rthz);
    }
    text += fmt::format("    imu: {{{}{}T_body_imu: {}}}\n", c.has_imu() ? "" : "topic: none, ",
                        noise, pose_text(track.calibration.T_body_imu));
    text +=
        fmt::format("    antennas: {{uwb: {{xyz_m: {}}}}}\n", point_text(track.antennas_m.front()));
  }
  if (!recording.ranges().empty()) text += "ranges: {sources: [{file: ranges.csv}]}\n";
  if (!c.priors.empty()) text += "priors:\n" + priors_text(recording);
  return text;
}

Result<drive::MapSummary> map_recording(std::shared_ptr<const Recording> recording,
                                        const MappingOptions& options) {
  const std::string yaml = options.folder + "/fleet.yaml";
  if (!recording->ranges().empty()) {
    if (Status s = write_ranges(*recording, options.folder + "/ranges.csv"); !s) {
      return tl::make_unexpected(s.error());
    }
  }
  if (Status s = io::write_file_atomic(yaml, fleet_text(*recording, options.preset)); !s) {
    return tl::make_unexpected(s.error());
  }
  config::Overrides load;
  load.assignments = options.assignments;
  const auto fleet = config::load_fleet(yaml, load);
  if (!fleet) return tl::make_unexpected(fleet.error());
  jobs::MapOptions map;
  map.out_dir = options.folder + "/out";
  map.mcap = false;
  map.keyframes = false;
  map.overwrite = true;
  map.threads = 1;
  Result<drive::MapJob> job = jobs::make_map_job(*fleet, map);
  if (!job) return tl::make_unexpected(job.error());
  for (std::size_t v = 0; v < job->vehicles.size(); ++v) {
    job->vehicles[v].open =
        [recording,
         v](const drive::InputOptions& input) -> Result<std::unique_ptr<drive::ReportedSource>> {
      return Recording::play(recording, v, input);
    };
  }
  Silent sink;
  const std::atomic<bool> stop{false};
  return drive::run_map(*job, sink, stop);
}

}  // namespace rali::campaign
