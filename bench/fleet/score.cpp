#include "score.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <numbers>

#include <fmt/format.h>

#include "rali/drive/output/traffic_file.hpp"
#include "rali/eval/alignment.hpp"
#include "rali/eval/consistency.hpp"
#include "rali/eval/errors.hpp"
#include "rali/wire/fleet/codec.hpp"
#include "truth.hpp"

namespace rali::fleet_bench {

using geometry::SE3;

namespace {

constexpr double kDegPerRad = 180.0 / std::numbers::pi;
constexpr double kWrongJoin_m = 0.5, kWrongJoin_deg = 5.0;
constexpr double kWrongLoop_m = 0.3, kWrongLoop_deg = 3.0;

std::vector<std::size_t> largest_group(const fleet::FleetEstimate& estimate) {
  std::vector<std::size_t> members;
  if (estimate.groups.empty()) return members;
  for (const VehicleId id : estimate.groups.front()) members.push_back(id.value);
  return members;
}

/// Straight paths leave the roll about themselves unobservable; then the first pose is aligned.
SE3 aligned(const eval::PairList& pairs) {
  auto T = eval::align(pairs, eval::Alignment::kSe3);
  if (!T) T = eval::align(pairs, eval::Alignment::kOrigin);
  return T ? *T : SE3{};
}

void score_paths(const Mission& mission, const Joined& joined,
                 const std::vector<std::size_t>& members, Scores& s) {
  eval::PairList all;
  for (const std::size_t v : members) {
    const eval::PairList own = pairs_of(mission.vehicles[v], joined.paths[v]);
    all.insert(all.end(), own.begin(), own.end());
  }
  const bool fleet = members.size() > 1;  // a single vehicle is not a fleet
  if (fleet && !all.empty()) {
    const auto ape = eval::translation_statistics(eval::absolute_errors(all, aligned(all)));
    s.ape_m = ape.rmse;
    s.ape_max_m = ape.max;
  }
  s.alone_m = 0.0;
  for (const Driven& driven : mission.vehicles) {
    Path alone{{}, driven.poses, driven.keyframes};
    drive::correct_path(driven.smoothed, alone.poses, alone.keyframes);
    const eval::PairList own = pairs_of(driven, alone);
    if (own.empty()) continue;
    const auto ape = eval::translation_statistics(eval::absolute_errors(own, aligned(own)));
    s.alone_m = std::max(s.alone_m, ape.rmse);
  }
}

void score_frames(const Mission& mission, const Joined& joined,
                  const std::vector<std::size_t>& members, bool halves, Scores& s) {
  s.joined = members.size();
  for (std::size_t k = 1; k < members.size(); ++k) {
    const auto error = frame_error(mission, joined, members.front(), members[k], halves);
    if (!error) continue;
    const double deg = error->angle_rad * kDegPerRad;
    s.frame_m = std::isnan(s.frame_m) ? error->distance_m : std::max(s.frame_m, error->distance_m);
    s.frame_deg = std::isnan(s.frame_deg) ? deg : std::max(s.frame_deg, deg);
    if (error->distance_m > kWrongJoin_m || deg > kWrongJoin_deg) ++s.wrong_joins;
  }
  for (const fleet::VehicleFrame& frame : joined.estimate.frames) {
    if (!frame.waits_for.empty()) s.waits_for.push_back(frame.waits_for);
    if (frame.decided_by) s.decided_by.emplace_back(decided_by_text(*frame.decided_by));
  }
}

/// NEES of keyframe poses in the map. The map's frame is that of the group's first pose, so ground
/// truth is aligned there.
void score_honesty(const Mission& mission, const Joined& joined,
                   const std::vector<std::size_t>& members, Scores& s) {
  eval::PairList pairs;
  std::vector<geometry::Mat6> covariances;
  for (const std::size_t v : members) {
    for (const auto& [id, pose] : joined.estimate.keyframes) {
      if (id.vehicle.value != v) continue;
      const auto truth = truth_at(mission, id.vehicle, pose.t);
      if (!truth) continue;
      eval::PosePair pair;
      pair.t = pose.t;
      pair.est = pose.T_map_body;
      pair.ref = *truth;
      pair.est_index = covariances.size();
      pairs.push_back(pair);
      covariances.push_back(pose.covariance);
    }
  }
  if (pairs.empty()) return;
  const SE3 T_est_ref = pairs.front().est * pairs.front().ref.inverse();
  const eval::Consistency c = eval::consistency(pairs, covariances, T_est_ref, 6);
  s.nees6 = c.mean;
  s.nees_median = c.median;
  s.fraction95 = c.fraction_within_95;
}

bool is_wrong(const Mission& mission, const fleet::LoopVerdict& loop) {
  const auto error = loop_error(mission, loop);
  return error &&
         (error->distance_m > kWrongLoop_m || error->angle_rad * kDegPerRad > kWrongLoop_deg);
}

void score_loops(const Mission& mission, const Joined& joined, Scores& s) {
  for (const fleet::LoopVerdict& loop : joined.estimate.loops) {
    if (!loop.accepted) {
      ++s.loops.refused;
      continue;
    }
    ++s.loops.accepted;
    if (is_wrong(mission, loop)) ++s.loops.wrong;
  }
}

void score_traffic(const Mission& mission, Scores& s) {
  for (const Driven& driven : mission.vehicles) {
    std::size_t bytes = 0;
    for (const wire::Bytes& fact : driven.facts) {
      s.traffic.add(wire::envelope_kind(fact), fact.size());
      bytes += fact.size();
    }
    if (driven.truth.empty()) continue;
    const double duration_s = seconds_between(driven.truth.front().t, driven.truth.back().t);
    const double rate = drive::mb_per_min(bytes, duration_s);
    s.mb_per_min = std::max(s.mb_per_min, rate);
  }
}

}  // namespace

Result<Scores> score(const Mission& mission, const Joined& joined, const Place& place,
                     const JoinOptions& options) {
  Scores s;
  s.row = options.name;
  s.scene = name_of(place);
  s.seed = place.seed;
  s.vehicles = mission.vehicles.size();
  s.duration_s = mission.duration_s;
  s.vehicles_s = 1e-3 * mission.cpu_ms;
  s.centre_s = 1e-3 * joined.cpu_ms;
  for (const Driven& driven : mission.vehicles) s.path_m += driven.path_m;
  const std::vector<std::size_t> members = largest_group(joined.estimate);
  if (members.empty()) return fail(ErrorCode::kNoAnswer, s.scene, "no vehicle has a path");
  score_paths(mission, joined, members, s);
  score_frames(mission, joined, members, place.halves, s);
  score_honesty(mission, joined, members, s);
  score_loops(mission, joined, s);
  score_traffic(mission, s);
  return s;
}

void dump(const std::string& dir, const Mission& mission, const Joined& joined,
          const Scores& scores) {
  std::error_code ignored;
  std::filesystem::create_directories(dir, ignored);
  const std::string name = fmt::format("{}/{}_{}_{}", dir, scores.scene, scores.seed, scores.row);
  if (std::FILE* file = std::fopen((name + ".loops.csv").c_str(), "w")) {
    fmt::print(file, "from,to,t_from_s,t_to_s,accepted,reason,score,shift_m,error_m,error_deg\n");
    for (const fleet::LoopVerdict& loop : joined.estimate.loops) {
      const auto error = loop_error(mission, loop);
      fmt::print(file, "{},{},{:.2f},{:.2f},{},{},{:.3f},{:.4f},{:.4f},{:.3f}\n",
                 loop.from.vehicle.value, loop.to.vehicle.value, loop.t_from.s(), loop.t_to.s(),
                 loop.accepted ? 1 : 0, loop.reason, loop.score, loop.shift_m,
                 error ? error->distance_m : kNone, error ? error->angle_rad * kDegPerRad : kNone);
    }
    std::fclose(file);
  }
  std::FILE* file = std::fopen((name + ".keyframes.csv").c_str(), "w");
  if (file == nullptr) return;
  fmt::print(file,
             "vehicle,seq,t_s,dx_m,dy_m,dz_m,rx_deg,ry_deg,rz_deg,sx_m,sy_m,sz_m,srz_deg,"
             "nees\n");
  const auto& keyframes = joined.estimate.keyframes;
  std::optional<SE3> T_est_ref;
  for (const auto& [id, pose] : keyframes) {
    const auto truth = truth_at(mission, id.vehicle, pose.t);
    if (!truth) continue;
    if (!T_est_ref) T_est_ref = pose.T_map_body * truth->inverse();
    const SE3 ref = *T_est_ref * *truth;
    const geometry::Vec3 d = pose.T_map_body.p - ref.p;
    const geometry::Vec3 r = geometry::so3_log(ref.R.transpose() * pose.T_map_body.R) * kDegPerRad;
    const geometry::Mat6& P = pose.covariance;
    fmt::print(file,
               "{},{},{:.2f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},"
               "{:.4f},{:.2f}\n",
               id.vehicle.value, id.seq, pose.t.s(), d.x(), d.y(), d.z(), r.x(), r.y(), r.z(),
               std::sqrt(P(3, 3)), std::sqrt(P(4, 4)), std::sqrt(P(5, 5)),
               std::sqrt(P(2, 2)) * kDegPerRad,
               eval::nees_pose(pose.T_map_body, ref, P).value_or(kNone));
  }
  std::fclose(file);
}

}  // namespace rali::fleet_bench
