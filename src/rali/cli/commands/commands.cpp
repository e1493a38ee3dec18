#include "rali/cli/commands/commands.hpp"

#include "rali/cli/commands/convert.hpp"
#include "rali/cli/commands/demo.hpp"
#include "rali/cli/commands/doctor.hpp"
#include "rali/cli/commands/evaluate.hpp"
#include "rali/cli/commands/info.hpp"
#include "rali/cli/commands/live.hpp"
#include "rali/cli/commands/picture.hpp"
#include "rali/cli/commands/play.hpp"
#include "rali/cli/commands/report.hpp"
#include "rali/cli/commands/run.hpp"
#include "rali/cli/commands/simulate.hpp"

namespace rali::cli {

CommandList all_commands() {
  CommandList commands;
  commands.push_back(make_map_command());
  commands.push_back(make_run_command());
  commands.push_back(make_doctor_command());
  commands.push_back(make_info_command());
  commands.push_back(make_evaluate_command());
  commands.push_back(make_report_command());
  commands.push_back(make_picture_command());
  commands.push_back(make_view_command());
  commands.push_back(make_status_command());
  commands.push_back(make_operator_command());
  commands.push_back(make_convert_command());
  commands.push_back(make_simulate_command());
  commands.push_back(make_play_command());
  commands.push_back(make_demo_command());
  commands.push_back(make_completion_command());
  commands.push_back(make_help_settings_command());
  commands.push_back(make_help_cli_command());
  commands.push_back(make_help_man_command());
  return commands;
}

}  // namespace rali::cli
