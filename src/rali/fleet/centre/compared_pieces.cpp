#include "rali/fleet/centre/compared_pieces.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "rali/geometry/so3.hpp"

namespace rali::fleet {

using geometry::SE3;

namespace {

/// Beyond it the bird's-eye images differ: at 10 m the rotation moves points by 2 cm.
constexpr double kRelevelled_rad = 0.1 * std::numbers::pi / 180.0;
constexpr double kSamePath_m = 1e-6;
/// Fraction of a sigma: a guess that changes less leads to the same search.
constexpr double kSameGuess = 0.1;

bool same(double a, double b) { return std::abs(a - b) <= kSameGuess * std::min(a, b); }

bool same(const std::optional<places::Guess>& a, const std::optional<places::Guess>& b) {
  if (!a || !b) return !a && !b;
  const double sigma_m = places::horizontal_sigma_m(*a);
  const double sigma_rad = places::yaw_sigma_rad(*a);
  const double yaw_rad =
      places::wrapped(places::yaw_of(a->T_target_source.R) - places::yaw_of(b->T_target_source.R));
  return same(sigma_m, places::horizontal_sigma_m(*b)) &&
         same(sigma_rad, places::yaw_sigma_rad(*b)) &&
         (a->T_target_source.p - b->T_target_source.p).norm() <= kSameGuess * sigma_m &&
         std::abs(yaw_rad) <= kSameGuess * sigma_rad;
}

/// The same relation of the bodies, between the frames as they are levelled now.
places::Recognition relevelled(places::Recognition recognition, const SE3& T_target_now_then,
                               const SE3& T_source_now_then) {
  const SE3 T_source_then_now = T_source_now_then.inverse();
  for (places::Placement& placement : recognition.placements) {
    SE3& T = placement.registration.T_target_source;
    T = T_target_now_then * T * T_source_then_now;
  }
  return recognition;
}

}  // namespace

ComparedPieces::Piece::Piece(const places::Submap& submap)
    : scans(submap.scans()),
      points(submap.points()),
      path_m(submap.path_m()),
      T_ref_body(submap.T_ref_body()) {}

bool ComparedPieces::Piece::is(const places::Submap& submap) const {
  const geometry::Mat3 turn = T_ref_body.R.transpose() * submap.T_ref_body().R;
  return scans == submap.scans() && points == submap.points() &&
         std::abs(path_m - submap.path_m()) < kSamePath_m &&
         geometry::so3_log(turn).norm() < kRelevelled_rad;
}

const ComparedPieces::Known* ComparedPieces::find(const places::Submap& target,
                                                  const places::Submap& source,
                                                  const std::optional<places::Guess>& guess) const {
  const auto known = known_.find({target.middle(), source.middle()});
  if (known == known_.end()) return nullptr;
  const Known& k = known->second;
  return k.target.is(target) && k.source.is(source) && same(k.guess, guess) ? &k : nullptr;
}

std::vector<LoopFound> ComparedPieces::compare(std::span<const PathSubmap> submaps,
                                               std::vector<LoopCandidate> candidates,
                                               const places::RecogniseSettings& settings,
                                               Executor& executor, StopFlag stop) {
  std::vector<LoopFound> found(candidates.size());
  std::vector<LoopCandidate> open;
  std::vector<std::size_t> places_of_open;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const places::Submap& target = submaps[candidates[i].target].submap;
    const places::Submap& source = submaps[candidates[i].source].submap;
    const Known* known = find(target, source, candidates[i].guess);
    if (known == nullptr) {
      open.push_back(std::move(candidates[i]));
      places_of_open.push_back(i);
      continue;
    }
    found[i].recognition =
        relevelled(known->recognition, target.T_ref_body() * known->target.T_ref_body.inverse(),
                   source.T_ref_body() * known->source.T_ref_body.inverse());
    found[i].candidate = std::move(candidates[i]);
  }
  made_ += open.size();
  std::vector<LoopFound> made = compare_all(submaps, std::move(open), settings, executor, stop);
  for (std::size_t k = 0; k < made.size(); ++k) {
    const LoopCandidate& c = made[k].candidate;
    const places::Submap& target = submaps[c.target].submap;
    const places::Submap& source = submaps[c.source].submap;
    if (!stop.raised()) {
      known_.insert_or_assign(Pair{target.middle(), source.middle()},
                              Known{Piece(target), Piece(source), c.guess, made[k].recognition});
    }
    found[places_of_open[k]] = std::move(made[k]);
  }
  return found;
}

}  // namespace rali::fleet
