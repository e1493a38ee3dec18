#include "rali/cli/app.hpp"

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <new>
#include <stdexcept>

#include <gtest/gtest.h>

#include "rali/base/assert.hpp"
#include "rali/cli/commands/commands.hpp"
#include "rali/cli/completion.hpp"
#include "rali/cli/help.hpp"
#include "rali/cli/man_page.hpp"
#include "rali/cli/parse.hpp"
#include "rali/cli/run_for_test.hpp"
#include "rali/io/files/test_folder.hpp"

namespace rali::cli {
namespace {

void expect_fits(const std::string& text, std::size_t lines_max, const std::string& what) {
  std::size_t lines = 0, begin = 0;
  for (std::size_t end = text.find('\n'); end != std::string::npos; end = text.find('\n', begin)) {
    EXPECT_LE(end - begin, 80U) << what << ": " << text.substr(begin, end - begin);
    begin = end + 1;
    ++lines;
  }
  EXPECT_LE(lines, lines_max) << what << '\n' << text;
}

TEST(App, without_a_command_prints_usage_and_exits_with_2) {
  const Outcome nothing = run_rali({});
  EXPECT_EQ(nothing.code, 2);
  EXPECT_EQ(nothing.out, "");
  EXPECT_NE(nothing.err.find("usage: rali COMMAND"), std::string::npos);
  const Outcome help = run_rali({"--help"});
  EXPECT_EQ(help.code, 0);
  EXPECT_EQ(help.err, "");
  EXPECT_NE(help.out.find("map"), std::string::npos);
}

TEST(App, prints_the_version_on_stdout) {
  EXPECT_EQ(run_rali({"--version"}).out.substr(0, 5), "rali ");
  EXPECT_EQ(run_rali({"--version"}).code, 0);
}

TEST(App, an_unknown_command_is_refused_with_the_most_similar_one) {
  const Outcome typo = run_rali({"mapp", "a.bag"});
  EXPECT_EQ(typo.code, 2);
  EXPECT_EQ(typo.err, "rali: error: unknown command 'mapp'. Did you mean 'map'?\n");
}

TEST(App, an_unknown_option_is_refused_with_the_most_similar_one) {
  const Outcome typo = run_rali({"map", "a.bag", "--oevrwrite"});
  EXPECT_EQ(typo.code, 2);
  EXPECT_EQ(typo.err,
            "rali: error: rali map: unknown option '--oevrwrite'. Did you mean --overwrite?\n");
}

TEST(App, missing_inputs_and_values_are_usage_errors) {
  EXPECT_EQ(run_rali({"map"}).err, "rali: error: rali map: INPUT is missing. See `rali map -h`.\n");
  EXPECT_EQ(run_rali({"map", "a.bag", "--out"}).code, 2);
  EXPECT_EQ(run_rali({"map", "a.bag", "--threads", "many"}).code, 2);
  EXPECT_EQ(run_rali({"map", "a.bag", "--preset", "papr"}).code, 2);
  EXPECT_EQ(run_rali({"completion"}).code, 2);
  EXPECT_EQ(run_rali({"completion", "csh"}).err,
            "rali: error: rali completion: 'csh' is none of bash, zsh, fish.\n");
}

TEST(App, settings_errors_name_file_and_line) {
  const auto dir = std::filesystem::temp_directory_path() / "rali_cli_app_test";
  std::filesystem::create_directories(dir);
  const std::string path = (dir / "fleet.yaml").string();
  std::ofstream(path) << "vehicles: {v1: {recording: a.bag}}\nsettings:\n  output:\n    map: 3\n";
  const Outcome wrong = run_rali({"map", path});
  std::filesystem::remove_all(dir);
  EXPECT_EQ(wrong.code, 2);
  EXPECT_EQ(wrong.err.substr(0, 13 + path.size() + 3), "rali: error: " + path + ":3:") << wrong.err;
  EXPECT_EQ(run_rali({"map", "/nowhere/fleet.yaml"}).err,
            "rali: error: /nowhere/fleet.yaml: cannot be opened.\n");
  EXPECT_EQ(run_rali({"map", "a.yaml", "b.bag"}).code, 2);
}

TEST(App, settings_of_the_command_line_are_checked_before_anything_is_read) {
  EXPECT_NE(run_rali({"map", "a.bag", "--set", "output.map_voxel=1"})
                .err.find("Did you mean 'map_voxel_m'?"),
            std::string::npos);
  EXPECT_NE(run_rali({"map", "a.bag", "--map-voxel", "-1"})
                .err.find("output.map_voxel_m is -1; allowed is"),
            std::string::npos);
  EXPECT_NE(run_rali({"map", "a.bag", "--lidar-model", "vlp17"}).err.find("lidar.model"),
            std::string::npos);
  EXPECT_NE(
      run_rali({"map", "a.bag", "b.bag", "--lidar-topic", "/x"}).err.find("there are 2 vehicles"),
      std::string::npos);
  EXPECT_NE(run_rali({"map", "a.bag", "--formats", "pcd,xyz"}).err.find("'xyz' is no format"),
            std::string::npos);
  EXPECT_NE(run_rali({"map", "a.bag", "--formats", ""}).err, "");
  EXPECT_NE(run_rali({"map", "a.bag", "--require", "max_sigma_m"}).err.find("Write connected"),
            std::string::npos);
  EXPECT_NE(
      run_rali({"map", "a.bag", "--require", "conected"}).err.find("Did you mean 'connected'?"),
      std::string::npos);
  EXPECT_NE(run_rali({"map", "a.bag", "--threads", "-3"}).err.find("is not 0 to 1024"),
            std::string::npos);
  EXPECT_NE(run_rali({"map", "a.bag", "--threads", "abc"}).err.find("abc is no whole number"),
            std::string::npos);
  EXPECT_NE(
      run_rali({"map", "a.bag", "-o", "x", "-o", "y"}).err.find("--out is given more than once"),
      std::string::npos);
  EXPECT_NE(run_rali({"map", "a.bag", "--dry-run", "--json"}).err.find("Leave --json out"),
            std::string::npos);
  EXPECT_EQ(run_rali({"completion", "bash", "--json"}).code, 2);
  EXPECT_NE(
      run_rali({"map", "a.bag", "--start", "1", "--duration", "2.5"}).err.find("no such file"),
      std::string::npos)
      << "numbers of the command line were refused as text";
  EXPECT_NE(run_rali({"map", "a.bag", "--start", "-1"}).err.find("start_s is -1"),
            std::string::npos);
}

TEST(App, a_missing_recording_is_named_in_the_error) {
  EXPECT_EQ(run_rali({"map", "/nowhere/a.bag"}).err,
            "rali: error: /nowhere/a.bag: there is no such file or folder.\n");
  EXPECT_EQ(run_rali({"map", "/nowhere/a.bag"}).code, 2);
}

TEST(App, control_characters_of_an_argument_do_not_reach_the_terminal) {
  EXPECT_EQ(run_rali({"\033[31mred"}).err.find('\033'), std::string::npos);
}

TEST(App, the_log_file_has_the_same_text_as_stderr) {
  const std::string path =
      (std::filesystem::temp_directory_path() / "rali_cli_log_test.txt").string();
  const Outcome logged = run_rali({"map", "/nowhere/fleet.yaml", "--log", path});
  std::ifstream file(path);
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  std::filesystem::remove(path);
  EXPECT_EQ(text, logged.err);
  EXPECT_EQ(run_rali({"map", "a.bag", "--log", "/nowhere/log"}).code, 4);
}

TEST(App, a_failed_assertion_exits_with_5_and_prints_file_and_line) {
  testing::internal::CaptureStderr();
  Session session;
  EXPECT_EQ(run_guarded(
                []() -> int {
                  RALI_ASSERT(1 == 2);
                  return 0;
                },
                session),
            5);
  EXPECT_EQ(run_guarded([]() -> int { throw std::bad_alloc(); }, session), 4);
  EXPECT_EQ(run_guarded([]() -> int { throw 7; }, session), 5);
  const std::string text = testing::internal::GetCapturedStderr();
  EXPECT_NE(text.find("app_test.cpp:"), std::string::npos) << text;
  EXPECT_NE(text.find("assertion '1 == 2' failed"), std::string::npos) << text;
  EXPECT_EQ(text.find("run.log"), std::string::npos) << "no run has written one: " << text;
}

TEST(HelpSettings, prints_the_public_settings_and_with_all_the_unstable_ones_too) {
  const std::string unstable = "`settings.ranging.gate.chi2`";
  const Outcome some = run_rali({"help-settings"}), all = run_rali({"help-settings", "--all"});
  EXPECT_NE(some.out.find("## The map is doubled after fast turns"), std::string::npos);
  EXPECT_EQ(some.out.find(unstable), std::string::npos);
  EXPECT_NE(all.out.find(unstable), std::string::npos);
}

TEST(ExitCodes, an_internal_error_asks_the_user_to_report_the_run_log) {
  const io::TestFolder folder;
  Session session;
  session.run_log = folder.write("run.log", "x");
  testing::internal::CaptureStderr();
  EXPECT_EQ(run_guarded([]() -> int { throw std::runtime_error("why"); }, session), 5);
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            "rali: error: internal fault: why. Please report it with " + session.run_log + ".\n");
}

TEST(ExitCodes, an_error_after_a_written_run_is_in_log_and_status) {
  const io::TestFolder folder;
  folder.write("run.log", "    0.100 complete\n");
  folder.write("status.json", "{\"status\": \"complete\"}");
  folder.write("metrics.json", "{}");
  Session session;
  session.written_run = folder.path();
  session.run_log = folder.path("run.log");
  for (const bool memory : {false, true}) {
    testing::internal::CaptureStderr();
    const auto fault = [memory]() -> int {
      if (memory) throw std::bad_alloc();
      throw std::runtime_error("why");
    };
    EXPECT_EQ(run_guarded(fault, session), memory ? 4 : 5);
    testing::internal::GetCapturedStderr();
    const std::string log = folder.read("run.log");
    EXPECT_NE(log.find(memory ? "internal fault: std::bad_alloc" : "internal fault: why"),
              std::string::npos)
        << log;
    EXPECT_NE(log.find("0.100 complete"), std::string::npos) << "the lines of the run are kept";
    const std::string status = folder.read("status.json");
    EXPECT_NE(status.find("\"failed\""), std::string::npos) << status;
    EXPECT_NE(status.find("metrics.json"), std::string::npos) << "with the files that are whole";
  }
}

TEST(ExitCodes, an_error_before_writing_leaves_an_older_run_unchanged) {
  const io::TestFolder folder;
  Session session;
  session.run_log = folder.write("run.log", "x");
  folder.write("status.json", "{\"status\": \"complete\"}");
  testing::internal::CaptureStderr();
  EXPECT_EQ(run_guarded([]() -> int { throw std::runtime_error("why"); }, session), 5);
  testing::internal::GetCapturedStderr();
  EXPECT_EQ(folder.read("run.log"), "x");
  EXPECT_EQ(folder.read("status.json"), "{\"status\": \"complete\"}");
}

TEST(Signals, the_first_requests_a_stop_and_the_second_exits_at_once) {
  for (const int number : {SIGINT, SIGTERM}) {
    EXPECT_EXIT(
        {
          watch_signals();
          std::raise(number);
          if (!stop_requested() || stop_signal() != number) std::_Exit(1);
          std::raise(number);
          std::_Exit(2);
        },
        testing::ExitedWithCode(128 + number), "");
  }
}

TEST(Help, of_each_command_fits_40_lines_of_80_columns_with_two_examples) {
  expect_fits(program_help(all_commands()), 40, "rali");
  for (const auto& command : all_commands()) {
    expect_fits(command_help(*command, false), 40, command->name());
    expect_fits(command_help(*command, true), 80, command->name() + " --help-all");
    EXPECT_GE(command->examples().size(), 2U) << command->name();
    for (const std::string& example : command->examples()) {
      EXPECT_NE(example.find("rali " + command->name()), std::string::npos);
    }
  }
}

TEST(Help, omits_rare_options_that_help_all_lists) {
  for (const auto& command : all_commands()) {
    const std::string brief = command_help(*command, false), all = command_help(*command, true);
    for (const Option& option : command->options()) {
      EXPECT_NE(all.find(option.names.substr(option.names.rfind(',') + 1)), std::string::npos);
      if (option.rare) {
        EXPECT_EQ(brief.find("  " + option.names + ' '), std::string::npos);
      }
    }
  }
}

TEST(Help, of_the_radio_option_explains_the_use_of_signal_strengths) {
  const Outcome help = run_rali({"map", "--help-all"});
  EXPECT_NE(help.out.find("CSV of signal strengths: why rounds end"), std::string::npos);
  EXPECT_EQ(help.out.find("not used"), std::string::npos) << help.out;
}

TEST(Completion, of_each_shell_contains_every_command_and_option) {
  for (const std::string shell : {"bash", "zsh", "fish"}) {
    const Outcome script = run_rali({"completion", shell});
    EXPECT_EQ(script.code, 0);
    for (const auto& command : all_commands()) {
      if (command->hidden()) {
        EXPECT_EQ(script.out.find(command->name()), std::string::npos);
        continue;
      }
      EXPECT_NE(script.out.find(command->name()), std::string::npos);
      for (const Option& option : command->options()) {
        const std::string name = option.names.substr(option.names.find("--") + 2);
        EXPECT_NE(script.out.find(name), std::string::npos) << shell << ' ' << name;
      }
    }
  }
}

TEST(Completion, of_bash_is_accepted_by_bash) {
  const std::string path =
      (std::filesystem::temp_directory_path() / "rali_completion_test.sh").string();
  std::ofstream(path) << completion_script("bash", all_commands())
                      << "COMP_WORDS=(rali map --over); COMP_CWORD=2; _rali\n"
                         "[ \"${COMPREPLY[0]}\" = --overwrite ] || exit 1\n"
                         "COMP_WORDS=(rali map --preset pa); COMP_CWORD=3; _rali\n"
                         "[ \"${COMPREPLY[*]}\" = paper ]\n";
  const int code = std::system(("bash " + path).c_str());
  std::filesystem::remove(path);
  EXPECT_EQ(code, 0);
}

/// Skipped without zsh: the other shells are tested everywhere.
TEST(Completion, of_zsh_is_accepted_by_zsh_and_completes_an_option) {
  if (std::system("command -v zsh > /dev/null") != 0) GTEST_SKIP() << "zsh is not installed";
  const io::TestFolder folder;
  const std::string script = folder.write("_rali", completion_script("zsh", all_commands()));
  // compinit finds the file by its first line.
  EXPECT_EQ(std::system(("zsh -f -n " + script).c_str()), 0);
  const std::string check =
      folder.write("check.zsh", "fpath=(" + folder.path() +
                                    " $fpath)\nautoload -U compinit\ncompinit -D -u\n"
                                    "[[ $_comps[rali] == _rali ]] || exit 1\n"
                                    "function _arguments { print -rl -- \"$@\" }\n"
                                    "words=(rali map --pre) CURRENT=3\n"
                                    "[[ \"$(_rali)\" == *'--preset['*':NAME:(robust paper)'* ]]\n");
  EXPECT_EQ(std::system(("zsh -f " + check).c_str()), 0);
}

TEST(Help, manual_page_and_reference_list_the_same_exit_codes) {
  const std::string help = program_help(all_commands()), manual = cli_manual(all_commands());
  const std::string page = man_page(all_commands());
  for (const ExitCode& code : exit_codes()) {
    const std::string number(code.number);
    EXPECT_NE(help.find(number + ' ' + std::string(code.brief)), std::string::npos) << help;
    EXPECT_NE(manual.find("| " + number + " | " + std::string(code.meaning) + " |"),
              std::string::npos)
        << number;
    EXPECT_NE(page.find(".B " + number + '\n' + std::string(code.meaning)), std::string::npos)
        << number;
  }
}

TEST(ManPage, has_every_command_and_option_and_no_unintended_troff_macros) {
  const std::string page = man_page(all_commands());
  std::istringstream lines(page);
  for (std::string line; std::getline(lines, line);) {
    ASSERT_FALSE(line.empty()) << "an empty line is a warning of man";
    if (line.front() != '.') continue;
    const std::string macro = line.substr(1, line.find(' ') - 1);
    EXPECT_TRUE(macro == "TH" || macro == "SH" || macro == "SS" || macro == "TP" || macro == "PP" ||
                macro == "RS" || macro == "RE" || macro == "EX" || macro == "EE" || macro == "B")
        << line;
  }
  for (const auto& command : all_commands()) {
    if (command->hidden()) continue;
    EXPECT_NE(page.find("\n.SS \"rali " + command->name() + "\"\n"), std::string::npos);
    for (const Option& option : command->options()) {
      std::string name = option.names.substr(option.names.find("--") + 2);
      for (std::size_t at = 0; (at = name.find('-', at)) != std::string::npos; at += 2) {
        name.insert(at, "\\");
      }
      EXPECT_NE(page.find(name), std::string::npos) << name;
    }
  }
}

TEST(Options, of_each_command_have_unique_names) {
  for (const auto& command : all_commands()) {
    CommonOptions common;
    const std::vector<Option> options = all_options(*command, common);
    for (std::size_t i = 0; i < options.size(); ++i) {
      for (std::size_t k = 0; k < i; ++k) EXPECT_NE(options[i].names, options[k].names);
    }
  }
}

TEST(Docs, of_the_commands_match_the_program) {
  std::ifstream file(std::string(RALI_SOURCE_DIR) + "/docs/reference/cli.md");
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  EXPECT_TRUE(text == cli_manual(all_commands()))
      << "docs/reference/cli.md is not that of the program; renew it with: make docs";
}

}  // namespace
}  // namespace rali::cli
