#include "rali/cli/commands/convert.hpp"

#include <filesystem>

#include <fmt/format.h>

#include "rali/io/convert/convert.hpp"

namespace rali::cli {
namespace {

namespace fs = std::filesystem;

class ConvertCommand final : public Command {
 public:
  [[nodiscard]] std::string name() const override { return "convert"; }

  [[nodiscard]] std::string summary() const override {
    return "recordings, clouds and trajectories into other formats";
  }

  [[nodiscard]] std::vector<std::string> examples() const override {
    return {"rali convert run1.bag run1.mcap", "rali convert out/map.pcd map.las"};
  }

  [[nodiscard]] std::string exit_codes() const override {
    return "0 done, 2 not readable or OUT exists, 3 the input is damaged, 4 disk, 130 interrupted";
  }

  [[nodiscard]] Positional positional() override {
    return {"IN OUT",
            "recording to .mcap; cloud to .pcd .ply .las .bin; trajectory to .tum .kitti .euroc "
            ".csv",
            &words_,
            2,
            2,
            {}};
  }

  [[nodiscard]] std::vector<Option> options() override {
    return {{"--to", "KIND", "what OUT becomes, if its extension names something else", &to_, false,
             io::convert_targets()},
            {"--times",
             "FILE",
             "stamps of a trajectory that has none (KITTI), one a line [s]",
             &times_,
             false,
             {}},
            {"--overwrite", "", "replace OUT", &overwrite_, false, {}}};
  }

  [[nodiscard]] Result<int> run(Session& session) override {
    const std::string& in = words_[0];
    const std::string& out = words_[1];
    if (Status status = check_target(in, out); !status) {
      return tl::make_unexpected(status.error());
    }
    io::ConvertOptions options{to_, times_, {}};
    options.go_on = [&](double fraction) {
      if (session.live() && !session.options.quiet) {
        session.live_line(fmt::format("{} {:3.0f} %", out, 100.0 * fraction));
      }
      return !stop_requested().load();
    };
    const auto done = io::convert(in, out, options);
    session.live_line("");
    if (!done) return tl::make_unexpected(done.error());
    for (const Finding& finding : done->findings) {
      if (finding.severity == Severity::kInfo) {
        session.detail(finding.text);
      } else {
        session.warning(finding.text);
      }
    }
    for (const std::string& sentence : done->lost) session.note("not in " + out + ": " + sentence);
    session.result(fmt::format("{}: {}\n", out, done->done));
    return done->gaps ? kExitGaps : kExitDone;
  }

 private:
  [[nodiscard]] Status check_target(const std::string& in, const std::string& out) const {
    std::error_code error;
    if (!fs::exists(fs::symlink_status(out, error))) return {};
    if (fs::equivalent(in, out, error)) {
      return fail(ErrorCode::kUsage, out, "is input and output at once", "Choose another name.");
    }
    if (fs::is_directory(out, error)) {
      return fail(ErrorCode::kUsage, out, "is a folder", "Name a file.");
    }
    if (overwrite_) return {};
    return fail(ErrorCode::kUsage, out, "exists", "Choose another name, or --overwrite.");
  }

  std::vector<std::string> words_;
  std::string to_, times_;
  bool overwrite_ = false;
};

}  // namespace

std::unique_ptr<Command> make_convert_command() { return std::make_unique<ConvertCommand>(); }

}  // namespace rali::cli
