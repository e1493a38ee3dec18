#include "truth_pairs.hpp"

#include <algorithm>

namespace rali::recognition {

namespace {

bool see_the_same(const Pair& pair, const std::vector<Piece>& pieces,
                  const places::VerifySettings& s) {
  if (pair.T_a_b.p.head<2>().norm() > 20.0) return false;
  const places::Submap& a = pieces[pair.a].submap;
  const places::Submap& b = pieces[pair.b].submap;
  constexpr double kFraction = 0.33;
  return std::max(places::agreement(a, b, pair.T_a_b, s).overlap(),
                  places::agreement(b, a, pair.T_a_b.inverse(), s).overlap()) > kFraction;
}

VehicleId vehicle_of(const Piece& piece) { return piece.submap.middle().vehicle; }

}  // namespace

std::vector<Pair> truth_pairs(const std::vector<Piece>& pieces,
                              const places::PlacesSettings& settings, bool across) {
  std::vector<Pair> out;
  for (std::size_t a = 0; a < pieces.size(); ++a) {
    for (std::size_t b = a + 1; b < pieces.size(); ++b) {
      if (share_scans(pieces[a], pieces[b])) continue;
      if (across && vehicle_of(pieces[a]) == vehicle_of(pieces[b])) continue;
      Pair pair{a, b, pieces[a].T_world_ref.inverse() * pieces[b].T_world_ref, false};
      pair.same = see_the_same(pair, pieces, settings.recognise.verify);
      out.push_back(pair);
    }
  }
  return out;
}

bool is_candidate(const Pair& pair, const std::vector<Piece>& pieces,
                  const places::PlacesSettings& settings, bool across) {
  places::PlaceIndex index(settings.descriptor);
  for (const Piece& p : pieces) {
    if (across && vehicle_of(p) == vehicle_of(pieces[pair.b])) continue;
    if (!share_scans(p, pieces[pair.b])) index.add(p.submap.middle(), p.descriptor);
  }
  const auto found = index.query(pieces[pair.b].descriptor, [](KeyframeId) { return false; });
  return std::any_of(found.begin(), found.end(), [&](const places::Candidate& c) {
    return c.id == pieces[pair.a].submap.middle();
  });
}

}  // namespace rali::recognition
