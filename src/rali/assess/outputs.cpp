#include "rali/assess/outputs.hpp"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <numbers>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "rali/eval/consistency.hpp"
#include "rali/io/files/atomic_file.hpp"
#include "rali/io/files/csv_writer.hpp"
#include "rali/io/files/sha256.hpp"

namespace rali::assess {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDegree = std::numbers::pi / 180.0;

/// Rounded below the tolerance for agreement with evo (1e-9), to hide differences in the last bit.
Json number(double value) {
  if (!std::isfinite(value)) return nullptr;
  const double rounded = std::round(value * 1e12) / 1e12;
  return std::isfinite(rounded) ? rounded + 0.0 : value;
}

Json optional_number(const std::optional<double>& value) {
  return value ? number(*value) : Json(nullptr);
}

Json statistics_json(const eval::Statistics& s, double scale = 1.0) {
  if (s.count == 0) return nullptr;
  return {{"count", s.count},
          {"rmse", number(s.rmse * scale)},
          {"mean", number(s.mean * scale)},
          {"median", number(s.median * scale)},
          {"std", number(s.std * scale)},
          {"min", number(s.min * scale)},
          {"max", number(s.max * scale)},
          {"sse", number(s.sse * scale * scale)}};
}

Json pose_json(const geometry::SE3& T) {
  const Eigen::Quaterniond q(T.R);
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;
  return {
      {"xyz_m", {number(T.p.x()), number(T.p.y()), number(T.p.z())}},
      {"quat_xyzw",
       {number(sign * q.x()), number(sign * q.y()), number(sign * q.z()), number(sign * q.w())}}};
}

Json nees_json(const std::optional<NeesScore>& s) {
  if (!s) return nullptr;
  const double dof = s->dof;
  const eval::NeesBounds bounds = eval::nees_bounds(1, s->dof);
  return {{"dof", s->dof},
          {"poses", s->poses},
          {"mean", number(s->mean)},
          {"expected_mean", dof},
          {"median", number(s->median)},
          {"bounds_one_run", {number(bounds.low), number(bounds.high)}},
          {"fraction_within_95", number(s->fraction_within_95)}};
}

Json track_json(const TrackScore& s) {
  Json json;
  json["poses"] = s.poses;
  json["time_fraction"] = number(s.time_fraction);
  json["distance_m"] = number(s.path_m);
  json["ape_m"] = statistics_json(s.ape_m);
  json["ape_deg"] = statistics_json(s.rotation_rad, 1.0 / kDegree);
  json["ape_alone_rmse_m"] = optional_number(s.alone_rmse_m);
  json["rpe"] = Json::array();
  for (const RpeScore& rpe : s.rpe) {
    json["rpe"].push_back({{"distance_m", number(rpe.distance_m)},
                           {"m", statistics_json(rpe.translation_m)},
                           {"deg", statistics_json(rpe.rotation_rad, 1.0 / kDegree)}});
  }
  if (s.drift) {
    json["drift_final_m"] = number(s.drift->final_m);
    json["drift_final_deg"] = number(s.drift->final_rad / kDegree);
    json["drift_z_m"] = optional_number(s.drift->z_m);
  }
  json["degenerate"] = nullptr;
  if (s.degenerate) {
    json["degenerate"] = {{"distance_fraction", number(s.degenerate->path_fraction)},
                          {"along_m", statistics_json(s.degenerate->along_m)},
                          {"across_m", statistics_json(s.degenerate->across_m)}};
  }
  json["nees_pose"] = nees_json(s.nees6);
  json["nees_position"] = nees_json(s.nees3);
  json["covariances_unusable"] = s.covariances_unusable;
  json["reference_poses"] = s.reference_poses;
  return json;
}

Json to_mesh_json(const eval::CloudToMesh& c) {
  return {{"points", c.all.count},
          {"mean_m", number(c.within.mean)},
          {"std_m", number(c.within.std)},
          {"rmse_m", number(c.within.rmse)},
          {"median_m", number(c.within.median)},
          {"p95_m", number(c.p95_m)},
          {"max_m", number(c.within.max)},
          {"cut_m", number(eval::CloudToMeshOptions{}.cut_m)},
          {"beyond_cut", c.beyond},
          {"fraction_beyond_cut", number(c.fraction_beyond)},
          {"uncut",
           {{"mean_m", number(c.all.mean)},
            {"std_m", number(c.all.std)},
            {"max_m", number(c.all.max)}}},
          {"not_finite", c.not_finite},
          {"thinned_m", number(eval::CloudToMeshOptions{}.thin_m)},
          {"completeness", number(c.completeness)},
          {"complete_within_m", number(eval::CloudToMeshOptions{}.complete_m)},
          {"mesh_samples", c.samples}};
}

Json cloud_json(const CloudScore& c, const std::string& mesh) {
  Json json;
  json["file"] = c.file;
  json["points"] = c.points;
  json["mesh"] = mesh.empty() ? Json(nullptr) : Json(mesh);
  json["to_mesh"] = c.to_mesh ? to_mesh_json(*c.to_mesh) : Json(nullptr);
  json["before_icp"] = c.before_icp ? to_mesh_json(*c.before_icp) : Json(nullptr);
  json["icp"] = nullptr;
  if (c.icp) {
    json["icp"] = {{"T_mesh_cloud", pose_json(c.icp->T_mesh_cloud)},
                   {"rmse_start_m", number(c.icp->rmse_start_m)},
                   {"rmse_m", number(c.icp->rmse_m)},
                   {"overlap", number(eval::MeshIcpOptions{}.overlap)},
                   {"iterations", c.icp->iterations},
                   {"converged", c.icp->converged},
                   {"degenerate_directions", c.icp->open_directions}};
  }
  const eval::MapShapeOptions shape;
  json["shape"] = {{"points", c.shape.points},
                   {"thinned_m", number(shape.thin_m)},
                   {"thickness_m", statistics_json(c.shape.thickness)},
                   {"thickness_p95_m", number(c.shape.thickness_p95_m)},
                   {"patch_radius_m", number(shape.patch_radius_m)},
                   {"mme", optional_number(c.shape.mme)},
                   {"mme_radius_m", number(shape.entropy_radius_m)}};
  return json;
}

Json settings_json(const EvaluationOptions& o) {
  const bool nearest = o.associate.mode == eval::AssociationMode::kNearest;
  Json json;
  json["align"] = eval::kAlignmentNames[static_cast<std::size_t>(o.align)];
  json["fleet"] = o.each ? "each" : "one";
  json["associate"] = nearest ? "nearest" : "interpolate";
  json[nearest ? "max_dt_s" : "max_gap_s"] =
      number(nearest ? o.associate.max_dt_s : o.associate.max_gap_s);
  json["rpe_pairs"] = o.all_pairs ? "all" : "consecutive";
  json["rpe_along"] = "truth";
  json["mesh_align"] = o.mesh_icp ? "icp" : "none";
  return json;
}

}  // namespace

