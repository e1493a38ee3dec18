#include "rali/report/section/blind_strip.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include <fmt/format.h>

#include "rali/report/internal/html.hpp"
#include "rali/report/plot/axis.hpp"
#include "rali/report/plot/svg_plot.hpp"
#include "rali/report/section/blind_words.hpp"
#include "rali/report/section/section.hpp"

namespace rali::report {
namespace {

/// Columns of the drawing: a bar is never thinner than a pixel.
constexpr std::size_t kColumns = 620;
/// Sweeps farther apart leave a hole.
constexpr double kGap_s = 1.0;
constexpr Rgb kUsedColour = {0, 96, 148};

constexpr std::array<std::string_view, 3> kSightClasses = {"sight-full", "sight-partial",
                                                           "sight-none"};
constexpr std::array<std::string_view, 3> kSightWords = {
    "seen in every direction", "seen badly in one direction", "nothing seen along one axis"};
constexpr std::array<std::string_view, kHeldByCount> kHeldClasses = {"held-lidar", "held-range",
                                                                     "held-imu", "held-nothing"};
constexpr std::array<std::string_view, kHeldByCount> kHeldWords = {
    "held by the LiDAR", "held by ranges", "held by inertia alone", "held by nothing"};

/// What a strip stands over: time or way.
struct Ruler {
  std::function<double(double)> of_time;
  double end = 0.0, gap = kGap_s;
  std::string label, unit;
};

/// Way driven until a time.
class WayAt {
 public:
  explicit WayAt(const std::vector<WayPoint>& way) : way_(way) {
    double sum_m = 0.0;
    for (std::size_t i = 0; i < way.size(); ++i) {
      if (i > 0) sum_m += (way[i].p_m - way[i - 1].p_m).norm();
      until_m_.push_back(sum_m);
    }
  }

  [[nodiscard]] double end_m() const { return until_m_.empty() ? 0.0 : until_m_.back(); }

  [[nodiscard]] double m(double t_s) const {
    if (way_.empty()) return kUnknown;
    const auto after = std::lower_bound(way_.begin(), way_.end(), t_s,
                                        [](const WayPoint& w, double t) { return w.t_s < t; });
    if (after == way_.begin()) return 0.0;
    const auto i = static_cast<std::size_t>(after - way_.begin());
    if (after == way_.end()) return until_m_.back();
    const double span_s = way_[i].t_s - way_[i - 1].t_s;
    const double part = span_s > 0.0 ? (t_s - way_[i - 1].t_s) / span_s : 0.0;
    return until_m_[i - 1] + part * (until_m_[i] - until_m_[i - 1]);
  }

