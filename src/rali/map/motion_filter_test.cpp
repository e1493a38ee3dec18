#include "rali/map/motion_filter.hpp"

#include <gtest/gtest.h>

#include "rali/map/build_map.hpp"
#include "rali/map/test_world.hpp"

namespace rali::map {
namespace {

using test::Cylinder;
using test::Room;
using test::Scan;

/// A vehicle drives 0.5 m per second along a room while a person (0.5 m wide, 1.7 m tall) crosses
/// its path; a pole of 6 cm stands beside.
struct Drive {
  static constexpr Cylinder kPole{9.0, 7.0, 0.03, 2.5};
  std::vector<Scan> scans;

  explicit Drive(bool with_person) {
    for (int k = 0; k < 12; ++k) {
      Room room;
      room.cylinders.push_back(kPole);
      if (with_person) room.cylinders.push_back({8.5, 1.5 + 0.6 * k, 0.25, 1.7});
      scans.push_back(test::look_around(room, test::pose_at(2.0 + 0.5 * k, 4.0, 0.6), k));
    }
  }

  [[nodiscard]] KeyframeStream stream() const {
    return [this](const KeyframeVisitor& visit) -> Status {
      for (const Scan& s : scans) visit(s.view());
      return {};
    };
  }
};

MapSettings without_grid() {
  MapSettings s;
  s.grid.make = false;
  return s;
}

MapResult mapped(const Drive& drive, const MapSettings& settings = without_grid()) {
  SerialExecutor executor;
  FindingList findings;
  Result<MapResult> result = build_map(drive.stream(), settings, executor, findings);
  EXPECT_TRUE(result.has_value());
  EXPECT_TRUE(findings.empty());
  return std::move(*result);
}

std::size_t points_near(const MapCloud& cloud, double x, double y, double radius_m,
                        double z_min_m) {
  std::size_t n = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const double dx = static_cast<double>(cloud.x_m[i]) - x;
    const double dy = static_cast<double>(cloud.y_m[i]) - y;
    n += std::hypot(dx, dy)<radius_m&& static_cast<double>(cloud.z_m[i])> z_min_m ? 1U : 0U;
  }
  return n;
}

TEST(MotionFilter, removes_nothing_from_a_static_room) {
  const MapResult result = mapped(Drive(false));
  EXPECT_GT(result.map.size(), 10000U);
  EXPECT_EQ(result.removed.size(), 0U);
}

TEST(MotionFilter, removes_a_walking_person_and_keeps_a_6_cm_pole) {
  const Drive drive(true);
  MapSettings keep_all = without_grid();
  keep_all.dynamic.remove = false;
  const MapResult before = mapped(drive, keep_all);
  const MapResult after = mapped(drive);
  std::size_t person_before = 0, person_after = 0;
  for (int k = 0; k < 12; ++k) {
    person_before += points_near(before.map, 8.5, 1.5 + 0.6 * k, 0.3, 0.1);
    person_after += points_near(after.map, 8.5, 1.5 + 0.6 * k, 0.3, 0.1);
  }
  EXPECT_GT(person_before, 300U);
  EXPECT_LT(static_cast<double>(person_after), 0.35 * static_cast<double>(person_before));
  EXPECT_EQ(points_near(after.map, 9.0, 7.0, 0.1, 0.1),
            points_near(before.map, 9.0, 7.0, 0.1, 0.1));
}

TEST(MotionFilter, removes_the_person_but_neither_walls_nor_floor) {
  const MapResult result = mapped(Drive(true));
  ASSERT_GT(result.removed.size(), 100U);
  std::size_t elsewhere = 0;
  for (std::size_t i = 0; i < result.removed.size(); ++i) {
    const bool on_path = std::abs(result.removed.x_m[i] - 8.5F) < 0.35F;
    const bool in_air = result.removed.z_m[i] > 0.05F;
    elsewhere += on_path && in_air ? 0U : 1U;
  }
  EXPECT_LT(static_cast<double>(elsewhere), 0.02 * static_cast<double>(result.removed.size()));
}

TEST(MotionFilter, removes_no_walls_and_reports_a_finding_when_poses_are_wrong) {
  Drive drive(false);
  // Every sixth scan has its pose 1.5 m too far right: rays of the others pass its left wall.
  for (std::size_t k = 0; k < drive.scans.size(); k += 6) drive.scans[k].T_map_body.p.y() -= 1.5;
  MapSettings settings = without_grid();
  settings.dynamic.plane_fraction_max = 0.005;  // one wall of a small room
  SerialExecutor executor;
  FindingList findings;
  const Result<MapResult> result = build_map(drive.stream(), settings, executor, findings);
  ASSERT_TRUE(result.has_value());
  EXPECT_EQ(result->removed.size(), 0U);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].id, "map.dynamic");
}

