#pragma once

#include <string>
#include <vector>

#include "rali/assess/evaluation.hpp"
#include "rali/assess/limits.hpp"

namespace rali::jobs {

/// What is compared with which ground truth: `rali evaluate`, `rali map --truth` and `rali demo`.
struct EvaluateJob {
  std::string input;           ///< folder of rali map, trajectory (TUM), or cloud
  std::string truth;           ///< folder with <vehicle>.tum, or one file; empty: none
  std::string mesh;            ///< the true surfaces; empty: mesh.ply beside the truth, if any
  geometry::SE3 T_body_truth;  ///< pose, in the body frame, of the point that the truth describes
  assess::EvaluationOptions options;
  std::vector<assess::Limit> limits;
  std::string out;  ///< folder for evaluation.json and errors/; empty: `input`, if it is a folder
  int threads = 0;  ///< 0: one per core; results do not depend on it
};

/// Evaluates, writes evaluation.json and errors/, and renews report.html if the output folder of
/// the run has one. Errors: kUsage (a trajectory without truth), kInput, kNoAnswer, kMachine.
[[nodiscard]] Result<assess::Evaluation> run_evaluation(const EvaluateJob& job);

/// "against the truth: position off by 0.006 m (rmse), ...": the evaluation in one line, without
/// its line end.
[[nodiscard]] std::string evaluation_line(const assess::Evaluation& evaluation);

}  // namespace rali::jobs
