#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "rali/report/findings_shown.hpp"
#include "rali/report/internal/html.hpp"
#include "rali/report/section/checks.hpp"
#include "rali/report/section/section.hpp"

namespace rali::report {
namespace {

constexpr std::array<std::pair<std::string_view, std::string_view>, 14> kGapWords = {
    {{"jumps", "jumps of the clock"},
     {"missing_s", "seconds without LiDAR"},
     {"late", "messages too late"},
     {"late_scans", "of them scans"},
     {"empty_scans", "scans without a usable point"},
     {"nan_points", "points without a number"},
     {"no_time_points", "points without a time"},
     {"imu_saturated", "IMU samples at the end of their range"},
     {"repeated", "messages twice"},
     {"imu_invalid", "IMU samples that are no numbers"},
     {"imu_missing_s", "seconds without IMU"},
     {"undecodable", "messages not decoded"},
     {"bytes_lost", "bytes lost"},
     {"damaged", "damaged parts"}}};

bool none_found(const RunData& run) {
  for (const VehicleView& v : run.vehicles) {
    for (const auto& [key, value] : v.numbers.gaps) {
      if (value != 0.0) return false;
    }
  }
  return true;
}

std::string gaps_table(const RunData& run) {
  std::vector<std::string> keys;
  for (const VehicleView& v : run.vehicles) {
    for (const auto& [key, value] : v.numbers.gaps) {
      if (std::find(keys.begin(), keys.end(), key) == keys.end()) keys.push_back(key);
    }
  }
  if (keys.empty()) return absent("Gaps of the input are not known.");
  if (none_found(run)) {
    std::string list;
    for (const std::string& key : keys) {
      list += (list.empty() ? "" : ", ") + escaped(gap_words(key));
    }
    return "<p>Looked for and not found in any recording: " + list + ".</p>\n";
  }
  std::vector<std::string> head = {"looked for"};
  for (const VehicleView& v : run.vehicles) head.push_back(escaped(v.name));
  Table table(head);
  for (const std::string& key : keys) {
    std::vector<std::string> row = {escaped(gap_words(key))};
    for (const VehicleView& v : run.vehicles) {
      Number found;
      for (const auto& [name, value] : v.numbers.gaps) {
        if (name == key) found = value;
      }
      const bool whole = found && *found == std::floor(*found);
      const std::string text = whole ? counted(found) : fixed(found, 3);
      row.push_back(found.value_or(0.0) > 0.0 ? "<b>" + text + "</b>" : text);
    }
    table.row(std::move(row));
  }
  return "<div class=\"wide\">" + table.html() + "</div>";
}

std::string warnings_html(const RunData& run) {
  if (!run.metrics_known) return absent("There is no metrics.json: warnings are not known.");
  if (run.warnings.empty()) return absent("No warnings.");
  std::map<std::pair<std::string, std::string>, int> count;
  Table table({"id", "vehicle", "what was found"});
  for (const Warning& w : run.warnings) {
    if (++count[{w.id, w.vehicle}] > kFindingsShownMax) continue;
    table.row({escaped(w.id), escaped(w.vehicle), escaped(w.text)});
  }
  for (const auto& [kind, n] : count) {
    if (n <= kFindingsShownMax) continue;
    table.row({escaped(kind.first), escaped(kind.second),
               fmt::format("and {} more of this kind in metrics.json", n - kFindingsShownMax)});
  }
  return table.html(true);
}

std::string unreadable_html(const RunData& run) {
  std::string html;
  for (const std::string& line : run.unreadable) html += "<li>" + escaped(line) + "</li>";
  return html.empty() ? ""
                      : "<h3>Files that could not be read for this page</h3><ul>" + html + "</ul>";
}

}  // namespace

std::string_view gap_words(std::string_view key) {
  for (const auto& [name, words] : kGapWords) {
    if (name == key) return words;
  }
  return key;
}

Section input_section(const RunData& run) {
  return {"input", "Health of the input",
          "<h3>Findings</h3>" + warnings_html(run) + "<h3>Gaps</h3>" + gaps_table(run) +
              unreadable_html(run)};
}

Section speed_section(const RunData& run) {
  Section section{"speed", "Speed and memory", ""};
  const Timing& t = run.timing;
  if (!t.total_s && t.stages_s.empty()) {
    section.html = absent("There is no timing.json.");
    return section;
  }
  section.html = fmt::format(
      "<p>{} s of data in {} s: <b>{} times</b> as fast as it was recorded, with at most {} MiB of "
      "memory.</p>\n",
      fixed(t.data_s, 1), fixed(t.total_s, 1), fixed(t.speed, 1), counted(t.memory_max_mb));
  Table table({"stage", "time", "share", ""});
  for (const auto& [stage, seconds] : t.stages_s) {
    const double fraction = t.total_s.value_or(0.0) > 0.0 ? seconds / *t.total_s : 0.0;
    table.row({escaped(stage), fixed(seconds, 2) + " s", percent(fraction),
               fmt::format("<svg class=\"bar\" width=\"160\" height=\"9\"><rect width=\"{:.1f}\" "
                           "height=\"9\"/></svg>",
                           160.0 * std::clamp(fraction, 0.0, 1.0))});
  }
  section.html += table.html();
  return section;
}

/// "fleet.yaml:5" of a full path: folders of the machine that ran it are irrelevant to a reader.
std::string origin_words(const std::string& origin) {
  const std::size_t colon = origin.rfind(':');
  const std::size_t slash = origin.rfind('/');
  const bool is_line = colon != std::string::npos && colon + 1 < origin.size() &&
                       origin.find_first_not_of("0123456789", colon + 1) == std::string::npos;
  return is_line && slash != std::string::npos && slash < colon ? origin.substr(slash + 1) : origin;
}

Section settings_section(const RunData& run) {
  Section section{"settings", "Settings other than default", ""};
  if (!run.settings_known) {
    section.html = absent("There is no settings.yaml.");
    return section;
  }
  if (run.settings.empty()) {
    section.html = absent("All settings are the default ones.");
    return section;
  }
  Table table({"setting", "value", "from"});
  for (const SettingLine& s : run.settings) {
    if (s.key == "schema") continue;
    table.row({"<code>" + escaped(s.key) + "</code>", "<code>" + escaped(s.value) + "</code>",
               escaped(origin_words(s.origin))});
  }
  section.html = table.html(true);
  return section;
}

}  // namespace rali::report
