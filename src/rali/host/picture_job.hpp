#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "rali/fleet/node/job.hpp"
#include "rali/host/map_picture.hpp"
#include "rali/host/ros_outputs.hpp"

namespace rali::host {

/// What a picture of the map is made from.
struct PictureOrder {
  Time t;  ///< on the clock of the sensors: stamp of what is published
  MapNews news;
  bool grid = false, cloud = false, paths = false;  ///< what is due besides the new points
};

/// What the agent's thread keeps of it.
struct PictureShown {
  MapPicture::Move last_move;
  std::size_t keyframes = 0;
  std::map<VehicleId, geometry::SE3> T_map_local;  ///< see MapPicture
  /// Of the table: another one after each that moved any pose by more than 0.1 m.
  std::uint32_t revision = 0;
};

/// Draws the map that the live page and ROS show, beside the steps of the agent. It owns the
/// picture while it is under way; there is one at a time.
class PictureJob final : public fleet::Job {
 public:
  /// @param before  what was shown until now  @param names  of all vehicles
  PictureJob(std::unique_ptr<MapPicture> picture, const PictureShown& before, PictureOrder order,
             const std::vector<std::string>& names)
      : picture_(std::move(picture)), order_(std::move(order)), names_(names), shown(before) {}

  void run(Executor& executor, const std::atomic<bool>& cancel) override;

  [[nodiscard]] fleet::JobWork work() const override { return {}; }

  [[nodiscard]] std::unique_ptr<MapPicture> take_picture() { return std::move(picture_); }

 private:
  void publish_points();
  void publish_cloud();
  void publish_grid();
  void publish_paths();

  std::unique_ptr<MapPicture> picture_;
  PictureOrder order_;
  std::vector<std::string> names_;

 public:
  // After run().
  PictureShown shown;
  std::vector<RosOut> publish;
  std::vector<std::string> paths;  ///< JSON of /rali/paths
  bool cloud_made = false;         ///< since it was due, or the map has moved
};

}  // namespace rali::host