std::string evaluation_json(const Evaluation& e, const std::vector<Limit>& limits) {
  Json json;
  json["schema"] = 2;
  json["input"] = e.input;
  json["truth"] = e.truth.empty() ? Json(nullptr) : Json(e.truth);
  json["how"] = e.how();
  json["settings"] = settings_json(e.options);
  json["frames"] = Json::array();
  for (const FrameScore& frame : e.frames) {
    json["frames"].push_back(
        {{"vehicles", frame.vehicles},
         {"alignment", eval::kAlignmentNames[static_cast<std::size_t>(frame.used)]},
         {"T_truth_est", pose_json(frame.T_truth_est)}});
  }
  json["vehicles"] = Json::object();
  for (const VehicleScore& v : e.vehicles) {
    json["vehicles"][v.name]["trajectory"] = track_json(v.trajectory);
    json["vehicles"][v.name]["live"] = v.live ? track_json(*v.live) : Json(nullptr);
    json["vehicles"][v.name]["odometry"] = v.odometry ? track_json(*v.odometry) : Json(nullptr);
  }
  json["fleet"] = nullptr;
  if (!e.vehicles.empty()) {
    json["fleet"] = {
        {"trajectory", track_json(e.fleet)},
        {"live", e.fleet_live ? track_json(*e.fleet_live) : Json(nullptr)},
        {"odometry", e.fleet_odometry ? track_json(*e.fleet_odometry) : Json(nullptr)}};
  }
  json["between"] = Json::array();
  for (const PairScore& pair : e.between) {
    json["between"].push_back({{"vehicles", {pair.a, pair.b}},
                               {"m", statistics_json(pair.translation_m)},
                               {"deg", statistics_json(pair.rotation_rad, 1.0 / kDegree)}});
  }
  json["cloud"] = e.cloud ? cloud_json(*e.cloud, e.mesh) : Json(nullptr);
  json["limits"] = Json::array();
  for (const Limit& limit : limits) {
    json["limits"].push_back({{"limit", limit.text}, {"kept", broken_limits({limit}, e).empty()}});
  }
  json["warnings"] = e.warnings;
  // File names may hold any bytes; invalid UTF-8 is replaced instead of throwing.
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + '\n';
}