TEST(MotionFilter, common_pose_covariance_does_not_prevent_removing_a_person) {
  // The map's position may be uncertain by metres: neighbouring keyframes still agree.
  Drive drive(true);
  const std::size_t removed = mapped(drive).removed.size();
  for (Scan& s : drive.scans) s.covariance.diagonal().setConstant(9.0);
  EXPECT_EQ(mapped(drive).removed.size(), removed);
}

TEST(MotionFilter, removes_nothing_when_relative_pose_sigma_exceeds_0_5_m) {
  // Variances 0, 1, 4, 9, ... m2: from one keyframe to the next at least 1 m2, above 0.5 m squared.
  Drive drive(true);
  for (std::size_t k = 0; k < drive.scans.size(); ++k) {
    const auto sigma_m = static_cast<double>(k);
    drive.scans[k].covariance.bottomRightCorner<3, 3>().diagonal().setConstant(sigma_m * sigma_m);
  }
  MapSettings settings = without_grid();
  settings.dynamic.voxel_m = 0.02;  // places of one keyframe each, but for the walls
  EXPECT_EQ(mapped(drive, settings).removed.size(), 0U);
}

TEST(MotionFilter, a_keyframe_whose_rays_pass_walls_is_suspected) {
  Drive drive(true);
  drive.scans[6].T_map_body.p.y() += 1.5;
  SerialExecutor executor;
  MotionFilter filter(DynamicSettings{});
  for (const Scan& s : drive.scans) filter.collect(s.view());
  for (const Scan& s : drive.scans) filter.look(s.view(), executor);
  EXPECT_EQ(filter.suspected(), 1U);
}

/// A scan of a LiDAR that moved by this much during it: all points are given as seen from its last
/// position.
Scan seen_while_moving(Scan scan, double moved_y_m) {
  scan.T_map_body.p.y() += moved_y_m;
  for (float& y_m : scan.y_m) y_m -= static_cast<float>(moved_y_m);
  return scan;
}

// Through a doorway at 0.8 m/s: points seen along the wall from before it are given as seen from
// within it, and the rays between lie in the wall.
TEST(MotionFilter, rays_within_a_wall_plane_do_not_count_as_passing_it) {
  Room room;
  room.partitions.push_back({4.0, 10.0, 5.0});
  std::vector<Scan> scans;
  for (const double x_m : {5.0, 7.0, 9.0}) {
    for (const double y_m : {3.0, 7.0}) {
      scans.push_back(test::look_around(room, test::pose_at(x_m, y_m, 0.6), x_m + y_m));
    }
  }
  for (const double y_m : {5.01, 5.03, 5.05}) {
    Scan scan = test::look_around(room, test::pose_at(10.5, y_m, 0.6), 20.0 + y_m);
    scans.push_back(seen_while_moving(std::move(scan), -0.08));
  }
  SerialExecutor executor;
  MotionFilter filter(DynamicSettings{});
  for (const Scan& s : scans) filter.collect(s.view());
  for (const Scan& s : scans) filter.look(s.view(), executor);
  for (const WallLooks& walls : filter.walls_seen()) EXPECT_EQ(walls.passes, 0U);
}

