#include "rali/cli/commands/demo.hpp"

#include <fmt/format.h>

#include "rali/cli/commands/report.hpp"
#include "rali/cli/demo/demo_recording.hpp"
#include "rali/cli/map_job.hpp"
#include "rali/cli/map_summary.hpp"
#include "rali/cli/picture/map_picture.hpp"
#include "rali/cli/progress_view.hpp"
#include "rali/config/load_fleet.hpp"
#include "rali/eval/alignment.hpp"
#include "rali/eval/errors.hpp"
#include "rali/io/files/tum.hpp"

namespace rali::cli {
namespace {

/// How well the map's way fits the truth.
struct Score {
  double ape_rmse_m = 0.0;
  double ape_max_m = 0.0;
  double way_m = 0.0;
  geometry::SE3 T_map_world;
};

Result<Score> score_of(const std::string& tum_file, const eval::PoseList& truth) {
  const Result<io::TumFile> tum = io::read_tum(tum_file);
  if (!tum) return tl::make_unexpected(tum.error());
  eval::PoseList poses;
  for (const io::StampedPose& pose : tum->poses) poses.push_back({pose.t, pose.T});
  eval::AssociationOptions options;
  options.mode = eval::AssociationMode::kInterpolate;
  const Result<eval::Association> found = eval::associate(poses, truth, options);
  if (!found) return tl::make_unexpected(found.error());
  const Result<geometry::SE3> T_world_map = eval::align(found->pairs, eval::Alignment::kSe3);
  if (!T_world_map) return tl::make_unexpected(T_world_map.error());
  Score score;
  score.T_map_world = T_world_map->inverse();
  const eval::Statistics ape =
      eval::translation_statistics(eval::absolute_errors(found->pairs, *T_world_map));
  score.ape_rmse_m = ape.rmse;
  score.ape_max_m = ape.max;
  score.way_m = eval::way_length_m(found->pairs);
  return score;
}

PictureWay truth_way(const eval::PoseList& truth, const geometry::SE3& T_map_world) {
  PictureWay way{"truth", Colour{150, 156, 166}, 11.0, {}};
  for (const eval::StampedPose& pose : truth) way.points_map_m.push_back(T_map_world * pose.T.p);
  return way;
}

class DemoCommand final : public Command {
 public:
  [[nodiscard]] std::string name() const override { return "demo"; }

  [[nodiscard]] std::string summary() const override {
    return "simulate a recording, map it, compare with the truth, draw map.png";
  }

  [[nodiscard]] std::vector<std::string> examples() const override {
    return {"rali demo", "rali demo -o tunnel --scene tunnel"};
  }

  [[nodiscard]] std::string exit_codes() const override {
    return "as rali map: 0 done, 2 not started, 3 done with gaps, 4 disk, 130 interrupted";
  }

  [[nodiscard]] Positional positional() override { return {"", "", nullptr, 0, 0, {}}; }

  [[nodiscard]] std::vector<Option> options() override {
    return {
        {"-o,--out", "DIR", "where recording, map and picture go", &folder_, false, {}},
        {"--scene",
         "NAME",
         "the place",
         &scene_,
         false,
         {sim::kSceneNames.begin(), sim::kSceneNames.end()}},
        {"--seed", "N", "another number, another place of that kind", &seed_, false, {}},
        {"--duration",
         "S",
         "length of the recording [s]; 0: the whole way",
         &duration_s_,
         false,
         {}},
        {"--threads", "N", "0: one per core; results do not depend on it", &threads_, true, {}},
    };
  }

  [[nodiscard]] Result<int> run(Session& session) override;

 private:
  [[nodiscard]] Result<DemoRecording> simulate(Session& session) const;
  [[nodiscard]] Result<drive::MapSummary> map(const std::string& fleet_file,
                                              Session& session) const;
  [[nodiscard]] Status draw(const Score& score, const eval::PoseList& truth) const;

