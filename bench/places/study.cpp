#include "study.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include "common/cpu_time.hpp"
#include "rali/base/rng.hpp"
#include "truth_pairs.hpp"

namespace rali::recognition {

using geometry::SE3;
using geometry::Vec3;
using geometry::Vec6;

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kWrong_m = 0.3, kWrong_deg = 3.0;

class Study {
 public:
  Study(const std::string& scene, const std::vector<Piece>& pieces,
        const places::PlacesSettings& settings, const StudyOptions& options)
      : pieces_(pieces), settings_(settings), options_(options), rng_(options.seed, scene) {
    figures_.scene = scene;
    figures_.pieces = pieces.size();
  }

  Figures run();

 private:
  void describe();
  void attempt(const Pair& pair, bool guided);
  void count(const Pair& pair, const places::Recognition& r, Outcome& out, const char* how) const;
  [[nodiscard]] places::Guess guess_for(const Pair& pair);

  const std::vector<Piece>& pieces_;
  const places::PlacesSettings& settings_;
  const StudyOptions& options_;
  Rng rng_;
  std::vector<Pair> pairs_;
  Figures figures_;
};

void Study::describe() {
  places::PlaceIndex index(settings_.descriptor);
  for (const Piece& p : pieces_) index.add(p.submap.middle(), p.descriptor);
  const auto pair_of = [&](std::size_t i, std::size_t j) {
    return std::find_if(pairs_.begin(), pairs_.end(), [&](const Pair& p) {
      return p.a == std::min(i, j) && p.b == std::max(i, j);
    });
  };
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    const auto skip = [&](KeyframeId id) {
      return std::any_of(pieces_.begin(), pieces_.end(), [&](const Piece& p) {
        return p.submap.middle() == id && share_scans(p, pieces_[i]);
      });
    };
    const bool has_partner = std::any_of(pairs_.begin(), pairs_.end(), [&](const Pair& p) {
      return p.same && (p.a == i || p.b == i);
    });
    bool found = false;
    for (const places::Candidate& c : index.query(pieces_[i].descriptor, skip)) {
      const auto at = std::find_if(pieces_.begin(), pieces_.end(),
                                   [&](const Piece& p) { return p.submap.middle() == c.id; });
      const auto pair = pair_of(i, static_cast<std::size_t>(at - pieces_.begin()));
      ++figures_.candidates;
      if (pair == pairs_.end() || !pair->same) continue;
      ++figures_.right;
      found = true;
    }
    figures_.asked += has_partner ? 1 : 0;
    figures_.recalled += has_partner && found ? 1 : 0;
  }
}

places::Guess Study::guess_for(const Pair& pair) {
  places::Guess guess;
  const double yaw = options_.guess_deg * kDegree;
  constexpr double kHeight_m = 0.3;
  guess.T_target_source.R = geometry::so3_exp(Vec3(0.0, 0.0, yaw * rng_.normal())) * pair.T_a_b.R;
  guess.T_target_source.p =
      pair.T_a_b.p + Vec3(options_.guess_m * rng_.normal(), options_.guess_m * rng_.normal(),
                          kHeight_m * rng_.normal());
  Vec6 variance;
  variance << Vec3::Constant(yaw * yaw), Vec3::Constant(options_.guess_m * options_.guess_m);
  variance[5] = kHeight_m * kHeight_m;
  guess.covariance = variance.asDiagonal();
  return guess;
}

/// Number of observable directions.
int rank_of(const geometry::Mat6& I) {
  const Eigen::SelfAdjointEigenSolver<geometry::Mat6> solver(I);
  int rank = 0;
  for (int k = 0; k < 6; ++k) rank += solver.eigenvalues()[k] > 1.0 ? 1 : 0;
  return rank;
}

