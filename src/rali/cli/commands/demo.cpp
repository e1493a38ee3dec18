#include "rali/cli/commands/demo.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "rali/cli/commands/commands.hpp"
#include "rali/cli/parse.hpp"
#include "rali/sim/world.hpp"

namespace rali::cli {
namespace {

using Words = std::vector<std::string>;

/// `rali simulate`, `rali map --truth` and `rali picture` one after another, each as a user would
/// type it.
class DemoCommand final : public Command {
 public:
  [[nodiscard]] std::string name() const override { return "demo"; }

  [[nodiscard]] std::string summary() const override {
    return "simulate, map, evaluate, report and draw, in one go";
  }

  [[nodiscard]] std::vector<std::string> examples() const override {
    return {"rali demo", "rali demo -o tunnel --scene tunnel"};
  }

  [[nodiscard]] std::string exit_codes() const override {
    return "as rali map: 0 done, 2 not started, 3 done with gaps, 4 disk, 130 interrupted";
  }

  [[nodiscard]] Positional positional() override { return {"", "", nullptr, 0, 0, {}}; }

  [[nodiscard]] std::vector<Option> options() override {
    return {
        {"-o,--out", "DIR", "gets recording/, out/ and map.png", &folder_, false, {}},
        {"--scene",
         "NAME",
         "the place",
         &scene_,
         false,
         {sim::kSceneNames.begin(), sim::kSceneNames.end()}},
        {"--seed", "N", "another number, another place of that kind", &seed_, false, {}},
        {"--duration",
         "S",
         "length of the recording [s]; 0: the whole way",
         &duration_s_,
         false,
         {}},
        {"--pedestrians", "N", "who walk about", &pedestrians_, false, {}},
        {"--threads", "N", "0: one per core; results do not depend on it", &threads_, true, {}},
    };
  }

  [[nodiscard]] Result<int> run(Session& session) override;

 private:
  [[nodiscard]] Words simulate_words() const;
  [[nodiscard]] Words map_words() const;
  [[nodiscard]] Words picture_words() const;

  std::string folder_ = "rali-demo", scene_ = "floor";
  std::string seed_ = "1", duration_s_ = "0", pedestrians_ = "4", threads_ = "0";
};

/// As it is typed into a shell.
std::string line_of(const Words& words) {
  std::string line = "$ rali";
  for (const std::string& word : words) {
    line += word.find(' ') == std::string::npos ? ' ' + word : fmt::format(" '{}'", word);
  }
  return line;
}

/// Runs a command of this program from its words, name first; its results go to `results`.
Result<int> run_step(const Words& words, Session& session, std::string& results) {
  CommandList commands = all_commands();
  const auto command = std::find_if(commands.begin(), commands.end(), [&](const auto& candidate) {
    return candidate->name() == words.front();
  });
  session.note(line_of(words));
  const Result<Parsed> parsed =
      parse_words(**command, session.options, {words.begin() + 1, words.end()});
  if (!parsed) return tl::make_unexpected(parsed.error());
  session.results_into(&results);
  Result<int> code = (*command)->run(session);
  session.results_into(nullptr);
  return code;
}

Words DemoCommand::simulate_words() const {
  return {"simulate",
          scene_,
          "-o",
          folder_ + "/recording",
          "--vehicles",
          "1",
          "--seed",
          seed_,
          "--duration",
          duration_s_,
          "--pedestrians",
          pedestrians_,
          "--threads",
          threads_,
          "--overwrite"};
}

Words DemoCommand::map_words() const {
  return {"map",        folder_ + "/recording/fleet.yaml", "-o",        folder_ + "/out",
          "--truth",    folder_ + "/recording/truth",      "--threads", threads_,
          "--overwrite"};
}

Words DemoCommand::picture_words() const {
  return {"picture", folder_ + "/out",
          "-o",      folder_ + "/map.png",
          "--title", fmt::format("RaLI demo: {}, one vehicle, 16 rings and IMU", scene_)};
}

Result<int> DemoCommand::run(Session& session) {
  std::string simulated, mapped, drawn;
  const Result<int> simulation = run_step(simulate_words(), session, simulated);
  if (!simulation || *simulation != kExitDone) return simulation;
  // Its last line says what to type next; here that follows by itself.
  session.note(simulated.substr(0, simulated.rfind("\nnext: ")));
  const Result<int> map = run_step(map_words(), session, mapped);
  session.result(mapped);
  if (!map || (*map != kExitDone && *map != kExitGaps)) return map;
  const Result<int> picture = run_step(picture_words(), session, drawn);
  if (!picture) return picture;
  session.result(drawn);
  return map;
}

}  // namespace

std::unique_ptr<Command> make_demo_command() { return std::make_unique<DemoCommand>(); }

}  // namespace rali::cli
