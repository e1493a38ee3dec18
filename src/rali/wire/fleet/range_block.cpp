#include "rali/wire/fleet/range_block.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include "rali/fleet/facts/quantise.hpp"
#include "rali/fleet/facts/rounding.hpp"

namespace rali::wire {

namespace {

using fleet::RangeEntry;
using fleet::RotationCode;

constexpr std::uint8_t kSection = 1;
constexpr std::int64_t kNsPerUs = 1000;

/// A pair of antennas, and its last range.
struct Link {
  VehicleId from, to;
  std::uint8_t from_antenna = 0, to_antenna = 0;
  std::int64_t range = 0, sigma = 0;

  [[nodiscard]] bool is(const RangeEntry& e) const {
    return from == e.from && to == e.to && from_antenna == e.from_antenna &&
           to_antenna == e.to_antenna;
  }
};

/// Prediction for the next entry: constant position step (second differences).
struct Track {
  std::int64_t t_ns = 0;
  std::array<std::int64_t, 3> place{}, step{};
  RotationCode rotation;
};

std::array<std::int64_t, 3> place_code(const RangeEntry& entry) {
  std::array<std::int64_t, 3> code{};
  for (std::size_t k = 0; k < 3; ++k) {
    code[k] = fleet::range_code(entry.T_odom_body.p[static_cast<Eigen::Index>(k)]);
  }
  return code;
}

/// First byte of an entry: link << 4 | largest << 2 | at_rest << 1 | same time and position.
struct Head {
  std::uint64_t link = 0;
  std::uint8_t largest = 0;
  bool at_rest = false, same = false;

  [[nodiscard]] std::uint64_t packed() const {
    return link << 4 | std::uint64_t{largest} << 2 | std::uint64_t{at_rest} << 1 |
           std::uint64_t{same};
  }

