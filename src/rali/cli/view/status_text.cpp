#include "rali/cli/view/status_text.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "rali/cli/session.hpp"

namespace rali::cli {
namespace {

using nlohmann::json;
using Row = std::vector<std::string>;

constexpr const char* kDash = "-";

/// A member of an object; null if it is missing or `object` is no object.
const json& at(const json& object, const char* key) {
  static const json none;
  if (!object.is_object()) return none;
  const auto found = object.find(key);
  return found == object.end() ? none : *found;
}

std::string text(const json& value, const char* absent = "") {
  return value.is_string() ? printable(value.get_ref<const std::string&>()) : absent;
}

std::string number(const json& value, int digits, const char* unit = "") {
  return value.is_number() ? fmt::format("{:.{}f}{}", value.get<double>(), digits, unit) : kDash;
}

std::string percent(const json& value) {
  return value.is_number() ? fmt::format("{:.0f} %", 100.0 * value.get<double>()) : kDash;
}

std::string milliseconds(const json& value) {
  return value.is_number() ? fmt::format("{:.0f} ms", 1e3 * value.get<double>()) : kDash;
}

std::string rate(const json& value) {
  return value.is_number() ? fmt::format("{:.1f} kB/s", 1e-3 * value.get<double>()) : kDash;
}

std::string place(const json& position) {
  if (!position.is_array() || position.size() != 3) return kDash;
  return fmt::format("{}, {}, {}", number(position[0], 1), number(position[1], 1),
                     number(position[2], 1));
}

/// Columns as wide as their widest cell.
std::string table(const std::vector<Row>& rows) {
  std::vector<std::size_t> width;
  for (const Row& row : rows) {
    width.resize(std::max(width.size(), row.size()));
    for (std::size_t i = 0; i < row.size(); ++i) width[i] = std::max(width[i], row[i].size());
  }
  std::string out;
  for (const Row& row : rows) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) line += fmt::format("{:<{}}  ", row[i], width[i]);
    line.erase(line.find_last_not_of(' ') + 1);
    out += line + '\n';
  }
  return out;
}

std::string head_text(const json& state) {
  Row facts;
  const json& mission = at(state, "mission");
  if (at(mission, "round").is_number()) facts.push_back("round " + number(at(mission, "round"), 0));
  if (at(state, "term").is_number()) facts.push_back("term " + number(at(state, "term"), 0));
  const std::string anchor = text(at(at(state, "anchor"), "vehicle"));
  if (!anchor.empty()) facts.push_back("anchor " + anchor);
  const json& table = at(state, "table");
  if (at(table, "revision").is_number()) {
    facts.push_back("table " + number(at(table, "revision"), 0));
  }
  std::string out = fmt::format("{}{}{}\n", text(at(state, "vehicle"), "?"),
                                facts.empty() ? "" : ": ", fmt::join(facts, ", "));
  for (const json* line : {&at(mission, "state"), &at(state, "waits_for")}) {
    if (line->is_string()) out += text(*line) + '\n';
  }
  return out;
}

std::string lost_text(const json& lost) {
  if (!lost.is_object()) return {};
  std::string out =
      fmt::format("\nANCHOR LOST: {}, last seen {} ago at {}.\n", text(at(lost, "vehicle"), "?"),
                  number(at(lost, "age_s"), 0, " s"), place(at(lost, "position_m")));
  if (at(lost, "message").is_string()) out += text(at(lost, "message")) + '\n';
  if (at(lost, "command").is_string()) {
    out += "If it will not come back: " + text(at(lost, "command")) + '\n';
  }
  return out;
}

std::string vehicles_text(const json& list) {
  if (!list.is_array() || list.empty()) return {};
  std::vector<Row> rows = {
      {"vehicle", "role", "mode", "position [m]", "sigma", "battery", "age", "LiDAR"}};
  std::string waits;
  for (const json& v : list) {
    rows.push_back({text(at(v, "name"), "?"), text(at(v, "role"), kDash),
                    text(at(v, "mode"), kDash), place(at(v, "position_m")),
                    number(at(at(v, "ellipse"), "major_m"), 2, " m"), percent(at(v, "battery")),
                    number(at(v, "age_s"), 1, " s"),
                    at(v, "degenerate").is_object() ? "degenerate" : "ok"});
    if (at(v, "waits_for").is_string()) waits += "  " + text(at(v, "waits_for")) + '\n';
  }
  return '\n' + table(rows) + waits;
}

std::string links_text(const json& list) {
  if (!list.is_array() || list.empty()) return {};
  std::vector<Row> rows = {{"link", "loss", "rate", "delay"}};
  for (const json& l : list) {
    const json& connected = at(l, "connected");
    const bool cut = connected.is_boolean() && !connected.get<bool>();
    rows.push_back({text(at(l, "from"), "?") + " > " + text(at(l, "to"), "?"),
                    cut ? "cut" : percent(at(l, "loss")), rate(at(l, "rate_Bps")),
                    milliseconds(at(l, "delay_s"))});
  }
  return '\n' + table(rows);
}

std::string ranges_text(const json& list) {
  if (!list.is_array() || list.empty()) return {};
  std::vector<Row> rows = {{"range", "distance", "use"}};
  for (const json& r : list) {
    const json& used = at(r, "used");
    rows.push_back(
        {text(at(r, "from"), "?") + " - " + text(at(r, "to"), "?"),
         number(at(r, "range_m"), 2, " m"),
         used.is_boolean() && used.get<bool>() ? "used" : text(at(r, "reason"), "not used")});
  }
  return '\n' + table(rows);
}

std::string diagnostics_text(const json& list) {
  std::string out;
  if (!list.is_array()) return out;
  for (const json& d : list) {
    const std::string level = text(at(d, "level"), "?");
    if (level == "ok") continue;
    out += fmt::format("{:<6} {}{}: {}\n", level,
                       at(d, "vehicle").is_string() ? text(at(d, "vehicle")) + ' ' : "",
                       text(at(d, "name"), "?"), text(at(d, "message")));
    if (at(d, "remedy").is_string()) out += "       " + text(at(d, "remedy")) + '\n';
  }
  return out.empty() ? "\nnothing to report\n" : '\n' + out;
}

bool has_error(const json& diagnostics) {
  return diagnostics.is_array() &&
         std::any_of(diagnostics.begin(), diagnostics.end(),
                     [](const json& d) { return text(at(d, "level")) == "error"; });
}

}  // namespace

Result<FleetStatus> read_status(std::string_view state_text) {
  const json state = json::parse(state_text, nullptr, false);
  if (!state.is_object() || !at(state, "schema").is_number()) {
    return fail(ErrorCode::kInput, "state", "this is no state of a fleet",
                "Give the address of a vehicle's view.");
  }
  const json& lost = at(at(state, "anchor"), "lost");
  const json& diagnostics = at(state, "diagnostics");
  return FleetStatus{head_text(state) + lost_text(lost) + vehicles_text(at(state, "vehicles")) +
                         links_text(at(state, "links")) + ranges_text(at(state, "ranges")) +
                         diagnostics_text(diagnostics),
                     lost.is_object() || has_error(diagnostics)};
}

}  // namespace rali::cli
