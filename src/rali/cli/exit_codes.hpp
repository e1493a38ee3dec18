#pragma once

#include <span>
#include <string_view>

namespace rali::cli {

inline constexpr int kExitDone = 0;
inline constexpr int kExitBelowAsked = 1;
inline constexpr int kExitNotStarted = 2;
inline constexpr int kExitGaps = 3;
inline constexpr int kExitMachine = 4;
inline constexpr int kExitInternal = 5;

/// Exit codes of the program. `rali -h`, the manual page and docs/reference/cli.md are made from
/// them.
struct ExitCode {
  std::string_view number;
  std::string_view brief;
  std::string_view meaning;
};

[[nodiscard]] std::span<const ExitCode> exit_codes();

}  // namespace rali::cli