  static Head of(std::uint64_t packed) {
    return {packed >> 4, static_cast<std::uint8_t>(packed >> 2 & 3U), (packed & 2U) != 0,
            (packed & 1U) != 0};
  }
};

void write_place(PackWriter& a, Track& track, const std::array<std::int64_t, 3>& place,
                 const RotationCode& rotation) {
  for (std::size_t k = 0; k < 3; ++k) {
    const std::int64_t step = place[k] - track.place[k];
    a.signed_varint(step - track.step[k]);
    track.step[k] = step;
  }
  const bool goes_on = rotation.largest == track.rotation.largest;
  for (std::size_t k = 0; k < 3; ++k) {
    a.signed_varint(rotation.parts[k] - (goes_on ? track.rotation.parts[k] : 0));
  }
  track.place = place;
  track.rotation = rotation;
}

void read_place(PackReader& a, Track& track, std::uint8_t largest) {
  // Unsigned, so that no input causes an undefined overflow.
  const auto sum = [](std::int64_t x, std::int64_t y) {
    return static_cast<std::int64_t>(static_cast<std::uint64_t>(x) + static_cast<std::uint64_t>(y));
  };
  for (std::size_t k = 0; k < 3; ++k) {
    std::int64_t change = 0;
    a.signed_varint(change);
    track.step[k] = sum(track.step[k], change);
    track.place[k] = sum(track.place[k], track.step[k]);
  }
  const bool goes_on = largest == track.rotation.largest;
  for (std::size_t k = 0; k < 3; ++k) {
    std::int64_t change = 0;
    a.signed_varint(change);
    const std::int64_t part = sum(goes_on ? track.rotation.parts[k] : 0, change);
    constexpr std::int64_t kOne = std::int64_t{1} << fleet::kRangeBits;
    if (part < -kOne || part > kOne) a.fail_with("holds no rotation");
    track.rotation.parts[k] = static_cast<std::int32_t>(part);
  }
  track.rotation.largest = largest;
}

std::vector<Link> links_of(const fleet::RangeBlock& block) {
  std::vector<Link> links;
  for (const RangeEntry& e : block.ranges) {
    const bool known =
        std::any_of(links.begin(), links.end(), [&e](const Link& l) { return l.is(e); });
    if (!known) links.push_back({e.from, e.to, e.from_antenna, e.to_antenna, 0, 0});
  }
  return links;
}

template <class Archive, class Links>
void layout_links(Archive& a, Links& links) {
  a.list(links, fleet::kRangesMax, [](auto& b, auto& link) {
    b.varint(link.from.value);
    b.varint(link.to.value);
    b.number(link.from_antenna);
    b.number(link.to_antenna);
  });
}

void write_entry(PackWriter& a, std::vector<Link>& links, Track& track, std::int64_t unit_ns,
                 const RangeEntry& entry, bool first) {
  const auto link =
      std::find_if(links.begin(), links.end(), [&entry](const Link& l) { return l.is(entry); });
  const auto place = place_code(entry);
  const RotationCode rotation = fleet::rotation_code(entry.T_odom_body.R, fleet::kRangeBits);
  const bool same =
      !first && entry.t.ns == track.t_ns && place == track.place && rotation == track.rotation;
  const Head head{static_cast<std::uint64_t>(link - links.begin()), rotation.largest, entry.at_rest,
                  same};
  a.varint(head.packed());
  if (!same) {
    a.signed_varint((entry.t.ns - track.t_ns) / unit_ns);
    write_place(a, track, place, rotation);
    track.t_ns = entry.t.ns;
  }
  const std::int64_t range = fleet::range_code(entry.range_m);
  const std::int64_t sigma = fleet::range_code(entry.sigma_m);
  a.signed_varint(range - link->range);
  a.signed_varint(sigma - link->sigma);
  link->range = range;
  link->sigma = sigma;
}

void read_entry(PackReader& a, std::vector<Link>& links, Track& track, std::int64_t unit_ns,
                RangeEntry& entry) {
  std::uint64_t packed = 0;
  a.varint(packed);
  const Head head = Head::of(packed);
  if (head.link >= links.size()) return a.fail_with("names a range's ends that it does not list");
  Link& link = links[static_cast<std::size_t>(head.link)];
  if (!head.same) {
    std::int64_t later = 0;
    a.signed_varint(later);
    track.t_ns = static_cast<std::int64_t>(static_cast<std::uint64_t>(track.t_ns) +
                                           static_cast<std::uint64_t>(later) *
                                               static_cast<std::uint64_t>(unit_ns));
    read_place(a, track, head.largest);
  }
  std::int64_t range = 0, sigma = 0;
  a.signed_varint(range);
  a.signed_varint(sigma);
  constexpr std::int64_t kLimit = std::int64_t{1} << 40;
  if (std::max(range, sigma) > kLimit || std::min(range, sigma) < -kLimit || !a.ok()) {
    return a.fail_with("holds a range out of all bounds");
  }
  link.range = std::clamp(link.range + range, -kLimit, kLimit);
  link.sigma = std::clamp(link.sigma + sigma, -kLimit, kLimit);
  entry.t.ns = track.t_ns;
  entry.from = link.from;
  entry.to = link.to;
  entry.from_antenna = link.from_antenna;
  entry.to_antenna = link.to_antenna;
  entry.range_m = fleet::range_of(link.range);
  entry.sigma_m = fleet::range_of(link.sigma);
  entry.at_rest = head.at_rest;
  entry.T_odom_body.R = fleet::rotation_of(track.rotation, fleet::kRangeBits);
  for (std::size_t k = 0; k < 3; ++k) {
    entry.T_odom_body.p[static_cast<Eigen::Index>(k)] = fleet::range_of(track.place[k]);
  }
}

}  // namespace

void write_range_block(BodyWriter& body, const fleet::RangeBlock& block) {
  const bool whole_us = std::all_of(block.ranges.begin(), block.ranges.end(),
                                    [](const RangeEntry& e) { return e.t.ns % kNsPerUs == 0; });
  const std::int64_t unit_ns = whole_us ? kNsPerUs : 1;
  std::vector<Link> links = links_of(block);
  body.section(kSection, [&](PackWriter& a) {
    layout_links(a, links);
    a.varint(static_cast<std::uint64_t>(unit_ns));
    Track track;
    bool first = true;
    a.list(block.ranges, fleet::kRangesMax, [&](PackWriter& b, const RangeEntry& entry) {
      write_entry(b, links, track, unit_ns, entry, first);
      first = false;
    });
  });
}

void read_range_block(BodyReader& body, fleet::RangeBlock& block) {
  body.section(kSection, [&](PackReader& a) {
    std::vector<Link> links;
    layout_links(a, links);
    std::int64_t unit_ns = 1;
    a.varint(unit_ns);
    Track track;
    a.list(block.ranges, fleet::kRangesMax,
           [&](PackReader& b, RangeEntry& entry) { read_entry(b, links, track, unit_ns, entry); });
  });
}

}  // namespace rali::wire
