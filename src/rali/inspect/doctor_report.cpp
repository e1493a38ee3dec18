#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "rali/base/counted.hpp"
#include "rali/inspect/doctor.hpp"

namespace rali::inspect {
namespace {

constexpr double kDegPerRad = 180.0 / std::numbers::pi;

std::string_view point_time_name(wire::PointTime time) {
  return wire::kPointTimeNames[static_cast<std::size_t>(time)];
}

/// A quoted YAML string; escapes names from a file.
std::string yaml_string(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

nlohmann::ordered_json number(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

nlohmann::ordered_json finding_json(const Finding& f, const std::string& path) {
  nlohmann::ordered_json j;
  j["id"] = f.id;
  j["severity"] = severity_name(f.severity);
  j["vehicle"] = f.vehicle;
  j["path"] = path;
  j["topic"] = f.topic;
  j["value"] = number(f.value);
  j["limit"] = number(f.limit);
  j["text"] = f.text;
  j["effect"] = f.effect;
  j["remedy"] = f.remedy;
  return j;
}

nlohmann::ordered_json found_json(const DoctorReport& r) {
  nlohmann::ordered_json j;
  j["lidar_topic"] = r.lidar_topic;
  j["imu_topic"] = r.imu_topic;
  if (r.format) {
    j["model"] = r.format->model;
    j["point_time"] = point_time_name(r.format->point_time);
    j["header_stamp"] = r.format->header_stamp == wire::HeaderStamp::kEnd ? "end" : "start";
  }
  j["accel_scale"] = number(r.accel_scale);
  j["gyro_scale"] = number(r.gyro_scale);
  j["turned_rad"] = number(r.rotations.turned_rad);
  const auto& offset = r.rotations.time_offset_s;
  j["time_offset_s"] = offset ? number(*offset) : nlohmann::ordered_json(nullptr);
  j["time_offset_sigma_s"] =
      offset ? number(r.rotations.time_offset_sigma_s) : nlohmann::ordered_json(nullptr);
  return j;
}

std::size_t count(const FindingList& findings, Severity severity) {
  return static_cast<std::size_t>(
      std::count_if(findings.begin(), findings.end(),
                    [severity](const Finding& f) { return f.severity == severity; }));
}

std::string verdict(const FindingList& findings) {
  const std::size_t errors = count(findings, Severity::kError);
  const std::size_t warnings = count(findings, Severity::kWarning);
  if (errors > 0) {
    return fmt::format("not fit: {}, {}", counted(errors, "error"), counted(warnings, "warning"));
  }
  return warnings > 0 ? fmt::format("fit, with {}", counted(warnings, "warning")) : "fit";
}

std::string pose_yaml(const geometry::SE3& T) {
  const geometry::Vec3 rpy = geometry::rpy_from_rotation(T.R) * kDegPerRad;
  return fmt::format("{{xyz_m: [{:.4f}, {:.4f}, {:.4f}], rpy_deg: [{:.3f}, {:.3f}, {:.3f}]}}",
                     T.p.x(), T.p.y(), T.p.z(), rpy.x(), rpy.y(), rpy.z());
}

std::string lidar_yaml(const DoctorReport& r) {
  std::string out = "    lidar:\n";
  out +=
      fmt::format("      topic: {}\n", r.lidar_topic.empty() ? "auto" : yaml_string(r.lidar_topic));
  if (r.format) {
    out += fmt::format("      point_time: {}\n", point_time_name(r.format->point_time));
    out += fmt::format("      header_stamp: {}\n",
                       r.format->header_stamp == wire::HeaderStamp::kEnd ? "end" : "start");
  }
  const imu::RotationStudy& s = r.rotations;
  if (r.T_body_lidar) {
    out += fmt::format("      T_body_lidar: {}\n", pose_yaml(*r.T_body_lidar));
  } else if (s.gyro_ratio != 0.0 && s.second_axis_fraction > 0.1 && s.best.misfit < 0.1) {
    out += "      # rotation from the data; the lever arm is not observable: measure it\n";
    out += fmt::format("      T_body_lidar: {}\n",
                       pose_yaml({s.best.R_imu_lidar, geometry::Vec3::Zero()}));
  }
  if (s.time_offset_s) {
    out += fmt::format("      time_offset_s: {:.4f}  # sigma {:.4f}\n", *s.time_offset_s,
                       s.time_offset_sigma_s);
  }
  return out;
}

std::string imu_yaml(const DoctorReport& r) {
  if (r.imu_topic.empty()) return "    imu: {topic: none}\n";
  std::string out = fmt::format("    imu:\n      topic: {}\n", yaml_string(r.imu_topic));
  out += fmt::format("      accel_unit: {}\n", r.accel_scale > 5.0 ? "g" : "m_s2");
  out += fmt::format("      gyro_unit: {}\n", r.gyro_scale < 0.1 ? "deg_s" : "rad_s");
  return out;
}

/// The ranges of the recordings; only for a fleet.
std::string ranges_yaml(const RangeInputs& inputs, const RangeStudy& study) {
  std::string sources;
  for (const std::string& file : inputs.files) {
    sources += fmt::format("    - {{file: {}}}\n", yaml_string(file));
  }
  for (const auto& [topic, radios] : study.radios()) {
    std::vector<std::string> ids;
    for (const auto& [number, vehicle] : radios.own) {
      ids.push_back(fmt::format("{}: {}", number, vehicle));
    }
    for (const std::int64_t number : radios.received) {
      if (radios.own.contains(number)) continue;
      sources += fmt::format(
          "    # radio {} is in no recording: add it to ids as NUMBER: vehicle\n", number);
    }
    sources += fmt::format("    - {{topic: {}{}}}\n", yaml_string(topic),
                           ids.empty() ? "" : fmt::format(", ids: {{{}}}", fmt::join(ids, ", ")));
  }
  if (sources.empty()) return {};
  return "ranges:\n  sources:\n" + sources;
}

std::string findings_text(const FindingList& findings) {
  std::string out;
  for (const Finding& f : findings) {
    out += fmt::format("{:<8}{} {}{}\n", severity_name(f.severity), f.id,
                       f.topic.empty() ? "" : f.topic + ": ", f.text);
    std::string more = f.effect;
    if (!more.empty() && more.back() != '.') more += '.';
    if (!f.remedy.empty()) more += more.empty() ? f.remedy : " " + f.remedy;
    if (!more.empty()) out += fmt::format("            {}\n", more);
  }
  return out;
}

}  // namespace

const char* severity_name(Severity severity) {
  switch (severity) {
    case Severity::kError:
      return "error";
    case Severity::kWarning:
      return "warning";
    case Severity::kInfo:
      return "info";
  }
  return "info";
}

std::string doctor_text(const DoctorReport& report) {
  return fmt::format("{}: {} ({:.1f} s checked)\n", report.path, verdict(report.findings),
                     report.seconds) +
         findings_text(report.findings);
}

std::string ranges_text(const FindingList& findings) {
  if (findings.empty()) return {};
  return fmt::format("ranges: {}\n", verdict(findings)) + findings_text(findings);
}

std::string doctor_json(const DoctorResult& result) {
  nlohmann::ordered_json j;
  FindingList all = result.ranges;
  for (const DoctorReport& r : result.recordings) {
    all.insert(all.end(), r.findings.begin(), r.findings.end());
  }
  j["schema"] = 2;
  j["verdict"] = verdict(all);
  j["vehicles"] = nlohmann::ordered_json::array();
  j["findings"] = nlohmann::ordered_json::array();
  for (const DoctorReport& r : result.recordings) {
    j["vehicles"].push_back({{"vehicle", r.vehicle},
                             {"path", r.path},
                             {"seconds", number(r.seconds)},
                             {"verdict", verdict(r.findings)},
                             {"found", found_json(r)}});
    for (const Finding& f : r.findings) j["findings"].push_back(finding_json(f, r.path));
  }
  for (const Finding& f : result.ranges) j["findings"].push_back(finding_json(f, f.topic));
  // Names in a file may hold any bytes; JSON must be UTF-8.
  return j.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

std::string doctor_fleet_yaml(const std::vector<DoctorReport>& reports, const RangeInputs& inputs,
                              const RangeStudy& ranges) {
  std::string out = "schema: 1\nvehicles:\n";
  const std::string between = ranges_yaml(inputs, ranges);
  std::vector<std::string> reported;
  for (const DoctorReport& r : reports) {
    if (std::find(reported.begin(), reported.end(), r.vehicle) != reported.end()) continue;
    reported.push_back(r.vehicle);
    std::vector<std::string> paths;
    for (const DoctorReport& part : reports) {
      if (part.vehicle == r.vehicle) paths.push_back(yaml_string(part.path));
    }
    out += fmt::format(
        "  {}:\n    recording: {}\n", r.vehicle,
        paths.size() == 1 ? paths.front() : fmt::format("[{}]", fmt::join(paths, ", ")));
    out += lidar_yaml(r) + imu_yaml(r);
    if (!between.empty()) {
      out +=
          "    antennas: {uwb: {xyz_m: [0, 0, 0]}}  # measure: in body, x forward, y left, z up "
          "[m]\n";
    }
  }
  return out + between;
}

}  // namespace rali::inspect
