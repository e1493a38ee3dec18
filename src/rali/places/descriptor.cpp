#include "rali/places/descriptor.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace rali::places {

namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

float key_distance(const Descriptor& a, const Descriptor& b) {
  float sum = 0.0F;
  for (std::size_t r = 0; r < kRings; ++r) sum += std::abs(a.ring_key[r] - b.ring_key[r]);
  return sum;
}

/// Mean 0 and length 1, so that a product is a correlation. Equal fields give all zeros.
void normalise(std::array<float, kRings * kSectors>& fields) {
  double mean = 0.0;
  for (const float f : fields) mean += static_cast<double>(f);
  mean /= static_cast<double>(fields.size());
  double square = 0.0;
  for (const float f : fields) square += std::pow(static_cast<double>(f) - mean, 2);
  const double inverse = square > 0.0 ? 1.0 / std::sqrt(square) : 0.0;
  for (float& f : fields) f = static_cast<float>((static_cast<double>(f) - mean) * inverse);
}

}  // namespace

Descriptor describe(const Submap& submap, const DescriptorSettings& s) {
  Descriptor out;
  const double ring_m = s.band.range_m / static_cast<double>(kRings);
  for (const Mark& mark : marks_of(submap, s.cell_m, s.band)) {
    const double x = static_cast<double>(mark.x_m);
    const double y = static_cast<double>(mark.y_m);
    const double range_m = std::hypot(x, y);
    const auto ring = static_cast<std::size_t>(range_m / ring_m);
    if (ring >= kRings) continue;
    const double turn = std::atan2(y, x) / kTurn;
    const auto sector =
        static_cast<std::size_t>((turn < 0.0 ? turn + 1.0 : turn) * static_cast<double>(kSectors)) %
        kSectors;
    // A far field has more cells: the occupied fraction of its width is what counts.
    const double width = std::max(1.0, range_m * kTurn / static_cast<double>(kSectors) / s.cell_m);
    float& field = out.fields[ring * kSectors + sector];
    field = std::min(1.0F, field + mark.weight / static_cast<float>(width));
  }
  for (std::size_t r = 0; r < kRings; ++r) {
    float sum = 0.0F;
    for (std::size_t k = 0; k < kSectors; ++k) sum += out.fields[r * kSectors + k];
    out.ring_key[r] = sum / static_cast<float>(kSectors);
  }
  normalise(out.fields);
  return out;
}

Likeness compare(const Descriptor& a, const Descriptor& b) {
  Likeness best;
  for (std::size_t shift = 0; shift < kSectors; ++shift) {
    float sum = 0.0F;
    for (std::size_t r = 0; r < kRings; ++r) {
      const float* x = a.fields.data() + r * kSectors;
      const float* y = b.fields.data() + r * kSectors;
      const std::size_t wrap = kSectors - shift;
      for (std::size_t k = 0; k < wrap; ++k) sum += x[k + shift] * y[k];
      for (std::size_t k = wrap; k < kSectors; ++k) sum += x[k - wrap] * y[k];
    }
    if (static_cast<double>(sum) <= best.score) continue;
    best.score = static_cast<double>(sum);
    best.yaw_rad = kTurn * static_cast<double>(shift) / static_cast<double>(kSectors);
  }
  return best;
}

void PlaceIndex::add(KeyframeId id, const Descriptor& descriptor) {
  const auto at = std::lower_bound(ids_.begin(), ids_.end(), id);
  const auto place = at - ids_.begin();
  if (at != ids_.end() && *at == id) {
    descriptors_[static_cast<std::size_t>(place)] = descriptor;
    return;
  }
  ids_.insert(at, id);
  descriptors_.insert(descriptors_.begin() + place, descriptor);
}

std::vector<Candidate> PlaceIndex::best_of(const Descriptor& asked,
                                           std::vector<std::size_t> open) const {
  std::vector<Candidate> out;
  if (asked.empty()) return out;
  std::vector<std::pair<float, std::size_t>> order;
  for (const std::size_t k : open) {
    if (!descriptors_[k].empty()) order.emplace_back(key_distance(asked, descriptors_[k]), k);
  }
  const std::size_t n = std::min(order.size(), static_cast<std::size_t>(settings_.key_candidates));
  std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(n), order.end());
  for (std::size_t k = 0; k < n; ++k) {
    const Likeness like = compare(descriptors_[order[k].second], asked);
    if (like.score < settings_.score_min) continue;
    out.push_back({ids_[order[k].second], like.score, like.yaw_rad});
  }
  std::sort(out.begin(), out.end(), [](const Candidate& a, const Candidate& b) {
    return a.score != b.score ? a.score > b.score : a.id < b.id;
  });
  if (out.size() > static_cast<std::size_t>(settings_.candidates_max)) {
    out.resize(static_cast<std::size_t>(settings_.candidates_max));
  }
  return out;
}

}  // namespace rali::places
