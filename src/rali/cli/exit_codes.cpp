#include "rali/cli/exit_codes.hpp"

#include <array>

namespace rali::cli {
namespace {

constexpr std::array kExitCodes{
    ExitCode{"0", "done", "done, as asked"},
    ExitCode{"1", "below what was asked", "done, but below what was asked"},
    ExitCode{"2", "not started", "not started: usage, settings, unreadable or unfit input"},
    ExitCode{"3", "done with gaps",
             "done with gaps: damaged input, vehicles not joined, a diverged stretch, a map that "
             "contradicts itself"},
    ExitCode{"4", "stopped by the machine",
             "stopped by the machine: disk full, memory, permission; what is whole is kept"},
    ExitCode{"5", "internal fault", "internal fault: a bug of the program, please report it"},
    ExitCode{"130, 143", "interrupted",
             "stopped by SIGINT, SIGTERM: outputs are finished up to the time reached; a second "
             "signal stops at once"},
};

}  // namespace

std::span<const ExitCode> exit_codes() { return kExitCodes; }

}  // namespace rali::cli
