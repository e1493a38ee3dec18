#include "rali/report/report.hpp"

#include <fmt/format.h>

#include "rali/io/files/atomic_file.hpp"
#include "rali/report/data/page_data.hpp"
#include "rali/report/internal/html.hpp"
#include "rali/report/read_run.hpp"
#include "rali/report/section/section.hpp"

namespace rali::report {

namespace assets {
std::string_view script();
std::string_view style();
std::string_view script_licence();
}  // namespace assets

namespace {

/// Content security policy: the page must not load external resources.
constexpr std::string_view kPolicy =
    "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:";

std::string head(const std::string& title) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"{}\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<title>{}</title>\n<style>\n{}</style>\n</head>\n<body>\n",
      kPolicy, title, assets::style());
}

std::string contents(const std::vector<Section>& sections) {
  std::string out = "<nav><ol>";
  for (const Section& s : sections) {
    out += fmt::format("<li><a href=\"#{}\">{}</a></li>", s.id, s.title);
  }
  return out + "</ol></nav>\n";
}

std::string body(const std::vector<Section>& sections) {
  std::string out = "<main>\n";
  for (std::size_t i = 0; i < sections.size(); ++i) {
    const Section& s = sections[i];
    const bool speed = s.id == "speed";
    if (speed) out += kSpeedStart;
    out += fmt::format("<section id=\"{}\">\n<h2><span class=\"no\">{}</span> {}</h2>\n", s.id,
                       i + 1, s.title);
    out += s.html;
    out += "</section>\n";
    if (speed) out += kSpeedEnd;
  }
  return out + "</main>\n";
}

std::string foot() {
  std::string out =
      "<footer><p>Made by rali. All data of this page are in the folder of the run; "
      "the page loads nothing from anywhere.</p>\n";
  if (!assets::script_licence().empty()) {
    out += fmt::format(
        "<details><summary>Licences of uPlot and three.js, which draw this page"
        "</summary><pre>{}</pre></details>\n",
        escaped(assets::script_licence()));
  }
  return out + "</footer>\n";
}

/// Without scripts all numbers are shown, but no drawings.
std::string scripts(const std::string& data) {
  if (assets::script().empty()) return {};
  return fmt::format(
      "<script type=\"application/json\" id=\"page-data\">{}</script>\n<script>\n{}\n</script>\n",
      data, assets::script());
}

constexpr std::string_view kNoScripts =
    "<noscript><p class=\"doubt\">Scripts are off: numbers and tables are complete, the drawings "
    "are missing.</p></noscript>\n";
constexpr std::string_view kNoBundle =
    "<p class=\"doubt\">This program was built without the drawings of the report (RALI_WEB=OFF): "
    "numbers and tables are complete; map.ply opens in CloudCompare.</p>\n";

std::string page(const std::string& title, const std::string& subtitle,
                 const std::vector<Section>& sections, const std::string& data) {
  std::string out = head(title);
  out += fmt::format("<header><h1>{}</h1><p>{}</p>{}</header>\n", title, subtitle,
                     assets::script().empty() ? kNoBundle : kNoScripts);
  out += contents(sections);
  out += body(sections);
  out += foot();
  out += scripts(data);
  return out + "</body>\n</html>\n";
}

/// "2023-11-14 22:13" of seconds since 1970; empty for other clocks (time since boot).
/// Source of the calendar: H. Hinnant, "chrono-compatible low-level date algorithms",
/// civil_from_days.
std::string utc_text(Time t) {
  constexpr std::int64_t kDay_s = 86400, kFirst_s = 946684800, kLast_s = 4102444800;  // 2000, 2100
  const std::int64_t s = t.ns / 1'000'000'000;
  if (s < kFirst_s || s >= kLast_s) return {};
  const std::int64_t z = s / kDay_s + 719468, era = z / 146097, doe = z - era * 146097;
  const std::int64_t yoe = (doe - doe / 1460 + doe / 36524 - doe / 146096) / 365;
  const std::int64_t doy = doe - (365 * yoe + yoe / 4 - yoe / 100), mp = (5 * doy + 2) / 153;
  const std::int64_t month = mp < 10 ? mp + 3 : mp - 9;
  return fmt::format("{:04}-{:02}-{:02} {:02}:{:02}", yoe + era * 400 + (month <= 2 ? 1 : 0), month,
                     doy - (153 * mp + 2) / 5 + 1, s % kDay_s / 3600, s % 3600 / 60);
}

}  // namespace

std::string report_html(const RunData& run) {
  std::vector<std::string> names;
  for (const VehicleView& v : run.vehicles) names.push_back(v.name);
  const std::string title = names.empty() ? "RaLI map"
                            : names.size() > 4
                                ? fmt::format("RaLI map of {} vehicles", names.size())
                                : fmt::format("RaLI map of {}", names_text(names));
  std::string subtitle = run.version.empty()
                             ? std::string("report")
                             : fmt::format("report of rali {}", escaped(run.version));
  if (const std::string day = utc_text(run.begin); !day.empty()) {
    subtitle += fmt::format(", data from {} UTC", day);
  }
  return page(title, subtitle,
              {verdict_section(run), map_section(run), view3d_section(run), vehicles_section(run),
               ranges_section(run), fleet_section(run), truth_section(run), input_section(run),
               speed_section(run), settings_section(run)},
              page_data(run));
}

std::string comparison_html(const std::vector<RunData>& runs) {
  return page(fmt::format("RaLI: {} runs side by side", runs.size()), "comparison",
              comparison_sections(runs), page_data(runs));
}

Status write_report(const std::string& out_dir, const std::string& path) {
  const Result<RunData> run = read_run(out_dir);
  if (!run) return tl::make_unexpected(run.error());
  return io::write_file_atomic(path, report_html(*run));
}

Status write_comparison(const std::vector<std::string>& out_dirs, const std::string& path) {
  std::vector<RunData> runs;
  for (const std::string& dir : out_dirs) {
    Result<RunData> run = read_run(dir);
    if (!run) return tl::make_unexpected(run.error());
    runs.push_back(std::move(*run));
  }
  return io::write_file_atomic(path, comparison_html(runs));
}

}  // namespace rali::report