/// Places on walls that rays of any keyframe pass, while a truck's rear ahead drives off.
/// @param period_s between keyframes
std::size_t passes_of_a_truck(double period_s) {
  SerialExecutor executor;
  MotionFilter filter(DynamicSettings{});
  std::vector<Scan> scans;
  for (int k = 0; k < 6; ++k) {
    Room room;
    room.partitions.push_back({4.0, 8.0, 4.0 + 0.9 * k});
    scans.push_back(test::look_around(room, test::pose_at(6.0, 1.0 + 0.5 * k, 0.6), period_s * k));
  }
  for (const Scan& s : scans) filter.collect(s.view());
  for (const Scan& s : scans) filter.look(s.view(), executor);
  std::size_t passes = 0;
  for (const WallLooks& walls : filter.walls_seen()) passes += walls.passes;
  return passes;
}

// Within seconds a vehicle's own poses are accurate, so what its rays pass then is no wall. With a
// minute in between its pose may be wrong.
TEST(MotionFilter, what_rays_pass_seconds_later_is_no_wall) {
  EXPECT_GT(passes_of_a_truck(60.0), 500U);
  EXPECT_LT(passes_of_a_truck(1.0), 50U);
}

// The first keyframe sees most walls first; rays of a wrong one pass them.
TEST(MotionFilter, counts_walls_per_keyframe_that_a_wrong_keyframe_passes_through) {
  Drive drive(false);
  SerialExecutor executor;
  const auto made = [&] {
    MotionFilter filter(DynamicSettings{});
    for (const Scan& s : drive.scans) filter.collect(s.view());
    for (const Scan& s : drive.scans) filter.look(s.view(), executor);
    return filter.walls_made();
  };
  std::size_t places = 0, passed = 0;
  for (const WallsMade& m : made()) {
    places += m.places;
    passed += m.passed;
  }
  EXPECT_GT(places, 1000U);
  EXPECT_EQ(passed, 0U) << "without a contradiction nobody is named";
  drive.scans[6].T_map_body.p.y() += 1.5;
  const std::vector<WallsMade> wrong = made();
  ASSERT_EQ(wrong.size(), drive.scans.size());
  EXPECT_GT(wrong[0].passed, wrong[0].places / 20);
}

// Two parts of one building, overlapped by a wrong start pose: each vehicle sees thousands of its
// own walls, and its rays pass the few of the other's that cross its path.
TEST(MotionFilter, detects_rays_through_walls_of_another_misaligned_vehicle) {
  const auto seen = [](double yaw_rad) {
    Room hall;
    hall.low_m = {0.0, 3.5, 0.0};
    hall.high_m = {40.0, 6.5, 3.0};
    std::vector<std::pair<std::uint8_t, Scan>> scans;
    for (const double x_m : {5.0, 8.0, 11.0}) {
      scans.emplace_back(0, test::look_around(hall, test::pose_at(x_m, 5.0, 0.6), x_m));
      Scan other = test::look_around(hall, test::pose_at(x_m, 5.0, 0.6), 20.0 + x_m);
      const geometry::SE3 about = test::pose_at(8.0, 5.0, 0.0);
      const geometry::SE3 turn = about * test::pose_at(0.0, 0.0, 0.0, yaw_rad) * about.inverse();
      other.T_map_body = turn * other.T_map_body;
      other.covariance.bottomRightCorner<3, 3>().diagonal().setConstant(4.0);  // stated: 2 m
      scans.emplace_back(1, std::move(other));
    }
    SerialExecutor executor;
    MotionFilter filter(DynamicSettings{});
    const auto view = [](const std::pair<std::uint8_t, Scan>& s) {
      KeyframeView v = s.second.view();
      v.vehicle = s.first;
      return v;
    };
    for (const auto& s : scans) filter.collect(view(s));
    WallLooks sum;
    for (const auto& s : scans) filter.look(view(s), executor);
    for (const WallLooks& looks : filter.walls_seen()) {
      sum.others_looks += looks.others_looks;
      sum.others_passes += looks.others_passes;
    }
    return sum;
  };
  const WallLooks right = seen(0.0);
  EXPECT_GT(right.others_looks, 1000U);
  EXPECT_EQ(right.others_passes, 0U);
  const WallLooks wrong = seen(0.7);
  EXPECT_GT(wrong.others_looks, 300U);
  EXPECT_GT(wrong.others_passes, wrong.others_looks / 2);
}

