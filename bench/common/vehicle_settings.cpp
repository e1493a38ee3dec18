#include "common/vehicle_settings.hpp"

#include "rali/config/apply.hpp"
#include "rali/config/room_settings.hpp"

namespace rali::bench {
namespace {

Result<config::RoomSettings> room_settings(const std::vector<std::string>& assignments) {
  config::RoomSettings rooms;
  config::FieldList fields;
  config::collect_fields("", rooms, fields);
  config::Origins origins;
  for (const std::string& text : assignments) {
    const auto node = config::parse_assignment(text);
    if (!node) return tl::make_unexpected(node.error());
    if (auto ok = config::apply_map(*node, "", "--set", fields, origins); !ok) {
      return tl::make_unexpected(ok.error());
    }
  }
  return rooms;
}

}  // namespace

Result<vehicle::VehicleSettings> vehicle_settings(const std::vector<std::string>& assignments) {
  const auto rooms = room_settings(assignments);
  if (!rooms) return tl::make_unexpected(rooms.error());
  vehicle::VehicleSettings settings = rooms->vehicle;
  settings.odometry = rooms->odometry;
  settings.ranging = rooms->ranging;
  return settings;
}

Result<fleet::FleetSettings> fleet_settings(const std::vector<std::string>& assignments) {
  const auto rooms = room_settings(assignments);
  if (!rooms) return tl::make_unexpected(rooms.error());
  fleet::FleetSettings settings = rooms->fleet;
  settings.ranging = rooms->ranging;
  return settings;
}

}  // namespace rali::bench
