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

/// Ranges as they come: who measured to whom, and how good they look without any pose.
class RangeStudy {
 public:
  void add(Time t, const std::string& from, const std::string& to, double range_m);

  /// Distances of 0 that a driver sent for "none".
  void add_zeros(std::uint64_t n) { zeros_ += n; }

  /// A recording has ranges on this topic.
  void add_topic(const std::string& topic) { topics_.insert(topic); }

  /// A range topic as one recording has it: the number of the vehicle's own radio (empty: it names
  /// vehicles), and whether messages carry stamps of their own.
  void add_radio(const std::string& topic, const std::string& vehicle,
                 std::optional<std::int64_t> number, bool has_stamp);

  /// A radio that answered on this topic.
  void add_peer(const std::string& topic, std::int64_t number) {
    topics_of_radios_[topic].heard.insert(number);
  }

  /// What is known of a topic of ranges from the recordings.
  struct TopicRadios {
    std::map<std::int64_t, std::string> own;  ///< number of a radio: whose recording it wrote
    std::set<std::int64_t> heard;             ///< numbers that it measured to
    std::uint64_t with_stamp = 0, without_stamp = 0;
  };

  [[nodiscard]] const std::map<std::string, TopicRadios>& radios() const {
    return topics_of_radios_;
  }

  /// Ranges between two vehicles in either direction, by time; radios by number count for the
  /// vehicle whose recording they wrote.
  [[nodiscard]] std::vector<std::pair<Time, double>> between(const std::string& a,
                                                             const std::string& b) const;

  [[nodiscard]] bool has_topic(const std::string& topic) const { return topics_.contains(topic); }

  [[nodiscard]] bool empty() const { return pairs_.empty(); }

  [[nodiscard]] std::vector<std::string> names() const;

  /// D14: rate, gaps, frozen values, zeros per pair. D15: the two directions of a pair disagree,
  /// spread.
  void report(const std::string& topic, FindingList& out) const;

  /// D14: pairs of vehicles that never measured each other, and vehicles that no range names.
  /// @param vehicles names of the fleet; empty: those that ranges name
  void report_silent(const std::vector<std::string>& vehicles, FindingList& out) const;

  /// D14: names that are no vehicle of the fleet; nothing where `vehicles` is empty.
  void report_strangers(const std::vector<std::string>& vehicles, FindingList& out) const;

 private:
  struct Series {
    std::vector<std::pair<Time, double>> samples;  ///< at most kSamplesMax, as they came
    std::uint64_t count = 0;
    std::uint64_t invalid = 0;
  };

  using Pairs = std::map<std::pair<std::string, std::string>, Series>;

  static constexpr std::size_t kSamplesMax = 200000;
  static constexpr std::size_t kPairsMax = 1000;

  void report_pair(const std::string& name, const Series& series, const std::string& topic,
                   FindingList& out) const;
  static void report_directions(const Pairs& pairs, const std::string& topic, FindingList& out);

  /// Several recordings tell of one pair, one after the other.
  [[nodiscard]] Pairs sorted_pairs() const;

  Pairs pairs_;  ///< ordered: the report is too
  std::set<std::string> topics_;
  std::map<std::string, TopicRadios> topics_of_radios_;
  std::uint64_t zeros_ = 0;
  std::uint64_t pairs_refused_ = 0;
};

/// Adds the rows of a ranges.csv (product.md section 7); those that hold no numbers are a finding.
/// Errors: kInput (no file, a column missing, no row of numbers).
[[nodiscard]] Status read_ranges_csv(const std::string& path, RangeStudy& study,
                                     FindingList& findings);

}  // namespace rali::inspect