 private:
  const std::vector<WayPoint>& way_;
  std::vector<double> until_m_;
};

std::string span_words(const StateRun& run, const Ruler& ruler) {
  return fmt::format("{:.1f} to {:.1f} {}", run.begin, run.end, ruler.unit);
}

template <class State>
std::vector<StateRun> runs_of(const VehicleView& v, const Ruler& ruler, State&& state) {
  std::vector<StateSample> samples;
  samples.reserve(v.degeneracy.size());
  for (const DegeneracyPoint& d : v.degeneracy) {
    samples.push_back({ruler.of_time(d.t_s), static_cast<std::size_t>(state(d))});
  }
  return state_runs(samples, ruler.end, ruler.gap, kColumns);
}

TimeRow sight_row(const VehicleView& v, const Ruler& ruler) {
  TimeRow row{"LiDAR sees", {}};
  for (const StateRun& run : runs_of(v, ruler, [](const auto& d) { return d.sight; })) {
    row.bars.push_back({run.begin, run.end, std::string(kSightClasses[run.state]),
                        fmt::format("{}, {}", kSightWords[run.state], span_words(run, ruler)), "",
                        0.0, 1.0});
  }
  return row;
}

TimeRow held_row_over(const VehicleView& v, const Ruler& ruler, std::string label) {
  TimeRow row{std::move(label), {}};
  for (const StateRun& run : runs_of(v, ruler, [](const auto& d) { return d.held_by; })) {
    const bool nothing = run.state == static_cast<std::size_t>(HeldBy::kNothing);
    row.bars.push_back({run.begin, run.end, std::string(kHeldClasses[run.state]),
                        fmt::format("{}, {}", kHeldWords[run.state], span_words(run, ruler)),
                        nothing ? "nothing" : "", 0.0, 1.0});
  }
  return row;
}

/// Used above, rejected below: both may come at one time.
TimeRow heard_row(const VehicleView& v, const Ruler& ruler) {
  TimeRow row{"ranges heard", {}};
  const auto add = [&](bool used) {
    std::vector<StateSample> samples;
    for (const Heard& h : v.heard) {
      if ((used ? h.used : h.rejected) == 0) continue;
      samples.push_back({ruler.of_time(std::max(h.begin_s, 0.0)), 0});
      samples.push_back({ruler.of_time(h.end_s), 0});
    }
    for (const StateRun& run : state_runs(samples, ruler.end, ruler.gap, kColumns)) {
      row.bars.push_back(
          {run.begin, run.end, used ? "heard-used" : "heard-rejected",
           fmt::format("ranges {}, {}", used ? "used" : "rejected", span_words(run, ruler)), "",
           used ? 0.5 : 0.0, used ? 1.0 : 0.42});
    }
  };
  add(true);
  add(false);
  return row;
}

/// Expected error along the worst direction; measured ones beside it where there is a truth.
Plot off_plot(const VehicleView& v, const Ruler& ruler) {
  Plot plot;
  plot.x_label = ruler.label;
  plot.x_unit = ruler.unit;
  plot.y_label = "off along it [m]";
  plot.y_unit = "m";
  plot.log_y = true;
  plot.x_min = 0.0;
  plot.x_max = ruler.end;
  plot.left = kRowsLeft;
  plot.width = kRowsWidth;
  plot.height = 130.0;
  Series off{"may be off along its worst direction, 1 sigma", {}, {}, {kUsedColour, ""}};
  off.filled = true;
  for (const DegeneracyPoint& d : v.degeneracy) {
    off.x.push_back(ruler.of_time(d.t_s));
    off.y.push_back(d.off_m);
  }
  // Errors near zero must not widen the axis.
  Range sizes;
  for (const double off_m : off.y) {
    if (off_m > 0.0) sizes.add(off_m);
  }
  if (!sizes.empty()) plot.y_min = 0.4 * sizes.low();
  Series error{"measured along the blind axis", {}, {}, {kBlindColour, ""}, true, 2.0};
  for (const ErrorPoint& e : v.errors) {
    if (!std::isfinite(e.along_blind_m)) continue;
    error.x.push_back(ruler.of_time(e.t_s));
    error.y.push_back(std::abs(e.along_blind_m));
  }
  plot.series.push_back(std::move(off));
  if (!error.x.empty()) plot.series.push_back(std::move(error));
  return plot;
}

std::string strip_over(const VehicleView& v, const Ruler& ruler) {
  std::vector<TimeRow> rows = {sight_row(v, ruler), held_row_over(v, ruler, "what held it")};
  if (!v.heard.empty()) rows.push_back(heard_row(v, ruler));
  const std::string plot = svg_of(off_plot(v, ruler));
  const std::string words = "blindness of " + v.name + " over " + ruler.label;
  return svg_of(rows, RowAxis{ruler.end, ruler.label, plot.empty()}, words) + plot;
}

Ruler time_ruler(double end_s) {
  return {[](double t_s) { return t_s; }, end_s, kGap_s, "time [s]", "s"};
}

std::string key(std::string_view css_class, std::string_view words) {
  return fmt::format(
      "<span><svg width=\"24\" height=\"14\"><rect class=\"{}\" width=\"24\" height=\"14\"/></svg> "
      "{}</span>",
      css_class, words);
}

std::string legend(const VehicleView& v) {
  std::string out = "<p class=\"legend\">";
  for (std::size_t i = 0; i < kSightClasses.size(); ++i)
    out += key(kSightClasses[i], kSightWords[i]);
  for (std::size_t i = 0; i < kHeldByCount; ++i) out += key(kHeldClasses[i], kHeldWords[i]);
  if (!v.heard.empty()) {
    out += key("heard-used", "ranges used") + key("heard-rejected", "ranges rejected");
  }
  return out + "</p>\n";
}

}  // namespace

std::string_view held_class(HeldBy by) { return kHeldClasses[static_cast<std::size_t>(by)]; }

std::string_view held_words(HeldBy by) { return kHeldWords[static_cast<std::size_t>(by)]; }

std::string_view held_legend() {
  static const std::string kLegend = [] {
    std::string out = "<p class=\"legend\">";
    for (std::size_t i = 0; i < kHeldByCount; ++i) out += key(kHeldClasses[i], kHeldWords[i]);
    return out + "</p>\n";
  }();
  return kLegend;
}

TimeRow held_row(const VehicleView& v, double end_s) {
  return held_row_over(v, time_ruler(end_s), v.name);
}

std::vector<StateRun> blind_runs(const VehicleView& v, std::size_t columns) {
  std::vector<StateSample> samples;
  double end_s = 0.0;
  for (const DegeneracyPoint& d : v.degeneracy) {
    const auto by = static_cast<std::size_t>(d.held_by);
    samples.push_back({d.t_s, d.blind ? std::max<std::size_t>(by, 1) : 0});
    end_s = std::max(end_s, d.t_s);
  }
  std::vector<StateRun> runs = state_runs(samples, end_s, kGap_s, columns);
  std::erase_if(runs, [](const StateRun& run) { return run.state == 0; });
  return runs;
}

std::string blind_strip_html(const RunData& run, const VehicleView& v, std::size_t number) {
  if (v.degeneracy.empty()) return {};
  const std::string over_time = strip_over(v, time_ruler(last_time_s(run)));
  const std::string head = legend(v);
  if (stood(v)) return head + "<figure>" + over_time + "</figure>\n";
  const WayAt way(v.way);
  // A vehicle that stands a while covers no way: no gap of way is a hole.
  const Ruler ruler{[&](double t_s) { return way.m(t_s); }, way.end_m(), way.end_m(),
                    "way driven [m]", "m"};
  return fmt::format(
      "<div class=\"switch\"><input type=\"radio\" name=\"strip{0}\" id=\"strip{0}-time\" checked>"
      "<label for=\"strip{0}-time\">over time</label><input type=\"radio\" name=\"strip{0}\" "
      "id=\"strip{0}-way\"><label for=\"strip{0}-way\">over the way driven</label>{3}<figure "
      "class=\"a\">{1}</figure><figure class=\"b\">{2}</figure></div>\n",
      number, over_time, strip_over(v, ruler), head);
}

}  // namespace rali::report
