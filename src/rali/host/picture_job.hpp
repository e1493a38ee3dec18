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

/// Inputs of a picture of the map.
struct PictureOrder {
  Time t;  ///< on the clock of the sensors: stamp of the published messages
  MapNews news;
  bool grid = false, cloud = false, paths = false;  ///< due besides the new points
};

/// The part of it that the agent's thread keeps.
struct PictureShown {
  MapPicture::Move last_move;
  std::size_t keyframes = 0;
  std::map<VehicleId, geometry::SE3> T_map_local;  ///< see MapPicture
  /// Of the table: raised by each table that moved any pose by more than 0.1 m.
  std::uint32_t revision = 0;
};

/// Draws the map for the live page and ROS, outside the steps of the agent. It owns the picture
/// while it runs; there is one job at a time.
class PictureJob final : public fleet::Job {
 public:
  /// @param before previously shown state  @param names of all vehicles
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
  bool cloud_made = false;         ///< because it was due, or the map has moved
};

}  // namespace rali::host
