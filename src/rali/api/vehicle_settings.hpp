#pragma once

#include "rali/vehicle.hpp"
#include "rali/vehicle/settings.hpp"

namespace rali {

/// What the public, opaque settings hold.
struct VehicleSettings::Impl {
  vehicle::VehicleSettings settings;
};

}  // namespace rali
