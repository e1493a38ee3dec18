#pragma once

#include <memory>

#include "rali/config.hpp"
#include "rali/config/fleet_config.hpp"
#include "rali/drive/state/fleet_facts.hpp"
#include "rali/vehicle/settings.hpp"

namespace rali {

/// Implementation of the public, opaque configuration.
struct FleetConfig::Impl {
  config::FleetConfig fleet;
  std::shared_ptr<const drive::FleetFacts> facts;  ///< of state folders; null: recordings
};

namespace api_io {

/// The public options that correspond to these settings.
[[nodiscard]] VehicleOptions public_options(const vehicle::VehicleSettings& settings);

}  // namespace api_io
}  // namespace rali