  [[nodiscard]] std::string out_dir() const { return folder_ + "/out"; }

  std::string folder_ = "rali-demo", scene_ = "floor";
  int seed_ = 1, threads_ = 0;
  double duration_s_ = 0.0;
};

Result<DemoRecording> DemoCommand::simulate(Session& session) const {
  const Result<sim::Scene> scene = sim::scene_of(scene_);
  if (!scene) return tl::make_unexpected(scene.error());
  sim::SimOptions options;
  options.scene = *scene;
  options.seed = static_cast<std::uint64_t>(seed_);
  options.duration_s = duration_s_;
  options.imu_apart = true;  // as on real vehicles
  ProgressView view(session);
  drive::Progress progress;
  progress.vehicle = "v1";
  progress.stage = "simulation";
  return write_demo_recording(options, folder_, [&](double share) {
    progress.share = share;
    view.progress(progress);
    return !stop_requested();
  });
}

Result<drive::MapSummary> DemoCommand::map(const std::string& fleet_file, Session& session) const {
  const Result<config::FleetConfig> fleet = config::load_fleet(fleet_file, {});
  if (!fleet) return tl::make_unexpected(fleet.error());
  MapOptions options;
  options.out_dir = out_dir();
  options.overwrite = true;
  options.threads = threads_;
  options.command_line = session.command_line;
  const Result<drive::MapJob> job = make_map_job(*fleet, options);
  if (!job) return tl::make_unexpected(job.error());
  ProgressView view(session);
  Result<drive::MapSummary> summary = drive::run_map(*job, view, stop_requested());
  session.live_line("");
  return summary;
}

Status DemoCommand::draw(const Score& score, const eval::PoseList& truth) const {
  Result<MapPicture> picture = picture_of_folder(out_dir());
  if (!picture) return tl::make_unexpected(picture.error());
  picture->title = fmt::format("RaLI demo: {}, one vehicle, 16 rings and IMU", scene_);
  picture->subtitle += fmt::format(", off the truth by {:.3f} m (rmse)", score.ape_rmse_m);
  picture->ways.insert(picture->ways.begin(), truth_way(truth, score.T_map_world));
  const Result<io::RgbImage> image = draw_map(*picture);
  if (!image) return tl::make_unexpected(image.error());
  return io::write_png(folder_ + "/map.png", *image);
}

Result<int> DemoCommand::run(Session& session) {
  if (seed_ < 0 || threads_ < 0 || threads_ > 1024 || !(duration_s_ >= 0.0)) {
    return fail(ErrorCode::kUsage, "rali demo",
                "--seed, --duration and --threads (at most 1024) are not negative");
  }
  const Result<DemoRecording> recording = simulate(session);
  session.live_line("");
  if (!recording) return tl::make_unexpected(recording.error());
  session.note(fmt::format("{}: {:.0f} s of data; next: rali map {} -o {}", folder_ + "/v1.mcap",
                           recording->duration_s, recording->fleet_file, out_dir()));
  const Result<drive::MapSummary> summary = map(recording->fleet_file, session);
  if (!summary) return tl::make_unexpected(summary.error());
  const Result<Score> score = score_of(out_dir() + "/trajectory/v1.tum", recording->truth);
  if (!score) return tl::make_unexpected(score.error());
  if (Status status = draw(*score, recording->truth); !status) {
    return tl::make_unexpected(status.error());
  }
  if (Status status = add_report(out_dir()); !status) return tl::make_unexpected(status.error());
  session.result(summary_text(*summary));
  session.result(fmt::format(
      "against the truth: position off by {:.3f} m (rmse), {:.3f} m at most, on {:.0f} m\n"
      "{}/map.png\n",
      score->ape_rmse_m, score->ape_max_m, score->way_m, folder_));
  return exit_code_of(*summary, stop_signal());
}

}  // namespace

std::unique_ptr<Command> make_demo_command() { return std::make_unique<DemoCommand>(); }

}  // namespace rali::cli
