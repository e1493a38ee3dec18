#include "rali/cli/commands/evaluate.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "rali/assess/evaluate_words.hpp"
#include "rali/assess/outputs.hpp"
#include "rali/cli/commands/report.hpp"
#include "rali/jobs/evaluate_job.hpp"

namespace rali::cli {
namespace {

class EvaluateCommand final : public Command {
 public:
  [[nodiscard]] std::string name() const override { return "evaluate"; }

  [[nodiscard]] std::string summary() const override {
    return "results against truth: APE, RPE, drift, NEES, cloud to mesh";
  }

  [[nodiscard]] std::vector<std::string> examples() const override {
    return {"rali evaluate out --truth truth --limit ape_rmse_m=0.2",
            "rali evaluate estimate.tum truth.tum --associate nearest:0.01"};
  }

  [[nodiscard]] std::string exit_codes() const override {
    return "0 done, 1 a --limit is exceeded, 2 input unfit, 4 disk";
  }

  [[nodiscard]] bool json() const override { return true; }

  [[nodiscard]] Positional positional() override {
    return {"INPUT", "folder of rali map, trajectory (TUM) and its truth, or cloud", &inputs_, 1, 2,
            {}};
  }

  [[nodiscard]] std::vector<Option> options() override;
  [[nodiscard]] Result<int> run(Session& session) override;

 private:
  [[nodiscard]] Status read_words();

  std::vector<std::string> inputs_, limit_texts_;
  std::string align_ = "se3", fleet_ = "one", delta_ = "1,10,50", associate_ = "interpolate",
              T_body_truth_text_, mesh_align_ = "none", pairs_ = "all";
  jobs::EvaluateJob job_;
};

std::vector<Option> EvaluateCommand::options() {
  return {
      {"--truth", "PATH", "folder with <vehicle>.tum, or one file", &job_.truth, false, {}},
      {"--mesh",
       "FILE",
       "the true surfaces (default: mesh.ply beside the truth)",
       &job_.mesh,
       false,
       {}},
      {"--align",
       "HOW",
       "se3 (as evo -a), yaw, origin, none",
       &align_,
       false,
       {"se3", "yaw", "origin", "none"}},
      {"--fleet",
       "HOW",
       "one alignment for all vehicles, or each its own",
       &fleet_,
       false,
       {"one", "each"}},
      {"--delta", "LIST", "distances of the relative pose error [m]", &delta_, false, {}},
      {"--associate", "HOW", "interpolate, or nearest:SECONDS (as evo)", &associate_, false, {}},
      {"--limit",
       "NAME=MAX",
       "exit 1 above it; v1:NAME=MAX for one vehicle",
       &limit_texts_,
       false,
       {}},
      {"--mesh-align",
       "HOW",
       "lay the map onto the mesh first: icp",
       &mesh_align_,
       false,
       {"none", "icp"}},
      {"--T-body-truth",
       "LIST",
       "pose in the body of what the truth follows: "
       "x,y,z [m], roll,pitch,yaw [deg]",
       &T_body_truth_text_,
       true,
       {}},
      {"--pairs",
       "WHICH",
       "segments of the path: all (overlapping) or consecutive",
       &pairs_,
       true,
       {"all", "consecutive"}},
      {"-o,--out",
       "DIR",
       "where evaluation.json and errors/ go (default: INPUT, if a folder)",
       &job_.out,
       true,
       {}},
      {"--threads", "N", "0: one per core; results do not depend on it", &job_.threads, true, {}},
  };
}

Status EvaluateCommand::read_words() {
  job_.input = inputs_.front();
  if (inputs_.size() == 2) {
    if (!job_.truth.empty()) {
      return fail(ErrorCode::kUsage, "rali evaluate", "--truth and a second INPUT name the same",
                  "Leave one out.");
    }
    job_.truth = inputs_[1];
  }
  if (job_.threads < 0 || job_.threads > 1024) {
    return fail(ErrorCode::kUsage, "--threads", "must be 0 to 1024");
  }
  const auto& names = eval::kAlignmentNames;
  const auto found = std::find(names.begin(), names.end(), align_);
  job_.options.align = static_cast<eval::Alignment>(found - names.begin());
  job_.options.each = fleet_ == "each";
  job_.options.all_pairs = pairs_ == "all";
  job_.options.mesh_icp = mesh_align_ == "icp";
  const auto distances = assess::parse_distances(delta_);
  if (!distances) return tl::make_unexpected(distances.error());
  job_.options.distances_m = *distances;
  const auto associate = assess::parse_association(associate_);
  if (!associate) return tl::make_unexpected(associate.error());
  job_.options.associate = *associate;
  if (!T_body_truth_text_.empty()) {
    const auto T = assess::parse_pose(T_body_truth_text_);
    if (!T) return tl::make_unexpected(T.error());
    job_.T_body_truth = *T;
  }
  for (const std::string& text : limit_texts_) {
    const Result<assess::Limit> limit = assess::parse_limit(text);
    if (!limit) return tl::make_unexpected(limit.error());
    const auto distance_m = assess::rpe_distance_of(limit->name);
    auto& asked = job_.options.distances_m;
    if (distance_m && std::find(asked.begin(), asked.end(), *distance_m) == asked.end()) {
      asked.push_back(*distance_m);
    }
    job_.limits.push_back(*limit);
  }
  return {};
}

Result<int> EvaluateCommand::run(Session& session) {
  if (Status s = read_words(); !s) return tl::make_unexpected(s.error());
  const Result<assess::Evaluation> result = jobs::run_evaluation(job_);
  if (!result) return tl::make_unexpected(result.error());
  for (const std::string& warning : result->warnings) session.warning(printable(warning) + '.');
  for (const assess::Limit& limit : job_.limits) {
    if (limit.text.find(limit.name) != std::string::npos) continue;
    session.warning(
        fmt::format("--limit {}: the name is now {}. The old one is read in this release only.",
                    printable(limit.text), limit.name));
  }
  warn_of_old_names({inputs_.front()}, session);
  session.result(session.options.json ? assess::evaluation_json(*result, job_.limits)
                                      : printable(assess::evaluation_table(*result)));
  const std::vector<std::string> broken = assess::broken_limits(job_.limits, *result);
  for (const std::string& sentence : broken) session.error(sentence + '.');
  return broken.empty() ? kExitDone : kExitBelowAsked;
}

}  // namespace

std::unique_ptr<Command> make_evaluate_command() { return std::make_unique<EvaluateCommand>(); }

}  // namespace rali::cli
