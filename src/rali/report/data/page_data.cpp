#include "rali/report/data/page_data.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "rali/report/data/cloud.hpp"
#include "rali/report/data/columns.hpp"
#include "rali/report/internal/colours.hpp"
#include "rali/report/internal/html.hpp"
#include "rali/report/section/section.hpp"

namespace rali::report {
namespace {

using Json = nlohmann::ordered_json;

/// With these the page stays below 10 MB: 2.4 MB of points, 5 MB of columns.
constexpr std::size_t kPointsMax = 200'000, kRowsMax = 3000, kRowsOfAllMax = 48'000;
constexpr std::size_t kSpotsMax = 400;
/// More kinds of marks in one drawing cannot be distinguished.
constexpr std::size_t kKindsMax = 6;
/// More bars of expected error would hide the trajectory.
constexpr double kBarsPerPath = 8.0;

/// JSON inside <script>: must not contain "</script>".
std::string script_json(const Json& json) {
  const std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  std::string out;
  out.reserve(text.size());
  for (const char c : text) {
    if (c == '<') {
      out += "\\u003c";
    } else {
      out += c;
    }
  }
  return out;
}

/// Drawing data of a vehicle. Vehicles of one `group` share a frame.
Json vehicle_json(const VehicleView& v, const std::string& label, const std::string& group,
                  const Style& style, std::size_t rows_max) {
  Columns columns = columns_of(v);
  thin(columns, rows_max);
  Json json = {{"name", label},      {"group", group},         {"colour", css(style.colour)},
               {"dash", style.dash}, {"rows", columns.rows()}, {"state", packed(columns.state)}};
  for (const Column& column : columns.list) json[std::string(column.name)] = packed(column.values);
  std::vector<float> received;
  for (const Received& h : v.received) {
    for (const double x :
         {h.start_s, h.end_s, static_cast<double>(h.used), static_cast<double>(h.rejected)}) {
      received.push_back(static_cast<float>(x));
    }
  }
  if (!received.empty()) json["received"] = packed(received);
  return json;
}

std::string group_of(const RunData& run, const VehicleView& v) {
  if (v.in_map) return "map";
  for (std::size_t i = 0; i < run.groups.size(); ++i) {
    const auto& names = run.groups[i];
    if (std::find(names.begin(), names.end(), v.name) != names.end()) {
      return fmt::format("frame{}", i);
    }
  }
  return "frame";
}

std::size_t rows_each(std::size_t vehicles) {
  return std::min(kRowsMax, kRowsOfAllMax / std::max<std::size_t>(vehicles, 1));
}

Json spot(const char* kind, const geometry::Vec3& p_m, std::string text) {
  Json json = {{"kind", kind}, {"p", Json::array()}, {"text", std::move(text)}};
  for (const double x : p_m) json["p"].push_back(std::isfinite(x) ? Json(x) : Json(nullptr));
  return json;
}

void add_frontiers(const RunData& run, Json& spots) {
  for (const Frontier& f : run.frontiers) {
    const bool left = f.state != "explored" && f.state != "too_small";
    if (f.round != run.frontiers.back().round || !left || !f.p_m.head<2>().allFinite()) continue;
    if (spots.size() >= kSpotsMax) return;
    spots.push_back(spot("frontier", f.p_m,
                         fmt::format("frontier {}: {}, {:.1f} m", f.id, f.state, f.length_m)));
  }
}

void add_anchors(const RunData& run, Json& spots) {
  for (const Round& round : run.rounds) {
    for (const VehicleView& v : run.vehicles) {
      if (v.name != round.anchor || !v.in_map || spots.size() >= kSpotsMax) continue;
      const PathPoint* where = pose_near(v.path, 0.5 * (round.start_s + round.end_s));
      if (where == nullptr) continue;
      spots.push_back(spot("anchor", where->p_m,
                           fmt::format("round {}: {} stands as anchor", round.round, v.name)));
    }
  }
}

/// Bars of expected error along the degenerate axis, evenly spaced along the trajectory.
void add_axes(const VehicleView& v, Json& spots) {
  if (!v.in_map || v.path.empty()) return;
  const double stride_m = std::max(v.numbers.path_m.value_or(0.0), 1.0) / kBarsPerPath;
  double path_m = 0.0, next_m = 0.5 * stride_m;
  const PathPoint* before = nullptr;
  for (const DegeneracyPoint& d : v.degeneracy) {
    const PathPoint* p = pose_near(v.path, d.t_s);
    if (before != nullptr) path_m += (p->p_m - before->p_m).norm();
    before = p;
    if (path_m < next_m || !d.degenerate || !d.axis.allFinite() || spots.size() >= kSpotsMax)
      continue;
    next_m = path_m + stride_m;
    const bool sized = std::isfinite(d.off_m);
    const std::string off = sized ? fmt::format("+- {} along this axis (1 sigma)", metres(d.off_m))
                                  : std::string("error along this axis not known");
    Json json = spot("axis", p->p_m, fmt::format("{} at {:.0f} s: {}", v.name, d.t_s, off));
    json["axis"] = {d.axis.x(), d.axis.y(), d.axis.z()};
    json["off_m"] = sized && d.off_m < 1e4 ? d.off_m : 0.0;
    spots.push_back(std::move(json));
  }
}

Json series_of(std::string_view label, std::size_t look, const std::vector<RangeDot>& dots) {
  std::vector<float> t_s, residual_m;
  for (const RangeDot& dot : dots) {
    t_s.push_back(static_cast<float>(dot.t_s));
    residual_m.push_back(static_cast<float>(dot.residual_m));
  }
  return {{"label", label}, {"look", look}, {"t", packed(t_s)}, {"residual", packed(residual_m)}};
}

/// The largest |residual| drawn to scale: a few outliers must not flatten the rest.
double scale_of(const PairRanges& pair) {
  std::vector<double> sizes;
  for (const std::vector<RangeDot>& dots : pair.dots) {
    for (const RangeDot& dot : dots) {
      if (std::isfinite(dot.residual_m)) sizes.push_back(std::abs(dot.residual_m));
    }
  }
  if (sizes.empty()) return 1.0;
  const auto at = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() * 97 / 100);
  std::nth_element(sizes.begin(), at, sizes.end());
  return std::max(1.3 * *at, 0.05);
}

/// The used ranges, the most frequent rejection reasons, and all others as one.
Json pair_json(const PairRanges& pair) {
  std::vector<std::size_t> fates;
  for (std::size_t i = 1; i < kRangeOutcomeCount; ++i) {
    if (!pair.dots[i].empty()) fates.push_back(i);
  }
  std::stable_sort(fates.begin(), fates.end(),
                   [&](std::size_t a, std::size_t b) { return pair.count[a] > pair.count[b]; });
  Json list = Json::array({series_of("used", 0, pair.dots[0])});
  std::vector<RangeDot> rest;
  const bool all = fates.size() < kKindsMax;
  for (std::size_t k = 0; k < fates.size(); ++k) {
    const std::vector<RangeDot>& dots = pair.dots[fates[k]];
    if (all || k + 2 < kKindsMax) {
      list.push_back(series_of(outcome_words(static_cast<RangeOutcome>(fates[k])), k + 1, dots));
    } else {
      rest.insert(rest.end(), dots.begin(), dots.end());
    }
  }
  std::stable_sort(rest.begin(), rest.end(),
                   [](const RangeDot& a, const RangeDot& b) { return a.t_s < b.t_s; });
  if (!rest.empty()) list.push_back(series_of("other reasons", kKindsMax - 1, rest));
  return {{"name", pair.a + " - " + pair.b}, {"scale_m", scale_of(pair)}, {"series", list}};
}

Json rounds_json(const RunData& run) {
  Json rounds = Json::array();
  for (const Round& r : run.rounds) {
    if (!std::isfinite(r.start_s) || !std::isfinite(r.end_s) || rounds.size() >= kSpotsMax)
      continue;
    rounds.push_back(
        {{"round", r.round}, {"anchor", r.anchor}, {"begin_s", r.start_s}, {"end_s", r.end_s}});
  }
  return rounds;
}

}  // namespace

