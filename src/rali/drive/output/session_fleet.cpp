#include "rali/drive/output/session_fleet.hpp"

#include <algorithm>
#include <cstring>
#include <map>
#include <tuple>

#include <fmt/format.h>

#include "rali/map/voxel_index.hpp"

namespace rali::drive {
namespace {

using Colour = std::array<float, 4>;

constexpr Colour kGreen{0.0F, 0.62F, 0.45F, 0.9F};  // distinct for most colour-blind people
constexpr Colour kRed{0.84F, 0.37F, 0.0F, 0.9F};
constexpr Colour kGrey{0.6F, 0.6F, 0.6F, 0.6F};
constexpr Colour kYellow{0.94F, 0.89F, 0.26F, 0.9F};

constexpr int kMaps = 16;                       ///< number of map clouds over a run
constexpr std::size_t kMapPointsMax = 100'000;  ///< of one cloud
constexpr std::size_t kVoxelsMax = 2 * kMapPointsMax;
constexpr double kMapVoxel_m = 0.3;
constexpr double kRangeSpan_s = 1.0;   ///< of one message
constexpr double kRangeSpace_s = 0.2;  ///< between two lines of a pair and a colour
constexpr double kLine_m = 0.03;
constexpr double kFrontier_m = 0.6;

wire::Marker marker(Time t, const char* ns, wire::Marker::Type type, double size_m) {
  wire::Marker m;
  m.stamp = t;
  m.frame_id = "map";
  m.ns = ns;
  m.type = type;
  m.scale_m = {size_m, size_m, size_m};
  return m;
}

/// All points so far, one per cube. Points of a single keyframe are left out: most are dynamic.
class ThinMap {
 public:
  void add(const map::KeyframeView& keyframe) {
    ++keyframe_;
    for (std::size_t i = 0; i < keyframe.size(); ++i) {
      const geometry::Vec3 p_map = keyframe.T_map_body * keyframe.point_body(i);
      const float intensity = keyframe.intensity.empty() ? 0.0F : keyframe.intensity[i];
      add({p_map.cast<float>(), intensity, keyframe.vehicle, keyframe_, 1});
    }
    while (points_.size() > kVoxelsMax) coarsen();
  }

  [[nodiscard]] wire::CloudView view(Time t, std::vector<std::byte>& data) const {
    constexpr std::size_t kStep = 20;
    data.clear();
    for (const Point& point : points_) {
      if (point.seen < 2) continue;
      const std::size_t at = data.size();
      data.resize(at + kStep);
      std::memcpy(&data[at], point.p_map_m.data(), 12);
      std::memcpy(&data[at + 12], &point.intensity, 4);
      std::memcpy(&data[at + 16], &point.vehicle, 1);
    }
    wire::CloudView view;
    view.stamp = t;
    view.frame_id = "map";
    view.height = 1;
    view.width = static_cast<std::uint32_t>(data.size() / kStep);
    view.point_step = kStep;
    view.row_step = static_cast<std::uint32_t>(data.size());
    view.fields = {{"x", 0, wire::FieldType::kFloat32, 1},
                   {"y", 4, wire::FieldType::kFloat32, 1},
                   {"z", 8, wire::FieldType::kFloat32, 1},
                   {"intensity", 12, wire::FieldType::kFloat32, 1},
                   {"vehicle", 16, wire::FieldType::kUint8, 1}};
    view.data = data;
    return view;
  }

 private:
  struct Point {
    Eigen::Vector3f p_map_m;
    float intensity = 0.0F;
    std::uint8_t vehicle = 0;
    std::uint32_t keyframe = 0;  ///< the last one that observed it
    std::uint32_t seen = 0;      ///< number of keyframes
  };

  void add(const Point& point) {
    const map::VoxelKey key = map::voxel_key(point.p_map_m.cast<double>(), voxel_m_);
    if (key == map::kNoVoxel) return;
    const map::VoxelIndex::Slot slot = index_.insert(key);
    if (slot.is_new) {
      points_.push_back(point);
      return;
    }
    Point& known = points_[slot.index];
    if (known.keyframe != point.keyframe) known.seen += point.seen;
    known.keyframe = point.keyframe;
  }

  void coarsen() {
    voxel_m_ *= 1.5;
    const std::vector<Point> old = std::move(points_);
    points_.clear();
    index_ = map::VoxelIndex();
    for (const Point& point : old) add(point);
  }

  double voxel_m_ = kMapVoxel_m;
  std::uint32_t keyframe_ = 0;
  map::VoxelIndex index_;
  std::vector<Point> points_;
};

/// Vehicle poses of the final map at any time.
struct Places {
  std::map<VehicleId, FinalPath> paths;
  std::map<KeyframeId, geometry::Vec3> keyframes;
  Time begin, end;

