#include "rali/cli/commands/evaluate.hpp"

#include <algorithm>
#include <utility>

#include "rali/assess/evaluate_words.hpp"
#include "rali/assess/mesh_input.hpp"
#include "rali/assess/outputs.hpp"
#include "rali/drive/tbb_executor.hpp"

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
  [[nodiscard]] Result<assess::Evaluation> evaluate(const assess::RunInput& run);
  [[nodiscard]] Status judge_cloud(const assess::RunInput& run, assess::Evaluation& result) const;

  std::vector<std::string> inputs_, limit_texts_;
  std::string truth_, mesh_, align_ = "se3", fleet_ = "one", delta_ = "1,10,50",
                             associate_ = "interpolate", T_body_truth_text_, mesh_align_ = "none",
                             out_, pairs_ = "all";
  int threads_ = 0;
  assess::EvaluationOptions options_;
  geometry::SE3 T_body_truth_;
  std::vector<assess::Limit> limits_;
};

std::vector<Option> EvaluateCommand::options() {
  return {
      {"--truth", "PATH", "folder with <vehicle>.tum, or one file", &truth_, false, {}},
      {"--mesh",
       "FILE",
       "the true surfaces (default: mesh.ply beside the truth)",
       &mesh_,
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
      {"--delta", "LIST", "ways of the relative pose error [m]", &delta_, false, {}},
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
       "pieces of way: all (overlapping) or consecutive",
       &pairs_,
       true,
       {"all", "consecutive"}},
      {"-o,--out",
       "DIR",
       "where evaluation.json and errors/ go (default: INPUT, if a folder)",
       &out_,
       true,
       {}},
      {"--threads", "N", "0: one per core; results do not depend on it", &threads_, true, {}},
  };
}

Status EvaluateCommand::read_words() {
  if (inputs_.size() == 2) {
    if (!truth_.empty()) {
      return fail(ErrorCode::kUsage, "rali evaluate", "--truth and a second INPUT say the same",
                  "Leave one out.");
    }
    truth_ = inputs_[1];
  }
  if (threads_ < 0 || threads_ > 1024) {
    return fail(ErrorCode::kUsage, "--threads", "must be 0 to 1024");
  }
  const auto& names = eval::kAlignmentNames;
  const auto found = std::find(names.begin(), names.end(), align_);
  options_.align = static_cast<eval::Alignment>(found - names.begin());
  options_.each = fleet_ == "each";
  options_.all_pairs = pairs_ == "all";
  options_.mesh_icp = mesh_align_ == "icp";
  const auto distances = assess::parse_distances(delta_);
  if (!distances) return tl::make_unexpected(distances.error());
  options_.distances_m = *distances;
  const auto associate = assess::parse_association(associate_);
  if (!associate) return tl::make_unexpected(associate.error());
  options_.associate = *associate;
  if (!T_body_truth_text_.empty()) {
    const auto T = assess::parse_pose(T_body_truth_text_);
    if (!T) return tl::make_unexpected(T.error());
    T_body_truth_ = *T;
  }
  for (const std::string& text : limit_texts_) {
    const Result<assess::Limit> limit = assess::parse_limit(text);
    if (!limit) return tl::make_unexpected(limit.error());
    const auto distance_m = assess::rpe_distance_of(limit->name);
    auto& asked = options_.distances_m;
    if (distance_m && std::find(asked.begin(), asked.end(), *distance_m) == asked.end()) {
      asked.push_back(*distance_m);
    }
    limits_.push_back(*limit);
  }
  return {};
}

Status EvaluateCommand::judge_cloud(const assess::RunInput& run, assess::Evaluation& result) const {
  const Result<eval::PointList> points = assess::read_points(run.cloud);
  if (!points) return tl::make_unexpected(points.error());
  const std::unique_ptr<Executor> executor = drive::make_executor(threads_);
  const geometry::SE3 T = result.frames.empty() ? geometry::SE3{} : result.frames[0].T_truth_est;
  if (mesh_.empty()) {
    return assess::evaluate_cloud(run.cloud, *points, nullptr, T, *executor, result);
  }
  const Result<eval::TriangleMesh> mesh = assess::read_mesh(mesh_);
  if (!mesh) return tl::make_unexpected(mesh.error());
  result.mesh = mesh_;
  return assess::evaluate_cloud(run.cloud, *points, &*mesh, T, *executor, result);
}

Result<assess::Evaluation> EvaluateCommand::evaluate(const assess::RunInput& run) {
  assess::Evaluation result;
  result.options = options_;
  if (!truth_.empty()) {
    Result<assess::Evaluation> tracks = assess::evaluate_tracks(run, options_);
    if (!tracks) return tracks;
    result = std::move(*tracks);
  }
  result.input = run.name;
  result.truth = truth_;
  if (truth_.empty()) result.warnings = run.warnings;
  if (run.cloud.empty()) {
    if (mesh_align_ == "icp") result.warnings.emplace_back("there is no cloud to lay onto a mesh");
    return result;
  }
  if (Status s = judge_cloud(run, result); !s) return tl::make_unexpected(s.error());
  return result;
}

Result<int> EvaluateCommand::run(Session& session) {
  if (Status s = read_words(); !s) return tl::make_unexpected(s.error());
  if (mesh_.empty() && !truth_.empty()) mesh_ = assess::mesh_beside_truth(truth_);
  Result<assess::RunInput> input = assess::read_run(inputs_.front());
  if (!input) return tl::make_unexpected(input.error());
  if (!truth_.empty() && !input->vehicles.empty()) {
    if (Status s = assess::add_truth(truth_, T_body_truth_, *input); !s) {
      return tl::make_unexpected(s.error());
    }
  }
  if (truth_.empty() && input->cloud.empty()) {
    return fail(ErrorCode::kUsage, input->name, "is a trajectory, and there is no truth for it",
                "Give one with --truth.");
  }
  const Result<assess::Evaluation> result = evaluate(*input);
  if (!result) return tl::make_unexpected(result.error());
  for (const std::string& warning : result->warnings) session.warning(printable(warning) + '.');
  const std::string folder = out_.empty() && input->out_folder ? input->name : out_;
  if (!folder.empty()) {
    if (Status s = assess::write_evaluation(folder, *result, limits_); !s) {
      return tl::make_unexpected(s.error());
    }
  }
  session.result(session.options.json ? assess::evaluation_json(*result, limits_)
                                      : printable(assess::evaluation_table(*result)));
  const std::vector<std::string> broken = assess::broken_limits(limits_, *result);
  for (const std::string& sentence : broken) session.error(sentence + '.');
  return broken.empty() ? kExitDone : kExitBelowAsked;
}

}  // namespace

std::unique_ptr<Command> make_evaluate_command() { return std::make_unique<EvaluateCommand>(); }

}  // namespace rali::cli
