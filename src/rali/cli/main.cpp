#include <string>
#include <vector>

#include "rali/cli/app.hpp"

int main(int argc, char** argv) {
  rali::cli::watch_signals();
  rali::cli::Session session;
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  session.command_line = "rali";
  for (const std::string& argument : arguments) session.command_line += ' ' + argument;
  return rali::cli::run_app(arguments, session);
}