/// Two vehicles see each other; the second, 0.5 m wide and 0.8 m high, never moves, so that no ray
/// ever passes its place.
struct Meeting {
  static constexpr Cylinder kBody{8.0, 4.0, 0.25, 0.8};
  std::vector<Scan> scans;
  std::vector<geometry::Vec3> bodies_map_m{{8.0, 4.0, 0.6}};
  bool reported = true;

  explicit Meeting(const geometry::Vec3& start_m = {2.0, 4.0, 0.6}) {
    for (int k = 0; k < 8; ++k) {
      Room room;
      room.cylinders.push_back(kBody);
      const geometry::SE3 T = test::pose_at(start_m.x() + 0.5 * k, start_m.y(), start_m.z());
      scans.push_back(test::look_around(room, T, k));
    }
  }

  [[nodiscard]] MapResult map() const {
    SerialExecutor executor;
    FindingList findings;
    const KeyframeStream stream = [this](const KeyframeVisitor& visit) -> Status {
      for (const Scan& s : scans) {
        KeyframeView view = s.view();
        if (reported) view.others_map_m = bodies_map_m;
        visit(view);
      }
      return {};
    };
    Result<MapResult> result = build_map(stream, without_grid(), executor, findings);
    EXPECT_TRUE(result.has_value());
    return std::move(*result);
  }
};

TEST(MotionFilter, removes_the_reported_body_of_another_vehicle_without_passing_rays) {
  Meeting meeting;
  meeting.reported = false;
  const MapResult before = meeting.map();
  EXPECT_GT(points_near(before.map, 8.0, 4.0, 0.4, 0.1), 100U);
  EXPECT_EQ(before.removed.size(), 0U);
  meeting.reported = true;
  EXPECT_EQ(points_near(meeting.map().map, 8.0, 4.0, 0.4, 0.1), 0U);
}

TEST(MotionFilter, keeps_a_wall_0_5_m_from_another_vehicle) {
  // Rings 9 to 17 cm apart on the wall: its plane extends beyond the vehicle's radius.
  Meeting meeting({4.0, 7.5, 0.6});
  meeting.bodies_map_m = {{9.0, 9.5, 0.6}};  // 0.5 m from the wall at y = 10 m
  const MapResult result = meeting.map();
  EXPECT_GT(points_near(result.map, 9.0, 10.0, 0.4, 0.1), 100U);
  EXPECT_EQ(points_near(result.removed, 9.0, 9.5, 2.0, 0.05), 0U);
}

/// Blocks in reverse order, as threads may run them.
class BackwardExecutor final : public Executor {
 public:
  void for_blocks(std::size_t n, std::size_t block,
                  const std::function<void(std::size_t, std::size_t, std::size_t)>& f) override {
    for (std::size_t i = (n + block - 1) / block; i-- > 0;) {
      f(i, i * block, std::min(n, (i + 1) * block));
    }
  }
};

TEST(MotionFilter, the_order_of_the_blocks_does_not_change_the_map) {
  const Drive drive(true);
  const MapResult forward = mapped(drive);
  BackwardExecutor executor;
  FindingList findings;
  const Result<MapResult> backward = build_map(drive.stream(), without_grid(), executor, findings);
  ASSERT_TRUE(backward.has_value());
  EXPECT_EQ(forward.map.x_m, backward->map.x_m);
  EXPECT_EQ(forward.map.sigma_m, backward->map.sigma_m);
  EXPECT_EQ(forward.removed.y_m, backward->removed.y_m);
}

TEST(BuildMap, no_keyframe_is_an_error_not_an_empty_map) {
  SerialExecutor executor;
  FindingList findings;
  const auto result =
      build_map([](const KeyframeVisitor&) -> Status { return {}; }, {}, executor, findings);
  ASSERT_FALSE(result.has_value());
  EXPECT_EQ(result.error().code, ErrorCode::kInput);
}

TEST(BuildMap, returns_the_error_of_an_unreadable_keyframe_file) {
  SerialExecutor executor;
  FindingList findings;
  const auto result = build_map(
      [](const KeyframeVisitor&) -> Status { return fail(ErrorCode::kInput, "5.pcd", "cut"); }, {},
      executor, findings);
  ASSERT_FALSE(result.has_value());
  EXPECT_EQ(result.error().where, "5.pcd");
}

}  // namespace
}  // namespace rali::map
