#include "rali/drive/live/live_files.hpp"

#include <utility>

namespace rali::drive {

LiveFiles::LiveFiles(PoseFiles poses, io::CsvWriter steps)
    : poses_(std::move(poses)), steps_(std::move(steps)) {}

Result<LiveFiles> LiveFiles::create(const std::string& out_dir, const std::string& vehicle) {
  Result<PoseFiles> poses = PoseFiles::create(out_dir, "live", vehicle, "map");
  if (!poses) return tl::make_unexpected(poses.error());
  Result<io::CsvWriter> steps = io::CsvWriter::create(out_dir + "/live/" + vehicle + ".steps.csv",
                                                      {"stamp_s", "shift_m", "turn_rad", "reason"});
  if (!steps) return tl::make_unexpected(steps.error());
  return LiveFiles(std::move(*poses), std::move(*steps));
}

Status LiveFiles::add(const LivePose& pose, const std::optional<FrameStep>& step) {
  if (tally_.poses++ == 0) tally_.t_joined = pose.t;
  if (Status s = poses_.add(pose.t, pose.T_map_body, pose.covariance); !s || !step) return s;
  if (tally_.poses > 1) {
    ++tally_.steps;
    if (tally_.steps == 1 || step->shift_m > tally_.largest.shift_m) tally_.largest = *step;
  }
  io::CsvRow row;
  row.stamp(step->t).fixed(step->shift_m, 6).fixed(step->turn_rad, 6).text(step->reason);
  return steps_.add(row, step->t);
}

Status LiveFiles::close() {
  Status first = poses_.close();
  Status second = steps_.finish();
  return first ? second : first;
}

}  // namespace rali::drive
