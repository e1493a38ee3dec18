#include <algorithm>
#include <cmath>
#include <cstring>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "rali/report/internal/colours.hpp"
#include "rali/report/internal/html.hpp"
#include "rali/report/plot/map_raster.hpp"
#include "rali/report/section/section.hpp"
#include "rali/report/thinned_map.hpp"

namespace rali::report {

namespace assets {
std::string_view script();
}

namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kPointsMax = 120'000, kWayPointsMax = 4000, kColours = 64;

std::vector<std::size_t> kept_points(const MapPoints& map, const std::array<Range, 3>& box) {
  const double share =
      static_cast<double>(kPointsMax) / static_cast<double>(std::max<std::size_t>(map.size(), 1));
  const bool all = share >= 1.0;
  const auto limit = static_cast<std::uint64_t>(std::min(share, 0.999999) * 18446744073709549568.0);
  const auto inside = [&](const Range& r, float v) {
    return static_cast<double>(v) >= r.low() && static_cast<double>(v) <= r.high();
  };
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < map.size(); ++i) {
    if (!all && mixed(i) > limit) continue;
    if (inside(box[0], map.x_m[i]) && inside(box[1], map.y_m[i]) && inside(box[2], map.z_m[i])) {
      kept.push_back(i);
    }
  }
  return kept;
}

template <class T>
void put(std::vector<std::byte>& out, T value) {
  const std::size_t at = out.size();
  out.resize(at + sizeof value);
  std::memcpy(out.data() + at, &value, sizeof value);
}

std::string packed_way(const std::vector<WayPoint>& way, const geometry::Vec3& centre) {
  std::vector<std::byte> bytes;
  const std::size_t stride = way.size() / kWayPointsMax + 1;
  for (std::size_t i = 0; i < way.size(); i += stride) {
    for (int axis = 0; axis < 3; ++axis) {
      put(bytes, static_cast<float>(way[i].p_m[axis] - centre[axis]));
    }
  }
  return base64(bytes);
}

Json colours() {
  Json list = Json::array();
  for (std::size_t i = 0; i < kColours; ++i) {
    list.push_back(scale_colour(static_cast<double>(i) / (kColours - 1), false));
  }
  return list;
}

std::byte level(double share) {
  if (!std::isfinite(share)) return std::byte{0};
  return std::byte{static_cast<std::uint8_t>(std::clamp(share, 0.0, 1.0) * (kColours - 1))};
}

void pack_points(const MapPoints& map, const std::array<Range, 3>& box,
                 const geometry::Vec3& centre, Json& json) {
  double half_m = 1.0;
  for (const Range& r : box) half_m = std::max(half_m, 0.5 * r.width());
  const double step_m = half_m / 32000.0;
  const ErrorScale scale = error_scale(map);
  std::vector<std::byte> points, height, sigma, vehicle;
  const std::vector<std::size_t> kept = kept_points(map, box);
  for (const std::size_t i : kept) {
    const std::array<float, 3> p = {map.x_m[i], map.y_m[i], map.z_m[i]};
    for (std::size_t a = 0; a < 3; ++a) {
      const double v = (static_cast<double>(p[a]) - centre[static_cast<Eigen::Index>(a)]) / step_m;
      put(points, static_cast<std::int16_t>(std::lround(std::clamp(v, -32767.0, 32767.0))));
    }
    height.push_back(level((static_cast<double>(p[2]) - box[2].low()) / box[2].width()));
    sigma.push_back(level(1.0 - scale.share(static_cast<double>(map.sigma_m[i]))));
    vehicle.push_back(std::byte{map.vehicle[i]});
  }
  json["count"] = kept.size();
  json["step_m"] = step_m;
  json["half_height_m"] = 0.5 * box[2].width();
  json["points"] = base64(points);
  json["height"] = base64(height);
  json["sigma"] = base64(sigma);
  json["vehicle"] = base64(vehicle);
}

/// JSON inside of <script>: no "</script>" can come to stand in it.
std::string script_json(const Json& json) {
  const std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  std::string out;
  for (const char c : text) {
    if (c == '<') {
      out += "\\u003c";
    } else {
      out += c;
    }
  }
  return out;
}

std::vector<WayPoint> blind_part(const VehicleView& v) {
  std::vector<WayPoint> part;
  for (const BlindSpan& b : v.blind) {
    for (const WayPoint& w : v.way) {
      if (w.t_s >= b.begin_s && w.t_s <= b.end_s) part.push_back(w);
    }
  }
  return part;
}

