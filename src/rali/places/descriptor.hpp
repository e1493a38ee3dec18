#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "rali/places/density.hpp"

namespace rali::places {

inline constexpr std::size_t kRings = 20;
inline constexpr std::size_t kSectors = 60;

/// Image of a place from above, around its middle: rings of equal width, sectors of 6 degrees. A
/// turn of the vehicle shifts the sectors. After Kim and Kim 2018 (Scan Context), but computed from
/// a levelled submap and from the occupied density of each field, so that a LiDAR with few rings
/// suffices.
struct Descriptor {
  std::array<float, kRings * kSectors> fields{};  ///< ring by ring; mean 0, sum of squares 1
  std::array<float, kRings> ring_key{};           ///< mean density of the fields of a ring

  [[nodiscard]] bool empty() const { return ring_key == std::array<float, kRings>{}; }
};

struct DescriptorSettings {
  BandSettings band = {0.2, 2.5, 20.0};
  double cell_m = 0.2;
  int key_candidates = 100;  ///< nearest by ring key that are compared in full
  int candidates_max = 10;
  double score_min = 0.45;

  template <class V>
  void visit(V& v) {
    v.group("band", band, "height band of the image from above");
    v("cell_m", cell_m, 0.05, 2.0, "cell of the image");
    v("key_candidates", key_candidates, 1, 100000, "places compared in full");
    v("candidates_max", candidates_max, 1, 10000, "places returned");
    v("score_min", score_min, -1.0, 1.0, "likeness below is no candidate");
  }
};

[[nodiscard]] Descriptor describe(const Submap& submap, const DescriptorSettings& settings);

/// Similarity of two descriptors at the best relative yaw.
struct Likeness {
  double score = -1.0;   ///< correlation of the fields, in [-1, 1]
  double yaw_rad = 0.0;  ///< of b's frame in a's: a point at angle w in b is at w + yaw in a
};

/// The yaw with the best score, in steps of one sector.
[[nodiscard]] Likeness compare(const Descriptor& a, const Descriptor& b);

/// A place recognition candidate. Most are wrong.
struct Candidate {
  KeyframeId id;
  double score = 0.0;
  double yaw_rad = 0.0;  ///< of the query's frame in the candidate's
};

/// Descriptors of all places seen so far.
class PlaceIndex {
 public:
  explicit PlaceIndex(const DescriptorSettings& settings) : settings_(settings) {}

  /// Replaces the place that was added under the same id.
  void add(KeyframeId id, const Descriptor& descriptor);

  /// Best first, ties by id. @param skip tests which places not to return (the ones just left).
  template <class Skip>
  [[nodiscard]] std::vector<Candidate> query(const Descriptor& asked, Skip skip) const {
    std::vector<std::size_t> open;
    for (std::size_t k = 0; k < ids_.size(); ++k) {
      if (!skip(ids_[k])) open.push_back(k);
    }
    return best_of(asked, std::move(open));
  }

  [[nodiscard]] std::size_t size() const { return ids_.size(); }

 private:
  [[nodiscard]] std::vector<Candidate> best_of(const Descriptor& asked,
                                               std::vector<std::size_t> open) const;

  DescriptorSettings settings_;
  std::vector<KeyframeId> ids_;
  std::vector<Descriptor> descriptors_;
};

}  // namespace rali::places
