#pragma once

// The whole library. Target rali::io; programs without files use rali/vehicle.hpp and rali::core.

#include "rali/config.hpp"     // IWYU pragma: export
#include "rali/error.hpp"      // IWYU pragma: export
#include "rali/evaluate.hpp"   // IWYU pragma: export
#include "rali/events.hpp"     // IWYU pragma: export
#include "rali/map.hpp"        // IWYU pragma: export
#include "rali/recording.hpp"  // IWYU pragma: export
#include "rali/results.hpp"    // IWYU pragma: export
#include "rali/types.hpp"      // IWYU pragma: export
#include "rali/vehicle.hpp"    // IWYU pragma: export
#include "rali/version.hpp"    // IWYU pragma: export
