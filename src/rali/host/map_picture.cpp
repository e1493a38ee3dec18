#include "rali/host/map_picture.hpp"

#include <cmath>
#include <cstring>
#include <utility>

#include "rali/fleet/facts/keyframe_number.hpp"
#include "rali/map/voxel_index.hpp"

namespace rali::host {
namespace {

constexpr double kRedraw_m = 0.1, kRedraw_rad = 0.01;
constexpr double kMoved_m = 0.01;
constexpr double kGrow = 1.4;

/// Appends values byte by byte, as in PointCloud2.
template <class T>
void append(wire::Bytes& data, T value) {
  const std::size_t at = data.size();
  data.resize(at + sizeof(T));
  std::memcpy(data.data() + at, &value, sizeof(T));
}

void append_point(wire::Bytes& data, const geometry::Vec3& p) {
  for (int i = 0; i < 3; ++i) append(data, static_cast<float>(p[i]));
}

/// x y z, then the fields given.
wire::PackedCloud packed(Time t, wire::Bytes data, std::vector<wire::CloudField> more,
                         std::uint32_t step) {
  wire::PackedCloud cloud;
  cloud.data = std::move(data);
  cloud.view.stamp = t;
  cloud.view.frame_id = "map";
  cloud.view.height = 1;
  cloud.view.width = static_cast<std::uint32_t>(cloud.data.size() / step);
  cloud.view.point_step = step;
  cloud.view.row_step = static_cast<std::uint32_t>(cloud.data.size());
  cloud.view.fields = {{"x", 0, wire::FieldType::kFloat32, 1},
                       {"y", 4, wire::FieldType::kFloat32, 1},
                       {"z", 8, wire::FieldType::kFloat32, 1}};
  for (wire::CloudField& field : more) cloud.view.fields.push_back(std::move(field));
  cloud.view.data = cloud.data;
  return cloud;
}

geometry::Vec3 point_of(const fleet::PointArrays& points, std::size_t i) {
  return {static_cast<double>(points.x_m[i]), static_cast<double>(points.y_m[i]),
          static_cast<double>(points.z_m[i])};
}

fleet::PointArrays points_of(const fleet::Fact& fact) {
  return std::get<fleet::KeyframePoints>(fact.body).points.unpacked();
}

}  // namespace

MapNews MapNewsReader::read(const fleet::Node& node) {
  MapNews news;
  news.own = {node.store().self(), node.epoch()};
  news.T_map_local = node.T_map_odom();
  news.poses.reserve(node.map_poses().size());
  for (const auto& [id, pose] : node.map_poses()) news.poses.emplace_back(id, pose.T_map_body);
  const fleet::FactStore& store = node.store();
  for (const fleet::StreamInventory& stream : store.streams()) {
    fleet::SeqSet& seen = seen_[stream.stream];
    const fleet::SeqSet& held = store.held(stream.stream);
    for (auto seq = seen.first_lacking(held, 0); seq; seq = seen.first_lacking(held, *seq + 1)) {
      seen.insert(*seq);
      fleet::FactPtr fact = store.find({stream.stream.vehicle, stream.stream.epoch, *seq});
      if (fact) news.facts.push_back(std::move(fact));
    }
  }
  return news;
}

void MapPicture::update(const MapNews& news) {
  for (const fleet::FactPtr& fact : news.facts) take(fact);
  place(news);
}

void MapPicture::take(const fleet::FactPtr& fact) {
  if (const auto* points = std::get_if<fleet::KeyframePoints>(&fact->body)) {
    Keyframe& keyframe = keyframes_[{fact->key.vehicle, points->keyframe}];
    if (points->refinement || keyframe.points) return;
    keyframe.points = fact;
    keyframe.t = fact->t;
  } else if (const auto* step = std::get_if<fleet::Increment>(&fact->body)) {
    if (!step->keyframe) return;
    Keyframe& keyframe = keyframes_[{fact->key.vehicle, *step->keyframe}];
    keyframe.t = fact->t;
    keyframe.T_local_body = step->T_odom_body;
    keyframe.degenerate = step->degenerate;
    keyframe.has_step = true;
  }
}

/// The table's poses; newer keyframes of each vehicle continue by its odometry.
void MapPicture::place(const MapNews& news) {
  auto known = news.poses.begin();
  moving_ = {};
  std::optional<geometry::SE3> T_map_local;
  std::optional<fleet::StreamKey> stream;
  for (auto& [id, keyframe] : keyframes_) {
    if (!keyframe.has_step) continue;
    const fleet::StreamKey of{id.vehicle, fleet::epoch_of_keyframe(id.seq)};
    if (stream != of) {  // each start has a frame of its own
      stream = of;
      T_map_local.reset();
      frames_.erase(id.vehicle);
      if (of == news.own) T_map_local = news.T_map_local;
    }
    while (known != news.poses.end() && known->first < id) ++known;
    if (known != news.poses.end() && known->first == id) {
      T_map_local = known->second * keyframe.T_local_body.inverse();
      frames_[id.vehicle] = *T_map_local;
      move_to(keyframe, id.vehicle, known->second);
    } else if (T_map_local) {
      move_to(keyframe, id.vehicle, *T_map_local * keyframe.T_local_body);
    }
    draw(id, keyframe);
  }
  if (moving_.keyframes > 0) move_ = moving_;
}

void MapPicture::move_to(Keyframe& keyframe, VehicleId vehicle, const geometry::SE3& T_map_body) {
  if (!keyframe.T_map_body) {
    keyframe.T_map_body = keyframe.T_drawn = T_map_body;
    return;
  }
  const double shift_m = (keyframe.T_map_body->p - T_map_body.p).norm();
  if (shift_m > kMoved_m) ++moving_.keyframes;
  if (shift_m > moving_.metres) {
    moving_.metres = shift_m;
    moving_.vehicle = vehicle;
  }
  keyframe.T_map_body = T_map_body;
  const double turn_rad = geometry::so3_log(keyframe.T_drawn.R.transpose() * T_map_body.R).norm();
  if ((keyframe.T_drawn.p - T_map_body.p).norm() > kRedraw_m || turn_rad > kRedraw_rad) {
    keyframe.T_drawn = T_map_body;
    keyframe.is_new = true;
  }
}

void MapPicture::draw(KeyframeId id, Keyframe& keyframe) {
  if (!keyframe.points || !keyframe.T_map_body) return;
  if (keyframe.in_grid) {
    grid_.move(id, *keyframe.T_map_body);
    return;
  }
  const auto& seen = std::get<fleet::KeyframePoints>(keyframe.points->body);
  const fleet::PointArrays points = seen.points.unpacked();
  map::KeyframeView view;
  view.t = keyframe.t;
  view.vehicle = static_cast<std::uint8_t>(id.vehicle.value);
  view.T_map_body = *keyframe.T_map_body;
  view.T_body_lidar = seen.T_body_lidar;
  view.x_m = points.x_m;
  view.y_m = points.y_m;
  view.z_m = points.z_m;
  keyframe.in_grid = grid_.add(id, view);
}

std::optional<wire::PackedCloud> MapPicture::take_delta(Time t) {
  wire::Bytes data;
  for (auto& [id, keyframe] : keyframes_) {
    if (!keyframe.is_new || !keyframe.points || !keyframe.T_map_body) continue;
    keyframe.is_new = false;
    const fleet::PointArrays points = points_of(*keyframe.points);
    for (std::size_t i = 0; i < points.size(); ++i) {
      append_point(data, *keyframe.T_map_body * point_of(points, i));
      append(data, id.seq);
      append(data, static_cast<std::uint8_t>(id.vehicle.value));
    }
  }
  if (data.empty()) return std::nullopt;
  return packed(
      t, std::move(data),
      {{"keyframe", 12, wire::FieldType::kUint32, 1}, {"vehicle", 16, wire::FieldType::kUint8, 1}},
      17);
}

std::optional<wire::PackedCloud> MapPicture::whole(Time t, double voxel_m,
                                                   std::size_t points_max) const {
  for (double side_m = voxel_m;; side_m *= kGrow) {
    map::VoxelIndex index;
    wire::Bytes data;
    bool fits = true;
    for (const auto& [id, keyframe] : keyframes_) {
      if (!keyframe.points || !keyframe.T_map_body) continue;
      const fleet::PointArrays points = points_of(*keyframe.points);
      for (std::size_t i = 0; i < points.size() && fits; ++i) {
        const geometry::Vec3 p_map = *keyframe.T_map_body * point_of(points, i);
        const map::VoxelKey key = map::voxel_key(p_map, side_m);
        if (key == map::kNoVoxel || !index.insert(key).is_new) continue;
        append_point(data, p_map);
        append(data, static_cast<std::uint8_t>(id.vehicle.value));
        append(data, static_cast<float>(seconds_between(keyframe.t, t)));
        fits = index.size() <= points_max;
      }
    }
    if (!fits) continue;
    if (data.empty()) return std::nullopt;
    return packed(
        t, std::move(data),
        {{"vehicle", 12, wire::FieldType::kUint8, 1}, {"age_s", 13, wire::FieldType::kFloat32, 1}},
        17);
  }
}

std::optional<wire::GridMessage> MapPicture::grid(Time t) const {
  const Result<map::CellMap> cells = grid_.picture();
  if (!cells || cells->cells.empty()) return std::nullopt;
  wire::GridMessage message;
  message.stamp = t;
  message.frame_id = "map";
  message.cell_m = static_cast<float>(cells->cell_m);
  message.width = static_cast<std::uint32_t>(cells->width);
  message.height = static_cast<std::uint32_t>(cells->height);
  message.origin_m = cells->origin_map_m;
  message.cells.reserve(cells->cells.size());
  for (const map::CellState state : cells->cells) {
    const bool known = state != map::CellState::kUnknown;
    const std::int8_t value = state == map::CellState::kOccupied ? 100 : 0;
    message.cells.push_back(known ? value : std::int8_t{-1});
  }
  return message;
}

std::map<VehicleId, std::vector<MapPicture::PathPoint>> MapPicture::paths() const {
  std::map<VehicleId, std::vector<PathPoint>> paths;
  for (const auto& [id, keyframe] : keyframes_) {
    if (!keyframe.T_map_body) continue;
    paths[id.vehicle].push_back({keyframe.t, keyframe.T_map_body->p, keyframe.degenerate});
  }
  return paths;
}

}  // namespace rali::host