std::string errors_csv(const std::vector<PoseRow>& rows) {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  std::string text = "stamp_s,ape_m,rot_deg,ex,ey,ez,along_degenerate_m,nees\n";
  for (const PoseRow& row : rows) {
    io::CsvRow csv;
    csv.stamp(row.t).fixed(row.ape_m, 6).fixed(row.rot_rad / kDegree, 6);
    for (int axis = 0; axis < 3; ++axis) csv.fixed(row.error_m[axis], 6);
    csv.fixed(row.along_degenerate_m.value_or(kUnknown), 6).fixed(row.nees6.value_or(kUnknown), 6);
    text += csv.line() + '\n';
  }
  return text;
}

namespace {

/// status.json lists the SHA-256 of all outputs; the files written here are added. Without a run's
/// status.json nothing is written.
Status note_in_status(const std::string& folder, const std::vector<std::string>& names) {
  const std::string path = folder + "/status.json";
  std::ifstream in(path);
  if (!in) return {};
  Json status = Json::parse(in, nullptr, false);
  if (!status.is_object() || !status.contains("files") || !status["files"].is_object()) return {};
  std::map<std::string, Json> files;
  for (const auto& [name, sha] : status["files"].items()) files[name] = sha;
  for (const std::string& name : names) {
    const Result<std::string> sha = io::sha256_file(folder + '/' + name);
    if (!sha) return tl::make_unexpected(sha.error());
    files[name] = *sha;
  }
  status["files"] = Json::object();
  for (const auto& [name, sha] : files) status["files"][name] = sha;
  return io::write_file_atomic(path, status.dump(1) + '\n');
}

}  // namespace

Status write_evaluation(const std::string& folder, const Evaluation& evaluation,
                        const std::vector<Limit>& limits) {
  std::error_code error;
  std::filesystem::create_directories(folder + "/errors", error);
  if (error) return fail(ErrorCode::kMachine, folder + "/errors", error.message());
  std::vector<std::string> names;
  for (const VehicleScore& v : evaluation.vehicles) {
    names.push_back("errors/" + v.name + ".csv");
    const std::string text = errors_csv(v.rows);
    if (Status s = io::write_file_atomic(folder + '/' + names.back(), text); !s) return s;
  }
  names.emplace_back("evaluation.json");
  const std::string text = evaluation_json(evaluation, limits);
  if (Status s = io::write_file_atomic(folder + "/evaluation.json", text); !s) return s;
  return note_in_status(folder, names);
}

}  // namespace rali::assess
