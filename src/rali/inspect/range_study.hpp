#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "rali/base/finding.hpp"
#include "rali/base/result.hpp"
#include "rali/base/time.hpp"

namespace rali::inspect {

/// Statistics of ranges: who measured to whom, and their quality without using any pose.
class RangeStudy {
 public:
  void add(Time t, const std::string& from, const std::string& to, double range_m);

  /// Distances of 0 that a driver sent for "no measurement".
  void add_zeros(std::uint64_t n) { zeros_ += n; }

  /// A recording has ranges on this topic.
  void add_topic(const std::string& topic) { topics_.insert(topic); }

  /// A range topic of one recording: the number of the vehicle's own radio (empty: messages name
  /// vehicles), and whether messages have their own stamps.
  void add_radio(const std::string& topic, const std::string& vehicle,
                 std::optional<std::int64_t> number, bool has_stamp);

  /// A radio that answered on this topic.
  void add_peer(const std::string& topic, std::int64_t number) {
    topics_of_radios_[topic].received.insert(number);
  }

  /// Radios of a range topic, from all recordings.
  struct TopicRadios {
    std::map<std::int64_t, std::string> own;  ///< number of a radio: the vehicle in whose recording
                                              ///< it is the own radio
    std::set<std::int64_t> received;          ///< numbers that it measured to
    std::uint64_t with_stamp = 0, without_stamp = 0;
  };

  [[nodiscard]] const std::map<std::string, TopicRadios>& radios() const {
    return topics_of_radios_;
  }

  /// Ranges between two vehicles in either direction, by time. Radio numbers are mapped to the
  /// vehicle whose recording they wrote.
  [[nodiscard]] std::vector<std::pair<Time, double>> between(const std::string& a,
                                                             const std::string& b) const;

  [[nodiscard]] bool has_topic(const std::string& topic) const { return topics_.contains(topic); }

  [[nodiscard]] bool empty() const { return pairs_.empty(); }

  [[nodiscard]] std::vector<std::string> names() const;

  /// D14: rate, gaps, frozen values, zeros per pair. D15: the two directions of a pair disagree,
  /// spread.
  void report(const std::string& topic, FindingList& out) const;

  /// D14: pairs of vehicles that never measured each other, and vehicles without any range.
  /// @param vehicles names of the fleet; empty: those that ranges name
  void report_silent(const std::vector<std::string>& vehicles, FindingList& out) const;

  /// D14: names that are no vehicle of the fleet; nothing if `vehicles` is empty.
  void report_strangers(const std::vector<std::string>& vehicles, FindingList& out) const;

 private:
  struct Series {
    std::vector<std::pair<Time, double>> samples;  ///< at most kSamplesMax, as received
    std::uint64_t count = 0;
    std::uint64_t invalid = 0;
  };

  using Pairs = std::map<std::pair<std::string, std::string>, Series>;

  static constexpr std::size_t kSamplesMax = 200000;
  static constexpr std::size_t kPairsMax = 1000;

  void report_pair(const std::string& name, const Series& series, const std::string& topic,
                   FindingList& out) const;
  static void report_directions(const Pairs& pairs, const std::string& topic, FindingList& out);

  /// Several recordings may contain one pair, one after the other.
  [[nodiscard]] Pairs sorted_pairs() const;

  Pairs pairs_;  ///< ordered, so that the report is ordered too
  std::set<std::string> topics_;
  std::map<std::string, TopicRadios> topics_of_radios_;
  std::uint64_t zeros_ = 0;
  std::uint64_t pairs_refused_ = 0;
};

/// Adds the rows of a ranges.csv (product.md section 7); rows without numbers are a finding.
/// Errors: kInput (no file, a column missing, no row of numbers).
[[nodiscard]] Status read_ranges_csv(const std::string& path, RangeStudy& study,
                                     FindingList& findings);

}  // namespace rali::inspect
