#include "rali/cli/commands/demo.hpp"

#include <algorithm>
#include <filesystem>
#include <string_view>

#include <fmt/format.h>

#include "rali/cli/commands/commands.hpp"
#include "rali/cli/live_demo.hpp"
#include "rali/cli/parse.hpp"
#include "rali/io/files/atomic_file.hpp"
#include "rali/sim/world.hpp"

namespace rali::cli {
namespace {

using Words = std::vector<std::string>;

/// A tunnel in which a single vehicle is lost, because the LiDAR is degenerate along it. v1 stands
/// in the middle, v2 drives from one end to the other.
constexpr std::string_view kTunnel = R"(# The tunnel of rali demo: v1 stands, v2 drives past it.
tunnel: {length_m: 140}
vehicles:
  - {start: [70, -1.5]}
  - {start: [6, 0], goal: [132, 0]}
)";

/// Runs `rali simulate`, `rali map --truth` and `rali picture` in sequence, as a user would: a
/// tunnel with two vehicles, mapped without and with the ranges between them.
class DemoCommand final : public Command {
 public:
  [[nodiscard]] std::string name() const override { return "demo"; }

  [[nodiscard]] std::string summary() const override {
    return "simulate, map, evaluate, report and draw, in one go";
  }

  [[nodiscard]] std::vector<std::string> examples() const override {
    return {"rali demo", "rali demo --live"};
  }

  [[nodiscard]] std::string exit_codes() const override {
    return "as rali map: 0 done, 2 not started, 3 done with gaps, 4 disk, 130 interrupted";
  }

  [[nodiscard]] Positional positional() override { return {"", "", nullptr, 0, 0, {}}; }

  [[nodiscard]] std::vector<Option> options() override {
    return {
        {"-o,--out", "DIR", "gets recording/, out/, alone/ and map.png", &folder_, false, {}},
        {"--live",
         "",
         "three vehicles explore a floor in real time while you watch at http://127.0.0.1:8765",
         &live_,
         false,
         {}},
        {"--scene",
         "NAME",
         "another place than the tunnel; mapped once",
         &scene_,
         false,
         {sim::kSceneNames.begin(), sim::kSceneNames.end()}},
        {"--seed", "N", "another number, other noise and another place", &seed_, false, {}},
        {"--duration",
         "S",
         "length of the recording [s]; 0: the whole drive",
         &duration_s_,
         false,
         {}},
        {"--pedestrians", "N", "who walk about", &pedestrians_, false, {}},
        {"--threads", "N", "0: one per core; results do not depend on it", &threads_, true, {}},
    };
  }

  [[nodiscard]] Result<int> run(Session& session) override;

 private:
  [[nodiscard]] bool compares() const { return scene_.empty() && !live_; }

  [[nodiscard]] std::string place() const { return scene_.empty() ? "floor" : scene_; }

  [[nodiscard]] std::string path(const char* name) const { return folder_ + '/' + name; }

  [[nodiscard]] Result<std::string> scene() const;
  [[nodiscard]] Words simulate_words(const std::string& scene) const;
  [[nodiscard]] Words map_words() const;
  [[nodiscard]] Words map_alone_words() const;
  [[nodiscard]] Words picture_words() const;

  [[nodiscard]] Result<int> run_live(Session& session);
  [[nodiscard]] Result<int> map_and_draw(Session& session);

  bool live_ = false;
  std::string folder_ = "rali-demo", scene_;
  std::string seed_ = "1", duration_s_ = "0", pedestrians_ = "0", threads_ = "0";
};

/// The command line as typed into a shell.
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

/// The name of a shipped scene, or the tunnel's file.
Result<std::string> DemoCommand::scene() const {
  if (!compares()) return scene_;
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  if (error) return fail(ErrorCode::kMachine, folder_, error.message());
  const std::string file = path("tunnel.yaml");
  const Status status = io::write_file_atomic(file, kTunnel);
  if (!status) return tl::make_unexpected(status.error());
  return file;
}

Words DemoCommand::simulate_words(const std::string& scene) const {
  return {"simulate",  scene,        "-o",         path("recording"), "--seed",
          seed_,       "--duration", duration_s_,  "--pedestrians",   pedestrians_,
          "--threads", threads_,     "--overwrite"};
}

Words DemoCommand::map_words() const {
  return {"map",        path("recording/fleet.yaml"), "-o",        path("out"),
          "--truth",    path("recording/truth"),      "--threads", threads_,
          "--overwrite"};
}

/// The same data without the ranges.
Words DemoCommand::map_alone_words() const {
  return {"map",        path("recording/fleet.yaml"), "-o",        path("alone"),
          "--truth",    path("recording/truth"),      "--threads", threads_,
          "--set",      "ranging.use=false",          "--no-mcap", "--no-keyframes",
          "--overwrite"};
}

Words DemoCommand::picture_words() const {
  if (!compares()) {
    return {"picture", path("out"), "-o", path("map.png"), "--title", "RaLI demo: " + place()};
  }
  return {"picture",
          path("alone"),
          path("out"),
          "-o",
          path("map.png"),
          "--title",
          "RaLI demo: one drive through a smooth tunnel, mapped twice",
          "--caption",
          "LiDAR and IMU alone",
          "--caption",
          "with ranges to v1"};
}

/// Maps the recording of the live run again: the report then includes the ground truth.
Result<int> DemoCommand::run_live(Session& session) {
  LiveDemo demo;
  demo.folder = folder_;
  demo.scene = place();
  demo.seed = seed_;
  demo.duration_s = duration_s_;
  const Result<bool> whole = run_live_demo(demo, session);
  if (!whole) return tl::make_unexpected(whole.error());
  if (!*whole) {
    session.note("next: " + line_of(map_words()).substr(2));
    return 128 + stop_signal();
  }
  return map_and_draw(session);
}

/// Makes a map with its report, and a picture, from the recording.
Result<int> DemoCommand::map_and_draw(Session& session) {
  std::string mapped, drawn;
  const Result<int> map = run_step(map_words(), session, mapped);
  session.result(mapped);
  if (!map || (*map != kExitDone && *map != kExitGaps)) return map;
  const Result<int> picture = run_step(picture_words(), session, drawn);
  if (!picture) return picture;
  session.result(drawn);
  return map;
}

Result<int> DemoCommand::run(Session& session) {
  if (live_) return run_live(session);
  const Result<std::string> place = scene();
  if (!place) return tl::make_unexpected(place.error());
  std::string simulated, alone;
  const Result<int> simulation = run_step(simulate_words(*place), session, simulated);
  if (!simulation || *simulation != kExitDone) {
    // A simulation that did not start leaves nothing behind; a folder that is not empty stays.
    std::error_code ignored;
    if (compares()) std::filesystem::remove(*place, ignored);
    std::filesystem::remove(folder_, ignored);
    return simulation;
  }
  // Its last line suggests the next command, which the demo runs itself.
  session.note(simulated.substr(0, simulated.rfind("\nnext: ")));
  if (compares()) {
    const Result<int> code = run_step(map_alone_words(), session, alone);
    session.result("without ranges:\n" + alone + "\nwith ranges:\n");
    if (!code || (*code != kExitDone && *code != kExitGaps)) return code;
  }
  return map_and_draw(session);
}

}  // namespace

std::unique_ptr<Command> make_demo_command() { return std::make_unique<DemoCommand>(); }

}  // namespace rali::cli
