#include "rali/assess/evaluate_words.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string_view>

#include "rali/io/files/text.hpp"

namespace rali::assess {
namespace {

constexpr std::size_t kNumbersMax = 16;

/// Comma-separated finite numbers; nothing if any of them is invalid.
std::optional<std::vector<double>> numbers(std::string_view text) {
  std::vector<double> out;
  while (out.size() <= kNumbersMax) {
    const std::size_t comma = text.find(',');
    const auto value = io::parse_number(io::trimmed(text.substr(0, comma)));
    if (!value || !std::isfinite(*value)) return std::nullopt;
    out.push_back(*value);
    if (comma == std::string_view::npos) return out;
    text.remove_prefix(comma + 1);
  }
  return std::nullopt;
}

}  // namespace

Result<std::vector<double>> parse_distances(const std::string& text) {
  const auto values = numbers(text);
  const bool fit =
      values && std::all_of(values->begin(), values->end(), [](double v) { return v > 0.0; });
  if (!fit) {
    return fail(ErrorCode::kUsage, "--delta",
                io::quoted(text) + " is no list of at most 16 distances above 0",
                "Write it as 1,10,50.");
  }
  std::vector<double> out;
  for (const double v : *values) {
    if (std::find(out.begin(), out.end(), v) == out.end()) out.push_back(v);
  }
  return out;
}

Result<eval::AssociationOptions> parse_association(const std::string& text) {
  eval::AssociationOptions options{eval::AssociationMode::kInterpolate, 0.01, 0.2};
  if (text == "interpolate") return options;
  options.mode = eval::AssociationMode::kNearest;
  if (text == "nearest") return options;
  constexpr std::string_view kNearest = "nearest:";
  if (text.starts_with(kNearest)) {
    const auto value = io::parse_number(std::string_view(text).substr(kNearest.size()));
    if (value && *value >= 0.0 && std::isfinite(*value)) {
      options.max_dt_s = *value;
      return options;
    }
  }
  return fail(ErrorCode::kUsage, "--associate",
              io::quoted(text) + " is neither interpolate nor nearest:SECONDS",
              "Write it as nearest:0.01.");
}

Result<geometry::SE3> parse_pose(const std::string& text) {
  const auto v = numbers(text);
  if (!v || v->size() != 6) {
    return fail(ErrorCode::kUsage, "--T-body-truth",
                io::quoted(text) + " is no pose x,y,z,roll,pitch,yaw",
                "Write six numbers in m and deg between commas, e.g. 0.1,0,0.5,0,0,90.");
  }
  constexpr double kDegree = std::numbers::pi / 180.0;
  return geometry::SE3{
      geometry::rotation_from_rpy((*v)[3] * kDegree, (*v)[4] * kDegree, (*v)[5] * kDegree),
      geometry::Vec3((*v)[0], (*v)[1], (*v)[2])};
}

}  // namespace rali::assess
