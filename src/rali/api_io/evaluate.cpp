#include "rali/evaluate.hpp"

#include "rali/api/convert.hpp"
#include "rali/api/errors.hpp"
#include "rali/assess/outputs.hpp"
#include "rali/jobs/evaluate_job.hpp"

namespace rali {
namespace {

eval::Alignment inner_alignment(Alignment alignment) {
  switch (alignment) {
    case Alignment::kSe3:
      return eval::Alignment::kSe3;
    case Alignment::kYaw:
      return eval::Alignment::kYaw;
    case Alignment::kOrigin:
      return eval::Alignment::kOrigin;
    case Alignment::kNone:
      break;
  }
  return eval::Alignment::kNone;
}

ErrorStatistics public_statistics(const eval::Statistics& s) {
  return {s.count, s.rmse, s.mean, s.median, s.std, s.min, s.max};
}

TrackErrors public_errors(const std::string& name, const assess::TrackScore& score) {
  TrackErrors errors;
  errors.name = name;
  errors.poses = score.poses;
  errors.distance_m = score.path_m;
  errors.ape_m = public_statistics(score.ape_m);
  errors.rotation_rad = public_statistics(score.rotation_rad);
  for (const assess::RpeScore& rpe : score.rpe) {
    errors.rpe.push_back({rpe.distance_m, public_statistics(rpe.translation_m),
                          public_statistics(rpe.rotation_rad)});
  }
  if (score.nees6) errors.nees = score.nees6->mean;
  return errors;
}

}  // namespace

Evaluation evaluate(const std::string& input, const EvaluateOptions& options) {
  jobs::EvaluateJob job;
  job.input = input;
  job.truth = options.truth;
  job.mesh = options.mesh;
  job.T_body_truth = api::inner_pose(options.T_body_truth);
  job.options.align = inner_alignment(options.alignment);
  job.options.each = options.each;
  job.options.distances_m = options.distances_m;
  job.out = options.out;
  job.threads = options.threads;
  const assess::Evaluation inner = api::value_or_throw(jobs::run_evaluation(job));
  Evaluation result;
  result.fleet = public_errors("fleet", inner.fleet);
  for (const assess::VehicleScore& vehicle : inner.vehicles) {
    result.vehicles.push_back(public_errors(vehicle.name, vehicle.trajectory));
  }
  if (inner.cloud) {
    result.cloud.points = inner.cloud->points;
    if (inner.cloud->to_mesh) {
      result.cloud.to_mesh_m = public_statistics(inner.cloud->to_mesh->within);
      result.cloud.fraction_beyond = inner.cloud->to_mesh->fraction_beyond;
    }
  }
  result.warnings = inner.warnings;
  result.json = assess::evaluation_json(inner, {});
  result.table = assess::evaluation_table(inner);
  return result;
}

}  // namespace rali
