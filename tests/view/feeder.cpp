// rali_view_feeder [--port N] [--speed X] [--until S] [--wait]: an invented fleet in a mine on the
// live page. --wait: starts when a viewer connects. Prints the address; ends by SIGTERM.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <thread>

#include <fmt/format.h>

#include "mine.hpp"
#include "mine_state.hpp"
#include "rali/view/view_server.hpp"
#include "rali/wire/definitions.hpp"
#include "rali/wire/encode.hpp"

namespace rali::view_demo {
namespace {

volatile std::sig_atomic_t g_stop = 0;

struct Arguments {
  int port = 8765;
  double speed = 1.0, until_s = kEnd_s;
  bool wait = false;
};

struct Seen {
  Point p;
  int vehicle;
  double t_s;
};

/// A PointCloud2 of x, y, z, vehicle, age_s.
wire::Bytes cloud_bytes(const std::vector<Seen>& points, double t_s) {
  constexpr std::uint32_t kStep = 17;
  wire::Bytes data(points.size() * kStep);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto age = static_cast<float>(t_s - points[i].t_s);
    std::byte* at = data.data() + i * kStep;
    std::memcpy(at, &points[i].p, 12);
    at[12] = static_cast<std::byte>(points[i].vehicle);
    std::memcpy(at + 13, &age, 4);
  }
  const auto n = static_cast<std::uint32_t>(points.size());
  const auto f32 = wire::FieldType::kFloat32;
  return wire::encode({.stamp = Time::from_s(t_s),
                       .frame_id = "map",
                       .height = 1,
                       .width = n,
                       .point_step = kStep,
                       .row_step = n * kStep,
                       .fields = {{"x", 0, f32},
                                  {"y", 4, f32},
                                  {"z", 8, f32},
                                  {"vehicle", 12, wire::FieldType::kUint8},
                                  {"age_s", 13, f32}},
                       .data = data},
                      wire::Encoding::kCdr);
}

/// Unknown, free and occupied cells as nav_msgs/OccupancyGrid.
wire::Bytes plan_bytes(const std::vector<Seen>& points, double t_s) {
  constexpr int kWidth = 440, kHeight = 360;
  constexpr double kCell_m = 0.25, kX0_m = -8.0, kY0_m = -42.0;
  wire::Bytes cells(kWidth * kHeight, std::byte{0xFF});
  for (const Seen& s : points) {
    const int x = static_cast<int>((double{s.p.x_m} - kX0_m) / kCell_m);
    const int y = static_cast<int>((double{s.p.y_m} - kY0_m) / kCell_m);
    if (x < 0 || y < 0 || x >= kWidth || y >= kHeight || s.p.z_m > 1.5F) continue;
    std::byte& cell = cells[static_cast<std::size_t>(y * kWidth + x)];
    if (s.p.z_m > 0.4F)
      cell = std::byte{100};
    else if (cell != std::byte{100})
      cell = std::byte{0};
  }
  wire::ByteWriter out(wire::Encoding::kCdr);
  out.header(Time::from_s(t_s), "map");
  out.time(Time::from_s(t_s));
  out.put(static_cast<float>(kCell_m));
  out.put(static_cast<std::uint32_t>(kWidth));
  out.put(static_cast<std::uint32_t>(kHeight));
  for (const double value : {kX0_m, kY0_m, 0.0, 0.0, 0.0, 0.0, 1.0}) out.put(value);
  out.sequence(cells.size());
  out.bytes(cells);
  return out.take();
}

std::span<const std::uint8_t> raw(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()};
}

class Feeder {
 public:
  explicit Feeder(view::ViewServer& server) : server_(server), hidden_(mine_points()) {
    const auto json = [&](const char* topic, const char* schema) {
      return server.add_channel(
          {topic, "json", schema, "jsonschema", R"({"type":"object"})", true});
    };
    const std::string cloud =
        wire::message_definition("sensor_msgs/msg/PointCloud2", wire::Encoding::kCdr);
    const auto cdr = [&](std::string topic, const char* schema, bool keep) {
      return server.add_channel({std::move(topic), "cdr", schema, "ros2msg", cloud, keep});
    };
    state_ = json("/rali/state", "rali/State");
    paths_ = json("/rali/paths", "rali/Paths");
    map_ = cdr("/map_cloud", "sensor_msgs/msg/PointCloud2", true);
    for (int v = 0; v < kVehicles; ++v) {
      delta_[static_cast<std::size_t>(v)] =
          cdr(fmt::format("/v{}/map_delta", v + 1), "sensor_msgs/msg/PointCloud2", false);
    }
    plan_ = server.add_channel({"/map", "cdr", "nav_msgs/msg/OccupancyGrid", "ros2msg", "", true});
  }

