#include "rali/io/convert/convert.hpp"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "rali/io/files/text.hpp"

namespace rali::io {
namespace {

constexpr std::size_t kCloudsFrom = 1, kTrajectoriesFrom = 5;

}  // namespace

const std::vector<std::string>& convert_targets() {
  static const std::vector<std::string> targets = {"mcap", "pcd",   "ply",   "las", "bin",
                                                   "tum",  "kitti", "euroc", "csv"};
  return targets;
}

Result<Conversion> convert(const std::string& in, const std::string& out,
                           const ConvertOptions& options) {
  const std::vector<std::string>& targets = convert_targets();
  std::string to = options.to;
  if (to.empty()) {
    const std::string extension = lower_case(std::filesystem::path(out).extension().string());
    to = extension.empty() ? extension : extension.substr(1);
  }
  const auto at = std::find(targets.begin(), targets.end(), to);
  if (at == targets.end()) {
    return fail(ErrorCode::kUsage, out,
                fmt::format("the extension names no target ({})", fmt::join(targets, ", ")),
                "Use one of these extensions, or --to.");
  }
  const auto index = static_cast<std::size_t>(at - targets.begin());
  if (index < kCloudsFrom) return convert_recording(in, out, options);
  if (index < kTrajectoriesFrom) return convert_cloud(in, out, to);
  return convert_trajectory(in, out, to, options.times);
}

}  // namespace rali::io
