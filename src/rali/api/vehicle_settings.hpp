#pragma once

#include "rali/vehicle.hpp"
#include "rali/vehicle/settings.hpp"

namespace rali {

/// Implementation of the public, opaque settings.
struct VehicleSettings::Impl {
  vehicle::VehicleSettings settings;
};

}  // namespace rali