  void step(double t_s) {
    const Time t = Time::from_s(t_s);
    for (int v = 0; v < kVehicles; ++v) {
      const std::vector<Seen> fresh = look_around(v, t_s);
      if (!fresh.empty())
        server_.publish(delta_[static_cast<std::size_t>(v)], t, raw(cloud_bytes(fresh, t_s)));
      seen_.insert(seen_.end(), fresh.begin(), fresh.end());
    }
    const bool moves = t_s >= kTableMoves_s && !moved_;
    if (moves) put_right();
    const int second = static_cast<int>(t_s);
    if (moves || second % 30 == 29) server_.publish(map_, t, raw(cloud_bytes(seen_, t_s)));
    if (second % 5 == 0) server_.publish(plan_, t, raw(plan_bytes(seen_, t_s)));
    if (moves || second % 10 == 0) publish_text(paths_, t, paths_at(t_s));
    publish_text(state_, t, state_at(t_s));
    server_.set_health(true, fmt::format(R"({{"state":"ok","t_s":{:.1f}}})", t_s));
    server_.set_metrics(fmt::format("rali_term {}\n", anchor_at(t_s) + 1));
    for (const view::OperatorRequest& order : server_.take_requests()) {
      fmt::print("order: {} {}\n", order.command, order.vehicle);
      std::fflush(stdout);
    }
  }

 private:
  void publish_text(int channel, Time t, const std::string& text) {
    server_.publish(channel, t, raw(std::as_bytes(std::span(text))));
  }

  /// Newly visible points of a vehicle; those of v3 are displaced until a table corrects them.
  std::vector<Seen> look_around(int v, double t_s) {
    const Pose pose = pose_of(v, t_s);
    const auto error = static_cast<float>(v == 2 ? gallery_error_m(t_s) : 0.0);
    std::vector<Seen> fresh;
    std::erase_if(hidden_, [&](const Point& p) {
      if (std::hypot(double{p.x_m} - pose.x_m, double{p.y_m} - pose.y_m) > 9.0) return false;
      fresh.push_back({{p.x_m + error, p.y_m + 0.5F * error, p.z_m}, v, t_s});
      return true;
    });
    return fresh;
  }

  void put_right() {
    moved_ = true;
    for (Seen& s : seen_) {
      if (s.vehicle != 2) continue;
      const auto error = static_cast<float>(gallery_error_m(s.t_s));
      s.p.x_m -= error;
      s.p.y_m -= 0.5F * error;
    }
  }

  view::ViewServer& server_;
  std::vector<Point> hidden_;
  std::vector<Seen> seen_;
  std::array<int, kVehicles> delta_{};
  int state_ = 0, paths_ = 0, map_ = 0, plan_ = 0;
  bool moved_ = false;
};

Arguments parse(int argc, char** argv) {
  Arguments out;
  for (int i = 1; i < argc; ++i) {
    const std::string_view word = argv[i];
    const char* value = i + 1 < argc ? argv[i + 1] : "0";
    if (word == "--wait") out.wait = true;
    if (word == "--port") out.port = std::atoi(value);
    if (word == "--speed") out.speed = std::max(std::atof(value), 0.01);
    if (word == "--until") out.until_s = std::clamp(std::atof(value), 0.0, kEnd_s);
  }
  return out;
}

int feed(const Arguments& arguments) {
  view::ViewOptions options;
  options.port = static_cast<std::uint16_t>(arguments.port);
  auto server = view::start_view_server(options);
  if (!server) {
    fmt::print(stderr, "{}\n", server.error().message());
    return 4;
  }
  fmt::print("http://127.0.0.1:{}\n", (*server)->port());
  std::fflush(stdout);
  Feeder feeder(**server);
  const auto pause = [](double s) {
    std::this_thread::sleep_for(std::chrono::duration<double>(s));
  };
  while (arguments.wait && (*server)->viewers() == 0 && g_stop == 0) pause(0.05);
  if (arguments.wait) pause(1.5);  // time for it to subscribe
  double t_s = 0.0;
  for (; t_s <= arguments.until_s && g_stop == 0; t_s += 1.0) {
    feeder.step(t_s);
    pause(1.0 / arguments.speed);
  }
  fmt::print("at {} s\n", t_s - 1.0);
  std::fflush(stdout);
  while (g_stop == 0) pause(0.1);
  return 0;
}

}  // namespace
}  // namespace rali::view_demo

int main(int argc, char** argv) {
  std::signal(SIGTERM, [](int) { rali::view_demo::g_stop = 1; });
  std::signal(SIGINT, [](int) { rali::view_demo::g_stop = 1; });
  return rali::view_demo::feed(rali::view_demo::parse(argc, argv));
}
