#include "rali/host/picture_job.hpp"

#include <utility>

#include "rali/base/stop_flag.hpp"
#include "rali/host/live_state.hpp"
#include "rali/wire/encode.hpp"

namespace rali::host {
namespace {

constexpr auto kCdr = wire::Encoding::kCdr;
constexpr double kCloudVoxel_m = 0.2;
constexpr std::size_t kCloudPoints = 300'000;
/// A table that moves any pose by more is announced, and the whole map is published again.
constexpr double kMoved_m = 0.1;

}  // namespace

void PictureJob::run(Executor& /*executor*/, const std::atomic<bool>& cancel) {
  const StopFlag stop(cancel);
  picture_->update(order_.news);
  order_.news = {};
  const MapPicture::Move before = std::exchange(shown.last_move, picture_->last_move());
  shown.keyframes = picture_->keyframes();
  shown.T_map_local = picture_->T_map_local();
  publish_points();
  const bool moved = shown.last_move.metres > kMoved_m && shown.last_move.metres != before.metres;
  if (moved) ++shown.revision;
  if ((moved || order_.cloud) && !stop.raised()) publish_cloud();
  if (order_.grid && !stop.raised()) publish_grid();
  if (order_.paths && !stop.raised()) publish_paths();
}

void PictureJob::publish_points() {
  if (const auto delta = picture_->take_delta(order_.t)) {
    publish.push_back({RosTopicId::kMapDelta, order_.t, wire::encode(delta->view, kCdr)});
  }
}

void PictureJob::publish_cloud() {
  cloud_made = true;
  if (const auto cloud = picture_->whole(order_.t, kCloudVoxel_m, kCloudPoints)) {
    publish.push_back({RosTopicId::kMapCloud, order_.t, wire::encode(cloud->view, kCdr)});
  }
}

void PictureJob::publish_grid() {
  if (const auto grid = picture_->grid(order_.t)) {
    publish.push_back({RosTopicId::kMap, order_.t, wire::encode(*grid, kCdr)});
  }
}

void PictureJob::publish_paths() {
  std::vector<StatePath> all;
  for (const auto& [vehicle, points] : picture_->paths()) {
    StatePath path;
    path.vehicle = names_[vehicle.value];
    for (const MapPicture::PathPoint& point : points) {
      path.t_s.push_back(point.t.s());
      path.position_m.push_back(point.p_map_m);
      path.degenerate.push_back(point.degenerate);
    }
    all.push_back(std::move(path));
  }
  paths.push_back(paths_json(order_.t.s(), all));
}

}  // namespace rali::host