void Study::count(const Pair& pair, const places::Recognition& r, Outcome& out,
                  const char* how) const {
  (pair.same ? out.same : out.other) += 1;
  if (!r.found()) return;
  if (!r.usable()) {
    ++out.ambiguous;
    return;
  }
  const places::Registration& best = r.placements.front().registration;
  const bool full = r.certainty == places::Certainty::kUnique && best.full_rank();
  out.unique += r.certainty == places::Certainty::kUnique ? 1 : 0;
  out.along += r.certainty == places::Certainty::kAlongAxis ? 1 : 0;
  out.full += full ? 1 : 0;
  const Vec6 e = geometry::boxminus(pair.T_a_b, best.T_target_source);
  // Errors along directions without information do not count as wrong.
  constexpr double kSigma = 6.0;
  const double chi2 = e.dot(best.information * e);
  const bool off = e.tail<3>().norm() > kWrong_m || e.head<3>().norm() > kWrong_deg * kDegree;
  const int rank = rank_of(best.information);
  const bool wrong = off && chi2 > kSigma * kSigma;
  if (wrong || (full && off)) {
    out.wrong += 1;
    out.wrong_full += full ? 1 : 0;
    if (options_.verbose) {
      const places::Verdict& v = r.placements.front().verdict;
      fmt::print(stderr,
                 "{} {} {}-{} same {} full {}: off {:.2f} {:.2f} {:.2f} m {:.2f} deg, chi2 {:.0f}, "
                 "overlap {:.2f} {:.2f}, conflict {:.3f} {:.3f}, agree {} {}\n",
                 figures_.scene, how, pair.a, pair.b, pair.same, full, e[3], e[4], e[5],
                 e.head<3>().norm() / kDegree, chi2, v.source_in_target.overlap(),
                 v.target_in_source.overlap(), v.source_in_target.conflict_fraction(),
                 v.target_in_source.conflict_fraction(), v.source_in_target.agree,
                 v.target_in_source.agree);
    }
    return;
  }
  if (rank > 0) out.nees.push_back(chi2 / rank);
  if (!full) return;
  out.error_m.push_back(e.tail<3>().norm());
  out.error_deg.push_back(e.head<3>().norm() / kDegree);
}

void Study::attempt(const Pair& pair, bool guided) {
  const places::Submap& a = pieces_[pair.a].submap;
  const places::Submap& b = pieces_[pair.b].submap;
  const auto guess = guided ? std::make_optional(guess_for(pair)) : std::nullopt;
  const double begin = bench::cpu_ms();
  const auto r = places::recognise(a, b, settings_.recognise, guess);
  Outcome& out = guided ? figures_.guided : figures_.global;
  out.ms += bench::cpu_ms() - begin;
  count(pair, r, out, guided ? "guided" : "global");
  if (!guided) return;
  const double start = bench::cpu_ms();
  static_cast<void>(places::align(a, b, guess->T_target_source, settings_.recognise.align));
  figures_.align_ms.push_back(bench::cpu_ms() - start);
}

Figures Study::run() {
  pairs_ = truth_pairs(pieces_, settings_, false);
  describe();
  for (const Piece& p : pieces_) {
    figures_.make_ms += p.make_ms / static_cast<double>(pieces_.size());
    figures_.describe_ms += p.describe_ms / static_cast<double>(pieces_.size());
  }
  for (const bool same : {true, false}) {
    std::vector<Pair> chosen;
    std::copy_if(pairs_.begin(), pairs_.end(), std::back_inserter(chosen),
                 [&](const Pair& p) { return p.same == same; });
    const std::size_t stride = chosen.size() / options_.pairs_max + 1;
    for (std::size_t k = 0; k < chosen.size(); k += stride) {
      attempt(chosen[k], false);
      if (same) attempt(chosen[k], true);
    }
  }
  return figures_;
}

}  // namespace

Figures study(const std::string& scene, const std::vector<Piece>& pieces,
              const places::PlacesSettings& settings, const StudyOptions& options) {
  return Study(scene, pieces, settings, options).run();
}

}  // namespace rali::recognition
