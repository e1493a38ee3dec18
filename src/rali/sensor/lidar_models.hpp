#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace rali::sensor {

/// Properties of a LiDAR model: the elevations of its lasers and its scan pattern.
struct LidarModel {
  std::string_view name;                  ///< as in settings, e.g. "vlp16"
  std::string_view maker;                 ///< e.g. "Velodyne VLP-16"
  std::span<const float> elevations_deg;  ///< ascending, design values; empty: no fixed rings
  bool spinning = true;                   ///< turns about z through the whole circle
  bool clockwise = true;                  ///< seen from above
  std::uint16_t lines = 0;                ///< lasers; for spinning ones the number of elevations
};

/// All models, in a fixed order; the last is "generic".
[[nodiscard]] std::span<const LidarModel> lidar_models();

/// The model of this name ("vlp16", "os1_64", ...), nullptr if there is none.
[[nodiscard]] const LidarModel* find_lidar_model(std::string_view name);

/// "vlp16, vlp32c, ...", for error messages.
[[nodiscard]] std::string lidar_model_names();

/// Index of the elevation nearest to `elevation_rad`.
/// @param elevations_rad ascending, not empty
[[nodiscard]] std::size_t nearest_ring(std::span<const float> elevations_rad, float elevation_rad);

/// The spinning model whose elevations match the measured ones, nullptr if none fits. Of several
/// equal fits the first in the table is returned. Units differ from the design values by up to 0.3
/// deg. Mounting does not matter: the angles are in the sensor's frame. A sensor's outermost rings
/// may be missing (no returns), so up to 1/8 of the model's rings may have no partner.
/// @param elevations_rad ascending
[[nodiscard]] const LidarModel* identify_lidar(std::span<const float> elevations_rad);

}  // namespace rali::sensor
