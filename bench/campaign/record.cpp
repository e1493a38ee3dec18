#include "record.hpp"

#include <fstream>

#include <nlohmann/json.hpp>

namespace rali::campaign {

using Json = nlohmann::ordered_json;

namespace {

Json track_json(const std::optional<TrackScore>& track) {
  if (!track) return nullptr;
  Json json{{"rmse_m", track->rmse_m},      {"max_m", track->max_m},
            {"end_m", track->end_m},        {"sigma_max_m", track->sigma_max_m},
            {"nees", track->nees_position}, {"poses", track->poses},
            {"failures_s", Json::array()}};
  for (const auto& [begin, end] : track->failures_s) json["failures_s"].push_back({begin, end});
  return json;
}

double real(const Json& json) { return json.is_number() ? json.get<double>() : 1e9; }

std::optional<TrackScore> track_of(const Json& json) {
  if (json.is_null()) return std::nullopt;
  TrackScore out;
  out.rmse_m = real(json.at("rmse_m"));
  out.max_m = real(json.at("max_m"));
  out.end_m = real(json.at("end_m"));
  out.sigma_max_m = real(json.at("sigma_max_m"));
  out.nees_position = real(json.at("nees"));
  out.poses = json.at("poses");
  for (const Json& span : json.at("failures_s")) out.failures_s.emplace_back(span[0], span[1]);
  return out;
}

Json score_json(const RunScore& s) {
  Json json{{"solvable_alone", s.solvable.alone},
            {"solvable_joint", s.solvable.joint},
            {"only_blind", s.only_degenerate},
            {"groups", s.groups},
            {"fleet_rmse_m", s.fleet_rmse_m},
            {"gaps", s.gaps},
            {"lost", s.lost},
            {"ranges", s.ranges},
            {"ranges_used", s.ranges_used},
            {"said", s.reported},
            {"error", s.error},
            {"vehicles", Json::array()},
            {"silent", Json::array()}};
  for (const VehicleScore& v : s.vehicles) {
    json["vehicles"].push_back({{"name", v.name},
                                {"distance_m", v.distance_m},
                                {"diverged_s", v.diverged_s},
                                {"pose_findings", v.pose_findings},
                                {"odometry", track_json(v.odometry)},
                                {"live", track_json(v.live)},
                                {"final", track_json(v.final)}});
  }
  for (const SilentFailure& f : s.silent) {
    json["silent"].push_back({{"vehicle", f.vehicle},
                              {"trajectory", f.trajectory},
                              {"begin_s", f.start_s},
                              {"end_s", f.end_s},
                              {"error_m", f.error_m},
                              {"sigma_m", f.sigma_m}});
  }
  return json;
}

RunScore score_of(const Json& json) {
  RunScore s;
  s.solvable = {json.at("solvable_alone"), json.at("solvable_joint")};
  s.only_degenerate = json.value("only_blind", std::size_t{0});  // absent in older records
  s.groups = json.at("groups");
  s.fleet_rmse_m = real(json.at("fleet_rmse_m"));
  s.gaps = json.at("gaps");
  s.lost = json.at("lost");
  s.ranges = json.at("ranges");
  s.ranges_used = json.at("ranges_used");
  s.reported = json.at("said").get<std::vector<std::string>>();
  s.error = json.at("error");
  for (const Json& v : json.at("vehicles")) {
    VehicleScore score;
    score.name = v.at("name");
    score.distance_m = real(v.at("distance_m"));
    score.diverged_s = real(v.at("diverged_s"));
    score.pose_findings = v.at("pose_findings");
    score.odometry = track_of(v.at("odometry"));
    score.live = track_of(v.at("live"));
    score.final = track_of(v.at("final"));
    s.vehicles.push_back(std::move(score));
  }
  for (const Json& f : json.at("silent")) {
    s.silent.push_back({f.at("vehicle"), f.at("trajectory"), real(f.at("begin_s")),
                        real(f.at("end_s")), real(f.at("error_m")), real(f.at("sigma_m"))});
  }
  return s;
}

}  // namespace

std::string to_json(const RunRecord& r) {
  Json json{{"seed", r.seed},
            {"block", r.block},
            {"build", r.build},
            {"ranges_hash", r.ranges_hash},
            {"scene", r.scene},
            {"plan", r.plan},
            {"priors", r.priors},
            {"features", r.features},
            {"vehicles", r.vehicles},
            {"duration_s", r.duration_s},
            {"cpu_simulated_s", r.cpu_simulated_s},
            {"cpu_mapped_s", r.cpu_mapped_s},
            {"score", score_json(r.score)}};
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Result<RunRecord> from_json(const std::string& line) {
  const Json json = Json::parse(line, nullptr, false);
  if (json.is_discarded()) return fail(ErrorCode::kInput, "", "a line is no result");
  RunRecord r;
  r.seed = json.at("seed");
  r.block = json.at("block");
  r.build = json.at("build");
  r.ranges_hash = json.at("ranges_hash");
  r.scene = json.at("scene");
  r.plan = json.at("plan");
  r.priors = json.at("priors");
  r.features = json.at("features").get<std::vector<std::string>>();
  r.vehicles = json.at("vehicles");
  r.duration_s = json.at("duration_s");
  r.cpu_simulated_s = json.at("cpu_simulated_s");
  r.cpu_mapped_s = json.at("cpu_mapped_s");
  r.score = score_of(json.at("score"));
  return r;
}

Result<std::vector<RunRecord>> read_records(const std::string& path) {
  std::ifstream file(path);
  if (!file) return fail(ErrorCode::kInput, path, "cannot be read");
  std::vector<RunRecord> records;
  for (std::string line; std::getline(file, line);) {
    if (Result<RunRecord> record = from_json(line)) records.push_back(std::move(*record));
  }
  return records;
}

}  // namespace rali::campaign
