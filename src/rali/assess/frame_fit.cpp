#include "rali/assess/frame_fit.hpp"

#include <limits>

#include "rali/geometry/pca3.hpp"

namespace rali::assess {

using eval::Alignment;

namespace {

// Standard deviation across the trajectory as a fraction of that along it: 0.3 m on 100 m.
constexpr double kStraightRatio = 0.003;
// A vehicle that moves less is at standstill; its positions do not constrain its heading.
constexpr double kRest_m = 0.02;

/// Variances of the true positions along the principal axes [m^2], largest first.
geometry::Vec3 spread_m2(const eval::PairList& pairs) {
  const double n = static_cast<double>(pairs.size());
  geometry::Vec3 mean = geometry::Vec3::Zero();
  for (const eval::PosePair& p : pairs) mean += p.ref.p / n;
  geometry::Mat3 C = geometry::Mat3::Zero();
  for (const eval::PosePair& p : pairs) {
    C += (p.ref.p - mean) * (p.ref.p - mean).transpose() / n;
  }
  return geometry::pca3(C).values;
}

Result<FrameFit> fitted(const eval::PairList& pairs, Alignment how, std::string why) {
  const Result<geometry::SE3> T = eval::align(pairs, how);
  if (!T) return tl::make_unexpected(T.error());
  return FrameFit{*T, how, std::move(why)};
}

}  // namespace

Result<FrameFit> fit_frame(const eval::PairList& pairs, Alignment asked) {
  if (pairs.empty() || asked == Alignment::kNone || asked == Alignment::kOrigin) {
    return fitted(pairs, asked, {});
  }
  const geometry::Vec3 spread = spread_m2(pairs);
  const bool moves = spread[0] > kRest_m * kRest_m;
  const bool straight = !(spread[1] > kStraightRatio * kStraightRatio * spread[0]);
  Result<FrameFit> fit = fail(ErrorCode::kNoAnswer, {}, "stands still");
  if (moves && asked == Alignment::kSe3 && straight) {
    fit = fitted(
        pairs, Alignment::kYaw,
        "the path is straight, which does not constrain the roll about it; yaw alone is solved "
        "instead (alignment yaw: both frames level)");
  } else if (moves) {
    fit = fitted(pairs, asked, {});
  }
  if (fit) return fit;
  return fitted(pairs, Alignment::kOrigin,
                "the positions leave the heading open; the first poses are laid together instead "
                "(alignment origin)");
}

eval::Gauge frame_gauge(std::span<const StatedPairs> vehicles, Alignment asked) {
  if (asked == Alignment::kNone) return {};
  constexpr double kNotStated = std::numeric_limits<double>::infinity();
  const eval::PosePair* reference = nullptr;
  const eval::PosePair* level = nullptr;
  double minimum = kNotStated;
  double minimum_rad2 = kNotStated;
  for (const StatedPairs& v : vehicles) {
    if (v.pairs->empty()) continue;
    const eval::PosePair& first = v.pairs->front();
    const bool stated = first.est_index < v.covariances->size();
    const geometry::Vec6 variance =
        stated ? geometry::Vec6((*v.covariances)[first.est_index].diagonal())
               : geometry::Vec6::Constant(kNotStated);
    const double all = v.is_reference ? -1.0 : variance.sum();
    if (reference == nullptr || all < minimum) {
      reference = &first;
      minimum = all;
    }
    const double rotation_rad2 = variance.head<3>().sum();
    if (level == nullptr || rotation_rad2 < minimum_rad2) {
      level = &first;
      minimum_rad2 = rotation_rad2;
    }
  }
  return reference != nullptr ? eval::gauge_of(*reference, *level) : eval::Gauge{};
}

}  // namespace rali::assess