/// What the colours mean; the scripts show the one that is chosen.
std::string legends(const RunData& run) {
  std::string bar = "linear-gradient(90deg";
  for (int i = 0; i <= 8; ++i) bar += ", " + css(scale_colour(i / 8.0, false));
  bar += ")";
  const Range z = range_of_points(run.map, 2);
  const ErrorScale error = error_scale(run.map);
  std::string vehicles;
  for (std::size_t i = 0; i < run.vehicles.size(); ++i) {
    vehicles += fmt::format("<i style=\"background:{}\"></i> {} ", css(style_of(i).colour),
                            escaped(run.vehicles[i].name));
  }
  const bool blind = std::any_of(run.vehicles.begin(), run.vehicles.end(),
                                 [](const auto& v) { return v.in_map && !v.blind.empty(); });
  return fmt::format(
      "<p class=\"legend keys\"><span data-colour=\"height\">{} <i class=\"bar\" "
      "style=\"background:{}\"></i> {} height z</span><span data-colour=\"sigma\" hidden>{} <i "
      "class=\"bar\" style=\"background:{}\"></i> {} expected error, 1 sigma</span><span "
      "data-colour=\"vehicle\" hidden>{}</span><span>lines: ways of the vehicles{}</span></p>\n",
      metres(z.empty() ? Number() : Number(z.low())), bar,
      metres(z.empty() ? Number() : Number(z.high())),
      metres(error.known ? Number(error.high_m) : Number()), bar,
      metres(error.known ? Number(error.low_m) : Number()), vehicles,
      blind ? ", with an orange border where the LiDAR was blind" : "");
}

Json scene_json(const RunData& run) {
  std::array<Range, 3> box;
  geometry::Vec3 centre;
  for (std::size_t a = 0; a < 3; ++a) {
    box[a] = range_of_points(run.map, a).widened(0.01, 0.1);
    centre[static_cast<Eigen::Index>(a)] = 0.5 * (box[a].low() + box[a].high());
  }
  Json json;
  pack_points(run.map, box, centre, json);
  json["colours"] = colours();
  json["vehicle_colours"] = Json::array();
  json["ways"] = Json::array();
  for (std::size_t i = 0; i < run.vehicles.size(); ++i) {
    const VehicleView& v = run.vehicles[i];
    json["vehicle_colours"].push_back(style_of(i).colour);
    if (!v.in_map) continue;
    json["ways"].push_back({{"name", v.name},
                            {"colour", css(style_of(i).colour)},
                            {"points", packed_way(v.way, centre)},
                            {"blind", packed_way(blind_part(v), centre)}});
    if (v.truth.empty()) continue;
    json["ways"].push_back({{"name", v.name + " truth"},
                            {"truth", true},
                            {"colour", css(kTruthColour)},
                            {"points", packed_way(v.truth, centre)}});
  }
  if (run.vehicles.empty()) json["vehicle_colours"].push_back(style_of(0).colour);
  return json;
}

}  // namespace

Section view3d_section(const RunData& run) {
  Section section{"view", "Map to turn", ""};
  if (run.map.size() == 0) {
    section.html = absent("There is no map.pcd or map.ply with points.");
    return section;
  }
  if (assets::script().empty()) {
    section.html = absent(
        "This program was built without the 3-D view; map.ply opens in "
        "CloudCompare.");
    return section;
  }
  const Json json = scene_json(run);
  section.html = fmt::format(
      "<p class=\"tools\"><label>colour <select id=\"view3d-colour\"><option "
      "value=\"height\">height"
      "</option><option value=\"sigma\">expected error</option><option value=\"vehicle\">vehicle"
      "</option></select></label> <label>cut at <input type=\"range\" id=\"view3d-cut\" min=\"1\" "
      "max=\"100\" value=\"75\"> of the height</label> <button id=\"view3d-home\">whole "
      "map</button> <span "
      "class=\"note\">drag to turn, right button to move, click and wheel to zoom; {} of {} points "
      "are drawn</span>"
      "</p>\n{}<div id=\"view3d\" class=\"view3d\"><p class=\"absent\">The 3-D view needs scripts."
      "</p></div>\n<script type=\"application/json\" id=\"view3d-data\">{}</script>\n",
      counted(static_cast<double>(json["count"].get<std::size_t>())),
      counted(static_cast<double>(run.map_file_points)), legends(run), script_json(json));
  return section;
}

}  // namespace rali::report
