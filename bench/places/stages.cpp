#include "stages.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include <fmt/format.h>

#include "truth_pairs.hpp"

namespace rali::recognition {

using geometry::SE3;

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

struct Off {
  double m = 1e9, deg = 180.0;
};

Off off(const SE3& T, const SE3& truth) {
  const geometry::Vec6 e = geometry::boxminus(T, truth);
  return {e.tail<3>().norm(), e.head<3>().norm() / kDegree};
}

bool is_home(const SE3& T, const SE3& truth) {
  const Off o = off(T, truth);
  return o.m < 0.3 && o.deg < 3.0;
}

struct Seen {
  bool start = false, home = false, assumed = false;
};

/// Follows the start hypotheses of the search through registration and verification.
Seen follow(const Pair& pair, const std::vector<Piece>& pieces,
            const places::RecogniseSettings& s) {
  const places::Submap& a = pieces[pair.a].submap;
  const places::Submap& b = pieces[pair.b].submap;
  Seen seen;
  for (const places::Hypothesis& h : places::global_hypotheses(a, b, s.search).places) {
    SE3 flat = pair.T_a_b;
    flat.p.z() = h.T_a_b.p.z();
    const Off o = off(h.T_a_b, flat);
    seen.start = seen.start || (o.m < 1.0 && o.deg < 10.0);
    const auto r = places::align(a, b, h.T_a_b, s.align);
    if (!r.converged || !is_home(r.T_target_source, pair.T_a_b)) continue;
    seen.home = true;
    seen.assumed = seen.assumed || places::verify(a, b, r, s.verify).believable();
  }
  return seen;
}

void report(const Pair& pair, const Seen& seen, const places::Registration& at_truth,
            const places::Verdict& v, const places::Recognition& r) {
  const Off o = off(at_truth.T_target_source, pair.T_a_b);
  fmt::print(
      stderr,
      "{}-{} apart {:.1f} m {:.0f} deg: start {} home {} believed {} | at truth: off {:.2f} "
      "m {:.1f} deg rms {:.3f} refusal {} overlap {:.2f} {:.2f} conflict {:.3f} {:.3f} along "
      "{}/{} {}/{} stations {} {} | found {} certainty {}\n",
      pair.a, pair.b, pair.T_a_b.p.norm(),
      std::atan2(pair.T_a_b.R(1, 0), pair.T_a_b.R(0, 0)) / kDegree, seen.start, seen.home,
      seen.assumed, o.m, o.deg, at_truth.rms_m,
      places::kRefusalNames[static_cast<std::size_t>(v.refusal)], v.source_in_target.overlap(),
      v.target_in_source.overlap(), v.source_in_target.conflict_fraction(),
      v.target_in_source.conflict_fraction(), v.along_in_target.agree, v.along_in_target.asked,
      v.along_in_source.agree, v.along_in_source.asked, v.along_in_target.stations,
      v.along_in_source.stations, r.placements.size(),
      places::kCertaintyNames[static_cast<std::size_t>(r.certainty)]);
}

}  // namespace

Stages stages(const std::string& scene, const std::vector<Piece>& pieces,
              const places::PlacesSettings& settings, bool across, std::size_t pairs_max,
              bool verbose) {
  Stages out;
  out.scene = scene;
  const places::RecogniseSettings& s = settings.recognise;
  std::vector<Pair> pairs = truth_pairs(pieces, settings, across);
  std::erase_if(pairs, [](const Pair& p) { return !p.same; });
  const std::size_t stride = pairs.size() / pairs_max + 1;
  for (std::size_t k = 0; k < pairs.size(); k += stride) {
    const Pair& pair = pairs[k];
    const places::Submap& a = pieces[pair.a].submap;
    const places::Submap& b = pieces[pair.b].submap;
    const Seen seen = follow(pair, pieces, s);
    const auto at_truth = places::align(a, b, pair.T_a_b, s.align);
    const auto verdict = places::verify(a, b, at_truth, s.verify);
    const auto r = places::recognise(a, b, s);
    const bool best =
        r.found() && is_home(r.placements.front().registration.T_target_source, pair.T_a_b);
    ++out.same;
    out.candidate += is_candidate(pair, pieces, settings, across) ? 1 : 0;
    out.start += seen.start ? 1 : 0;
    out.home += seen.home ? 1 : 0;
    out.assumed += seen.assumed ? 1 : 0;
    out.best += best ? 1 : 0;
    out.usable += best && r.usable() ? 1 : 0;
    ++out.refused_at_truth[static_cast<std::size_t>(verdict.refusal)];
    if (verbose) report(pair, seen, at_truth, verdict, r);
  }
  return out;
}

}  // namespace rali::recognition