std::string page_data(const RunData& run) {
  Json json = {{"end_s", last_time_s(run)}, {"cloud", cloud_json(run.map, kPointsMax)}};
  json["vehicles"] = Json::array();
  json["spots"] = Json::array();
  for (std::size_t i = 0; i < run.vehicles.size(); ++i) {
    const VehicleView& v = run.vehicles[i];
    json["vehicles"].push_back(
        vehicle_json(v, v.name, group_of(run, v), style_of(i), rows_each(run.vehicles.size())));
    add_axes(v, json["spots"]);
  }
  add_frontiers(run, json["spots"]);
  add_anchors(run, json["spots"]);
  json["pairs"] = Json::array();
  for (const PairRanges& pair : run.range_table.pairs) {
    if (json["pairs"].size() < kPairsDrawn) json["pairs"].push_back(pair_json(pair));
  }
  json["rounds"] = rounds_json(run);
  return script_json(json);
}

std::string page_data(const std::vector<RunData>& runs) {
  std::size_t vehicles = 0;
  for (const RunData& run : runs) vehicles += run.vehicles.size();
  Json json = {{"cloud", runs.empty() ? Json(nullptr) : cloud_json(runs.front().map, kPointsMax)}};
  json["vehicles"] = Json::array();
  for (std::size_t i = 0; i < runs.size(); ++i) {
    for (const VehicleView& v : runs[i].vehicles) {
      json["vehicles"].push_back(vehicle_json(v, fmt::format("{} {}", i + 1, runs[i].name), v.name,
                                              style_of(i), rows_each(vehicles)));
    }
  }
  return script_json(json);
}

}  // namespace rali::report
