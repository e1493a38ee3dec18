#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "rali/fleet/messages/messages.hpp"

namespace rali::fleet {

/// The numbers held of a stream, as disjoint intervals: memory grows with the number of gaps, not
/// of facts.
class SeqSet {
 public:
  /// False if it was already contained.
  bool insert(std::uint32_t seq);

  [[nodiscard]] bool contains(std::uint32_t seq) const;

  [[nodiscard]] bool empty() const { return intervals_.empty(); }

  [[nodiscard]] std::size_t size() const { return size_; }

  /// One beyond the largest number; 0 if empty.
  [[nodiscard]] std::uint64_t end() const;

  /// Number of missing intervals below end().
  [[nodiscard]] std::size_t gap_count() const;

  /// Likewise, if this number were inserted.
  [[nodiscard]] std::size_t gap_count_with(std::uint32_t seq) const;

  /// Missing numbers below end(), ascending.
  [[nodiscard]] std::vector<SeqInterval> gaps() const;

  /// The smallest number >= from that is missing below end().
  [[nodiscard]] std::optional<std::uint32_t> first_gap(std::uint32_t from) const;

  /// The smallest number >= from that `other` contains and this does not.
  [[nodiscard]] std::optional<std::uint32_t> first_lacking(const SeqSet& other,
                                                           std::uint32_t from) const;

  /// The numbers that an inventory lists for a stream.
  [[nodiscard]] static SeqSet from(const StreamInventory& inventory);

 private:
  void insert_interval(std::uint32_t first, std::uint32_t last);

  std::map<std::uint32_t, std::uint32_t> intervals_;  ///< first -> last, both held
  std::size_t size_ = 0;
};

}  // namespace rali::fleet
