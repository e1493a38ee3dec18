#include "rali/cli/man_page.hpp"

#include <fmt/format.h>

#include "rali/cli/parse.hpp"
#include "rali/drive/version.hpp"

namespace rali::cli {
namespace {

/// Text escaped for a line of troff: backslashes, minus signs and a leading dot or quote are
/// special.
std::string troff(const std::string& text) {
  std::string out;
  if (!text.empty() && (text.front() == '.' || text.front() == '\'')) out = "\\&";
  for (const char c : text) {
    if (c == '\\') {
      out += "\\e";
    } else if (c == '-') {
      out += "\\-";
    } else {
      out += c;
    }
  }
  return out;
}

std::string option_heading(const Option& option) {
  std::string names = option.names;
  if (const std::size_t comma = names.find(','); comma != std::string::npos) {
    names.insert(comma + 1, " ");
  }
  std::string heading = fmt::format("\\fB{}\\fR", troff(names));
  if (!option.value.empty()) heading += fmt::format(" \\fI{}\\fR", troff(option.value));
  return heading;
}

std::string command_section(Command& command) {
  const Positional positional = command.positional();
  std::string text =
      fmt::format(".SS \"rali {}\"\n{}.\n.PP\n", command.name(), troff(command.summary()));
  for (const std::string& example : command.examples()) {
    text += fmt::format(".RS\n.EX\n{}\n.EE\n.RE\n", troff(example));
  }
  if (!positional.name.empty()) {
    text += fmt::format(".TP\n\\fI{}\\fR\n{}\n", troff(positional.name), troff(positional.help));
  }
  CommonOptions common;
  for (const Option& option : all_options(command, common)) {
    text += fmt::format(".TP\n{}\n{}\n", option_heading(option), troff(option.help));
  }
  return text + fmt::format(".PP\nExit codes: {}.\n", troff(command.exit_codes()));
}

}  // namespace

std::string man_page(const CommandList& commands) {
  std::string text = fmt::format(
      ".TH RALI 1 \"\" \"rali {}\" \"User Commands\"\n"
      ".SH NAME\nrali \\- maps from LiDAR, inertial and range recordings of vehicles\n"
      ".SH SYNOPSIS\n.B rali\n\\fICOMMAND INPUT\\fR... [\\fIoptions\\fR]\n"
      ".SH DESCRIPTION\n"
      "Maps places where LiDAR is degenerate (tunnels, corridors, mines) with one or several "
      "ground\n"
      "vehicles. Ranges between vehicles are used in the directions in which LiDAR is degenerate.\n"
      "Inputs are ROS 1 bags, rosbag2, MCAP and folders of scans.\n"
      ".SH COMMANDS\n",
      drive::version());
  for (const auto& command : commands) {
    if (!command->hidden()) text += command_section(*command);
  }
  text += ".SH EXIT STATUS\n";
  for (const ExitCode& code : exit_codes()) {
    text += fmt::format(".TP\n.B {}\n{}\n", code.number, troff(std::string(code.meaning)));
  }
  return text + ".SH ENVIRONMENT\n.TP\n.B NO_COLOR\nno colour and no live line on a terminal\n";
}

}  // namespace rali::cli
