#pragma once

#include "rali/cli/command.hpp"

namespace rali::cli {

/// `rali play RECORDING`: publishes the sensor data of a recording on a ROS 2 network.
[[nodiscard]] std::unique_ptr<Command> make_play_command();

}  // namespace rali::cli
