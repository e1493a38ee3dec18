#include "rali/cli/help.hpp"

#include <sstream>

#include <fmt/format.h>

#include "rali/cli/parse.hpp"

namespace rali::cli {
namespace {

constexpr std::size_t kColumns = 80;
constexpr std::size_t kHelpColumn = 27;

/// Wraps `text` into lines that start at `column` (the first continues `line`).
std::string wrapped(std::string line, const std::string& text, std::size_t column) {
  std::string out;
  if (line.size() + 2 > column) {
    out = line + '\n';
    line.clear();
  }
  line.resize(column, ' ');
  bool empty = true;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    if (!empty && line.size() + 1 + word.size() > kColumns) {
      out += line + '\n';
      line = std::string(column, ' ');
      empty = true;
    }
    line += (empty ? "" : " ") + word;
    empty = false;
  }
  return out + line + '\n';
}

std::string default_text(const Option& option) {
  if (auto* const* text = std::get_if<std::string*>(&option.target)) {
    return (*text)->empty() ? "" : fmt::format(" [{}]", **text);
  }
  if (auto* const* number = std::get_if<double*>(&option.target))
    return fmt::format(" [{}]", **number);
  if (auto* const* whole = std::get_if<int*>(&option.target)) {
    return option.value.empty() ? "" : fmt::format(" [{}]", **whole);
  }
  return "";
}

std::string option_names(const Option& option) {
  std::string names = option.names;
  for (std::size_t at = names.find(','); at != std::string::npos; at = names.find(',', at + 2)) {
    names.insert(at + 1, " ");
  }
  return option.value.empty() ? names : names + ' ' + option.value;
}

std::string usage_line(Command& command) {
  const Positional positional = command.positional();
  std::string input = positional.name;
  if (positional.at_most > positional.at_least && !input.empty()) input += "...";
  if (positional.at_least == 0 && !input.empty()) input = '[' + input + ']';
  return fmt::format("rali {} {}{}[options]", command.name(), input, input.empty() ? "" : " ");
}

/// An exit code and its text stay on one line.
std::string exit_code_lines() {
  std::string text, line = "exit codes:";
  for (const ExitCode& code : exit_codes()) {
    const std::string entry = fmt::format("{} {}", code.number, code.brief);
    if (line.size() + entry.size() + 2 > kColumns) {
      text += line + '\n';
      line = std::string(11, ' ');
    }
    line += (line.ends_with(' ') || line.ends_with(':') ? " " : "  ") + entry;
  }
  return text + line + '\n';
}

std::string escaped_cell(std::string text) {
  for (std::size_t at = text.find('|'); at != std::string::npos; at = text.find('|', at + 2)) {
    text.insert(at, "\\");
  }
  return text;
}

}  // namespace

std::string program_help(const CommandList& commands) {
  std::string text =
      "rali: maps from LiDAR and inertial recordings of vehicles\n\n"
      "usage: rali COMMAND INPUT... [options]\n\n";
  for (const auto& command : commands) {
    if (!command->hidden()) text += wrapped("  " + command->name(), command->summary(), 16);
  }
  text +=
      "\n  rali map run1.bag                 one vehicle, topics found\n"
      "  rali map fleet.yaml -o out        vehicles and sensors named in a file\n\n"
      "`rali COMMAND -h` lists the options, `rali --version` the version.\n";
  return text + exit_code_lines();
}

std::string command_help(Command& command, bool all) {
  std::string text = fmt::format("rali {}: {}\n\nusage: {}\n", command.name(), command.summary(),
                                 usage_line(command));
  for (const std::string& example : command.examples()) text += "  " + example + '\n';
  text += '\n';
  const Positional positional = command.positional();
  if (!positional.name.empty())
    text += wrapped("  " + positional.name, positional.help, kHelpColumn);
  CommonOptions common;
  bool hidden = false;
  for (const Option& option : all_options(command, common)) {
    hidden = hidden || option.rare;
    if (option.rare && !all) continue;
    text += wrapped("  " + option_names(option), option.help + default_text(option), kHelpColumn);
  }
  if (hidden && !all) text += wrapped("  --help-all", "all options", kHelpColumn);
  return text + '\n' + wrapped("exit codes:", command.exit_codes(), 13);
}

std::string cli_manual(const CommandList& commands) {
  std::string text =
      "# Commands\n\nMade by `rali help-cli`; do not edit.\n\n"
      "Results go to stdout, progress and messages to stderr. Messages read\n"
      "`rali: error: FILE:WHERE: what is wrong. What to do.` Colour and the live line appear only\n"
      "on a terminal and without `NO_COLOR`; elsewhere there is one line per 10 %.\n\n"
      "| exit code | meaning |\n|---|---|\n";
  for (const ExitCode& code : exit_codes()) {
    text += fmt::format("| {} | {} |\n", code.number, code.meaning);
  }
  for (const auto& command : commands) {
    if (command->hidden()) continue;
    text += fmt::format("\n## rali {}\n\n{}.\n\n```\n{}\n", command->name(), command->summary(),
                        usage_line(*command));
    for (const std::string& example : command->examples()) text += example + '\n';
    text += "```\n\n| option | default | |\n|---|---|---|\n";
    CommonOptions common;
    for (const Option& option : all_options(*command, common)) {
      std::string fallback = default_text(option);
      if (!fallback.empty()) fallback = fallback.substr(2, fallback.size() - 3);
      text += fmt::format("| `{}` | {} | {} |\n", option_names(option), fallback,
                          escaped_cell(option.help));
    }
    text += "\nExit codes: " + command->exit_codes() + ".\n";
  }
  return text;
}

}  // namespace rali::cli