  explicit Places(const FleetRunView& fleet) {
    bool any = false;
    for (const VehicleRun* run : fleet.mapped) {
      paths.emplace(fleet.id_of(*run), FinalPath(run->poses(), run->T_map_local()));
      for (const KeyframeRecord& record : run->keyframes()) {
        if (record.diverged) continue;
        keyframes[record.id] = (run->T_map_local() * record.T_local_body).p;
        begin = any ? std::min(begin, record.t) : record.t;
        end = any ? std::max(end, record.t) : record.t;
        any = true;
      }
    }
  }

  /// Time of a map cloud, 1 to kMaps.
  [[nodiscard]] Time picture(int number) const {
    if (number >= kMaps) return end;
    return begin + Duration::from_s(seconds_between(begin, end) * number / kMaps);
  }
};

Status show_map(const FleetRunView& fleet, const Places& places, SessionFile& session) {
  ThinMap map;
  std::vector<std::byte> data;
  int next = 1;
  const auto show_before = [&](Time t) -> Status {
    for (; next < kMaps && places.picture(next) < t; ++next) {
      const Time at = places.picture(next);
      if (Status s = session.add_cloud("/map", map.view(at, data)); !s) return s;
    }
    return {};
  };
  const Status walked = walk_keyframes(fleet, [&](KeyframeId, const map::KeyframeView& keyframe) {
    if (Status s = show_before(keyframe.t); !s) return s;
    map.add(keyframe);
    return Status{};
  });
  if (!walked) return walked;
  return session.add_cloud("/map", map.view(places.end, data));
}

void add_line(const geometry::Vec3& a, const geometry::Vec3& b, const Colour& colour,
              wire::Marker& lines) {
  lines.points_m.push_back(a);
  lines.points_m.push_back(b);
  lines.colors.push_back(colour);
  lines.colors.push_back(colour);
}

Status show_loops(const fleet::FleetEstimate& estimate, const Places& places,
                  SessionFile& session) {
  if (estimate.loops.empty()) return {};
  wire::MarkerArray array;
  array.markers.push_back(marker({}, "loops", wire::Marker::kLineList, kLine_m));
  wire::Marker& lines = array.markers.front();
  std::size_t next = 0;
  for (int number = 1; number <= kMaps; ++number) {
    const Time t = places.picture(number);
    for (; next < estimate.loops.size(); ++next) {
      const fleet::LoopVerdict& loop = estimate.loops[next];
      if (number < kMaps && std::max(loop.t_from, loop.t_to) > t) break;
      const auto from = places.keyframes.find(loop.from), to = places.keyframes.find(loop.to);
      if (from == places.keyframes.end() || to == places.keyframes.end()) continue;
      add_line(from->second, to->second, loop.accepted ? kGreen : kRed, lines);
    }
    if (lines.points_m.empty()) continue;
    lines.stamp = t;
    if (Status s = session.add_markers("/loops", t, array); !s) return s;
  }
  return {};
}

Colour colour_of(const ranging::RangeUse& use) {
  if (use.used()) return kGreen;
  const bool idle = use.reason == ranging::RangeReason::kDuplicate ||
                    use.reason == ranging::RangeReason::kNotNeeded;
  return idle ? kGrey : kRed;
}

std::optional<geometry::Vec3> antenna_at(const Places& places, const MapJob& job, Time t,
                                         VehicleId vehicle, std::uint8_t antenna) {
  const auto path = places.paths.find(vehicle);
  if (path == places.paths.end()) return std::nullopt;
  const auto T_map_body = path->second.at(t);
  if (!T_map_body) return std::nullopt;
  const auto& antennas = job.vehicles[vehicle.value].settings.antennas_body_m;
  return antenna < antennas.size() ? *T_map_body * antennas[antenna] : T_map_body->p;
}

Status show_ranges(const RangeLog& ranges, const MapJob& job, const Places& places,
                   SessionFile& session) {
  using Link = std::tuple<VehicleId, VehicleId, Colour>;
  std::map<Link, Time> drawn;
  wire::MarkerArray array;
  array.markers.push_back(marker({}, "ranges", wire::Marker::kLineList, kLine_m));
  wire::Marker& lines = array.markers.front();
  const auto show = [&](Time t) -> Status {
    lines.stamp = t;
    const Status status = session.add_markers("/ranges", t, array);
    lines.points_m.clear();
    lines.colors.clear();
    return status;
  };
  Time begin, last;
  for (const ranging::RangeUse* use : ranges.in_order()) {
    const sensor::RangeSample& s = use->sample;
    const auto a = antenna_at(places, job, s.t, s.from, s.from_antenna);
    const auto b = antenna_at(places, job, s.t, s.to, s.to_antenna);
    if (!a || !b) continue;
    const auto [low, high] = std::minmax(s.from, s.to);
    const auto known = drawn.find({low, high, colour_of(*use)});
    if (known != drawn.end() && seconds_between(known->second, s.t) < kRangeSpace_s) continue;
    drawn[{low, high, colour_of(*use)}] = s.t;
    if (!lines.points_m.empty() && seconds_between(begin, s.t) > kRangeSpan_s) {
      if (Status shown = show(last); !shown) return shown;
    }
    if (lines.points_m.empty()) begin = s.t;
    last = s.t;
    add_line(*a, *b, colour_of(*use), lines);
  }
  return lines.points_m.empty() ? Status{} : show(last);
}

Colour colour_of(map::FrontierState state) {
  switch (state) {
    case map::FrontierState::kOpen:
      return kYellow;
    case map::FrontierState::kExplored:
      return kGreen;
    case map::FrontierState::kUnreachable:
      return kRed;
    case map::FrontierState::kTooSmall:
      break;
  }
  return kGrey;
}

/// Frontiers are 2-D: shown at the height of the vehicles.
wire::MarkerArray frontier_markers(Time t, double z_m, std::span<const fleet::FrontierRow> rows) {
  wire::MarkerArray array;
  array.markers.push_back(marker(t, "frontiers", wire::Marker::kSphereList, kFrontier_m));
  array.markers.front().action = wire::Marker::kDeleteAll;
  array.markers.push_back(marker(t, "frontiers", wire::Marker::kSphereList, kFrontier_m));
  for (const fleet::FrontierRow& row : rows) {
    const geometry::Vec3 place(row.x_m, row.y_m, z_m);
    array.markers[1].points_m.push_back(place);
    array.markers[1].colors.push_back(colour_of(row.state));
    if (row.state != map::FrontierState::kOpen) continue;
    wire::Marker text = marker(t, "frontier names", wire::Marker::kText, kFrontier_m);
    text.id = static_cast<std::int32_t>(row.id);
    text.T_frame_marker.p = place + geometry::Vec3(0.0, 0.0, kFrontier_m);
    text.text = fmt::format("{}: {:.1f} m", row.id, row.length_m);
    array.markers.push_back(std::move(text));
  }
  return array;
}

Status show_frontiers(const FleetRounds& rounds, const Places& places, SessionFile& session) {
  const std::span<const fleet::FrontierRow> rows = rounds.frontiers;
  for (std::size_t begin = 0; begin < rows.size();) {
    std::size_t end = begin;
    while (end < rows.size() && rows[end].round == rows[begin].round) ++end;
    const std::uint32_t round = rows[begin].round;
    const Time t = round > 0 ? rounds.rounds[round - 1].end.value_or(places.end) : places.end;
    double z_m = 0.0;
    for (const auto& path : places.paths) {
      if (const auto at = path.second.last_known(t)) z_m = at->p.z();
    }
    const wire::MarkerArray array = frontier_markers(t, z_m, rows.subspan(begin, end - begin));
    if (Status s = session.add_markers("/frontiers", t, array); !s) return s;
    begin = end;
  }
  return {};
}

}  // namespace

Status show_fleet(const FleetRunView& fleet, const MapJob& job,
                  const fleet::FleetEstimate& estimate, const RangeLog& ranges,
                  const FleetRounds& rounds, SessionFile& session) {
  if (fleet.mapped.empty()) return {};
  const Places places(fleet);
  if (Status s = show_map(fleet, places, session); !s) return s;
  if (Status s = show_loops(estimate, places, session); !s) return s;
  if (Status s = show_ranges(ranges, job, places, session); !s) return s;
  return show_frontiers(rounds, places, session);
}

Result<std::vector<fleet::RoundRow>> write_fleet_story(const FleetRunView& fleet, const MapJob& job,
                                                       const fleet::FleetEstimate& estimate,
                                                       const RangeLog& ranges, SessionFile* session,
                                                       FindingList& findings) {
  if (fleet.runs->size() < 2) return std::vector<fleet::RoundRow>{};
  FleetRounds rounds;
  if (job.rounds.from != RoundsFrom::kOff) {
    std::vector<double> rest_s;
    for (const VehicleJob& v : job.vehicles) rest_s.push_back(v.settings.path.rest_s);
    Result<FleetRounds> found = find_rounds(fleet, job.rounds, rest_s, findings);
    if (!found) return tl::make_unexpected(found.error());
    rounds = std::move(*found);
    if (Status s = write_rounds_files(fleet, rounds); !s) return tl::make_unexpected(s.error());
  }
  if (session != nullptr) {
    const Status shown = show_fleet(fleet, job, estimate, ranges, rounds, *session);
    if (!shown) return tl::make_unexpected(shown.error());
  }
  return std::move(rounds.rounds);
}

}  // namespace rali::drive
