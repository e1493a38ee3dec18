#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/LU>
#include <fmt/format.h>

#include "common/cpu_time.hpp"
#include "drive.hpp"
#include "parts.hpp"
#include "rali/fleet/frames/commit_gate.hpp"

namespace rali::frames_bench {

using fleet::kDegree;
using fleet::YawPose;
using geometry::Vec2;
using geometry::Vec3;

namespace {

constexpr std::size_t kRanges = 200;
constexpr double kSigma_m = 0.07, kBias_m = 0.10;

/// Paths in the tag's and the anchor's odom frame, and the relative pose of the frames at 0 deg.
struct Geometry {
  const char* name;
  std::vector<Vec2> tag, anchor;
  YawPose T_anchor_tag;
};

std::vector<Vec2> zigzag() {
  std::vector<Vec2> out;
  for (int k = 0; k <= 10; ++k) out.emplace_back(2.0 * k, k % 2 == 0 ? -0.8 : 0.8);
  return out;
}

std::vector<Geometry> geometries() {
  const std::vector<Vec2> straight = {{0, 0}, {20, 0}};
  const std::vector<Vec2> l_left = {{0, 0}, {10, 0}, {10, 10}};
  const YawPose side{0.0, Vec3(0.0, -3.0, 0.0)};
  return {
      {"A1 anchor still, tag straight 20 m, 3 m off", straight, {{0, 0}}, side},
      {"A2 anchor still, tag zigzag +-0.8 m, 20 m", zigzag(), {{0, 0}}, side},
      {"A3 anchor still, tag L 10 + 10 m", l_left, {{0, 0}}, side},
      {"B1 both straight, parallel, equal speed", straight, straight, side},
      {"B2 both straight, parallel, tag twice as fast", straight, {{0, 0}, {10, 0}}, side},
      {"B3 both straight, lines at 60 deg", straight, {{0, 0}, {5, 8.66}}, side},
      {"B4 anchor L 4 + 4, tag L 10 + 10", l_left, {{0, 0}, {4, 0}, {4, -4}}, side},
      {"B5 anchor L 2 + 2, tag zigzag 20 m", zigzag(), {{0, 0}, {2, 0}, {2, -2}}, side},
      {"B6 anchor L 4 + 4, tag straight 20 m", straight, {{0, 0}, {4, 0}, {4, -4}}, side},
  };
}

struct Column {
  std::vector<double> yaw_deg, place_m, stated_yaw_deg, stated_place_m, nees;
  int second = 0, wrong = 0, lost = 0;
  double ms = 0.0;
};

struct Error {
  double yaw_rad = 0.0;
  Vec2 place_m = Vec2::Zero();
  double nees = 0.0, sigma_yaw_rad = 0.0, sigma_m = 0.0;
};

/// Position of the anchor in the tag's frame: ranges to a stationary vehicle determine only this.
Error error_of_place(const fleet::FrameHypothesis& h, const YawPose& truth) {
  Error e;
  const Vec3 seen = h.T_b_a.inverse() * Vec3(Vec3::Zero());
  e.place_m = (seen - truth.inverse() * Vec3(Vec3::Zero())).head<2>();
  const Vec3 in_b = h.T_b_a.turned(Vec3(e.place_m.x(), e.place_m.y(), 0.0));
  const Eigen::Matrix2d I = h.information.block<2, 2>(1, 1);
  e.nees = in_b.head<2>().dot(I * in_b.head<2>()) / 2.0;
  e.sigma_m = std::sqrt(Eigen::Matrix2d(I.inverse()).trace());
  return e;
}

Error error_of_frame(const fleet::FrameHypothesis& h, const YawPose& truth) {
  Error e;
  e.yaw_rad = fleet::wrapped(h.T_b_a.yaw_rad - truth.yaw_rad);
  e.place_m = (h.place_b_m() - truth * h.pivot_a_m).head<2>();
  const Eigen::Vector3d d(e.yaw_rad, e.place_m.x(), e.place_m.y());
  const Eigen::Matrix3d I = h.information.topLeftCorner<3, 3>();
  e.nees = d.dot(I * d) / 3.0;
  const Eigen::Matrix3d C = (I + 1e-6 * Eigen::Matrix3d::Identity()).inverse();
  e.sigma_yaw_rad = std::sqrt(C(0, 0));
  e.sigma_m = std::sqrt(C(1, 1) + C(2, 2));
  return e;
}

void run(const Geometry& g, bool drift, Rng& rng, Column& out) {
  DriveErrors errors;
  if (!drift) errors.scale = errors.yaw_deg_per_sqrt_m = 0.0;
  YawPose truth = g.T_anchor_tag;
  // Headings between those of the search grid, and arbitrary poses of both frames.
  const YawPose turn{rng.uniform(-3.14, 3.14), Vec3::Zero()};
  const Drive tag = drive_along(way_through(g.tag, kRanges), errors, rng);
  Drive anchor = drive_along(way_through(g.anchor, kRanges), errors, rng);
  for (auto* path : {&anchor.true_m, &anchor.odom_m}) {
    for (Vec2& p : *path) p = turn.turned(Vec3(p.x(), p.y(), 0.0)).head<2>();
  }
  truth = turn * truth;
  fleet::InitSettings settings;
  settings.track.spacing_m = settings.track.still_m = 0.0;
  settings.track.samples_max = kRanges;
  fleet::PairTrack track({VehicleId{2}, 0}, {VehicleId{1}, 0}, settings.track);
  for (std::size_t k = 0; k < kRanges; ++k) {
    track.add(observe(tag, anchor, truth, k, 0.1 * static_cast<double>(k), kBias_m, kSigma_m, rng));
  }
  const double start_ms = bench::cpu_ms();
  const fleet::HypothesisSet set = fleet::range_hypotheses(track, settings);
  out.ms += bench::cpu_ms() - start_ms;
  const bool stands = g.anchor.size() == 1;
  Error best;
  std::size_t nearest = set.all.size();
  double minimum = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < set.all.size(); ++k) {
    const Error e = stands ? error_of_place(set.all[k], truth) : error_of_frame(set.all[k], truth);
    const double size = e.place_m.norm() + 5.0 * std::abs(e.yaw_rad);
    if (size >= minimum) continue;
    minimum = size;
    best = e;
    nearest = k;
  }
  if (nearest == set.all.size()) {
    ++out.lost;
    return;
  }
  out.yaw_deg.push_back(best.yaw_rad / kDegree);
  out.place_m.push_back(best.place_m.norm());
  out.stated_yaw_deg.push_back(best.sigma_yaw_rad / kDegree);
  out.stated_place_m.push_back(best.sigma_m);
  out.nees.push_back(best.nees);
  if (set.all.size() > 1 && set.gap(1) < settings.commit.gap_chi2) ++out.second;
  if (nearest != 0) ++out.wrong;
}

}  // namespace

