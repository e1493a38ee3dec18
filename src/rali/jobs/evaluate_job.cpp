#include "rali/jobs/evaluate_job.hpp"

#include <filesystem>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include "rali/assess/mesh_input.hpp"
#include "rali/assess/outputs.hpp"
#include "rali/drive/tbb_executor.hpp"
#include "rali/jobs/run_report.hpp"

namespace rali::jobs {
namespace {

Status judge_cloud(const EvaluateJob& job, const assess::RunInput& run,
                   assess::Evaluation& result) {
  const Result<eval::PointList> points = assess::read_points(run.cloud);
  if (!points) return tl::make_unexpected(points.error());
  const std::unique_ptr<Executor> executor = drive::make_executor(job.threads);
  const geometry::SE3 T = result.frames.empty() ? geometry::SE3{} : result.frames[0].T_truth_est;
  const std::string mesh_file =
      job.mesh.empty() && !job.truth.empty() ? assess::mesh_beside_truth(job.truth) : job.mesh;
  if (mesh_file.empty()) {
    return assess::evaluate_cloud(run.cloud, *points, nullptr, T, *executor, result);
  }
  const Result<eval::TriangleMesh> mesh = assess::read_mesh(mesh_file);
  if (!mesh) return tl::make_unexpected(mesh.error());
  result.mesh = mesh_file;
  return assess::evaluate_cloud(run.cloud, *points, &*mesh, T, *executor, result);
}

Result<assess::Evaluation> judge(const EvaluateJob& job, const assess::RunInput& run) {
  assess::Evaluation result;
  result.options = job.options;
  if (!job.truth.empty()) {
    Result<assess::Evaluation> tracks = assess::evaluate_tracks(run, job.options);
    if (!tracks) return tracks;
    result = std::move(*tracks);
  }
  result.input = run.name;
  result.truth = job.truth;
  if (job.truth.empty()) result.warnings = run.warnings;
  if (run.cloud.empty()) {
    if (job.options.mesh_icp) {
      result.warnings.emplace_back("there is no cloud to lay onto a mesh");
    }
    return result;
  }
  if (Status s = judge_cloud(job, run, result); !s) return tl::make_unexpected(s.error());
  return result;
}

/// Renews the report: an older one would lack the comparison with the truth.
Status renew_report(const std::string& folder) {
  std::error_code error;
  if (!std::filesystem::exists(folder + "/report.html", error)) return {};
  return add_report(folder);
}

}  // namespace

Result<assess::Evaluation> run_evaluation(const EvaluateJob& job) {
  Result<assess::RunInput> run = assess::read_run(job.input);
  if (!run) return tl::make_unexpected(run.error());
  if (!job.truth.empty() && !run->vehicles.empty()) {
    if (Status s = assess::add_truth(job.truth, job.T_body_truth, *run); !s) {
      return tl::make_unexpected(s.error());
    }
  }
  if (job.truth.empty() && run->cloud.empty()) {
    return fail(ErrorCode::kUsage, run->name, "is a trajectory, and there is no truth for it",
                "Give one with --truth.");
  }
  Result<assess::Evaluation> result = judge(job, *run);
  if (!result) return result;
  const std::string folder = job.out.empty() && run->out_folder ? run->name : job.out;
  if (folder.empty()) return result;
  if (Status s = assess::write_evaluation(folder, *result, job.limits); !s) {
    return tl::make_unexpected(s.error());
  }
  if (run->out_folder && job.out.empty()) {
    if (Status s = renew_report(folder); !s) return tl::make_unexpected(s.error());
  }
  return result;
}

std::string evaluation_line(const assess::Evaluation& evaluation) {
  const assess::TrackScore& fleet = evaluation.fleet;
  std::string text = fmt::format(
      "against the truth: position off by {:.3f} m (rmse), {:.3f} m at most, on {:.0f} m",
      fleet.ape_m.rmse, fleet.ape_m.max, fleet.path_m);
  if (evaluation.cloud && evaluation.cloud->to_mesh) {
    const eval::CloudToMesh& mesh = *evaluation.cloud->to_mesh;
    text += fmt::format("; map to the true surfaces {:.3f} m (mean)", mesh.within.mean);
    if (mesh.fraction_beyond >= 0.001) {
      text += fmt::format(", {:.1f} % of it beyond 1 m", 100.0 * mesh.fraction_beyond);
    }
  }
  return text;
}

}  // namespace rali::jobs