std::string geometry_table(int runs) {
  std::string out = fmt::format(
      "{} ranges at {} m, pair bias {} m, {} runs; of the hypothesis nearest to the truth. NEES: 1 "
      "is honest.\n\n"
      "| geometry | drift | stated sd: yaw deg, place m | yaw rms deg | place rms m | NEES | 2nd "
      "lives | first wrong | ms |\n|---|---|---|---|---|---|---|---|---|\n",
      kRanges, kSigma_m, kBias_m, runs);
  for (const Geometry& g : geometries()) {
    for (const bool drift : {false, true}) {
      Rng rng(1, g.name);
      Column c;
      for (int k = 0; k < runs; ++k) run(g, drift, rng, c);
      double nees = 0.0;
      for (const double v : c.nees) nees += v / static_cast<double>(c.nees.size());
      const bool stands = g.anchor.size() == 1;
      out += fmt::format("| {} | {} | {}, {:.3f} | {} | {:.3f} | {:.2f} | {} % | {} % | {:.0f} |\n",
                         g.name, drift ? "yes" : "no",
                         stands ? "-" : fmt::format("{:.2f}", median(c.stated_yaw_deg)),
                         median(c.stated_place_m),
                         stands ? "-" : fmt::format("{:.2f}", rms(c.yaw_deg)), rms(c.place_m), nees,
                         100 * c.second / runs, 100 * (c.wrong + c.lost) / runs, c.ms / runs);
    }
  }
  return out;
}

}  // namespace rali::frames_bench
