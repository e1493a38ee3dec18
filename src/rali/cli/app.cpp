#include "rali/cli/app.hpp"

#include <filesystem>
#include <new>

#include <fmt/format.h>

#include "rali/cli/commands/commands.hpp"
#include "rali/cli/help.hpp"
#include "rali/cli/parse.hpp"
#include "rali/config/suggest.hpp"
#include "rali/drive/run_log.hpp"
#include "rali/drive/version.hpp"

namespace rali::cli {
namespace {

constexpr int kSignalBase = 128;
constexpr int kSigint = 2;

int report(const Error& error, Session& session) {
  session.error(error.message());
  return exit_code_of(error, stop_signal());
}

/// An internal error after the run itself (evaluation, report) must not leave the status
/// "complete".
void mark_run(const std::string& what, const Session& session) {
  if (!session.written_run.empty()) {
    drive::mark_failed(session.written_run, "internal fault: " + what);
  }
}

/// The report asks for run.log only if there is one.
void report_fault(const std::string& what, Session& session) {
  mark_run(what, session);
  std::error_code error;
  const bool log = !session.run_log.empty() && std::filesystem::exists(session.run_log, error);
  session.error(fmt::format("internal fault: {}. Please report it with {}.", what,
                            log ? session.run_log : "this sentence and the command line"));
}

int unknown_command(const std::string& name, const CommandList& commands, Session& session) {
  std::vector<std::string> names;
  for (const auto& command : commands) {
    if (!command->hidden()) names.push_back(command->name());
  }
  const Error error{ErrorCode::kUsage, fmt::format("unknown command '{}'", name.substr(0, 80)), "",
                    config::suggestion(name, names)};
  return report(error, session);
}

int run_command(Command& command, const std::vector<std::string>& words, Session& session) {
  const Result<Parsed> parsed = parse_words(command, session.options, words);
  if (!parsed) return report(parsed.error(), session);
  if (*parsed != Parsed::kRun) {
    session.result(command_help(command, *parsed == Parsed::kHelpAll));
    return kExitDone;
  }
  if (Status status = session.open_log(); !status) return report(status.error(), session);
  const Result<int> code = command.run(session);
  if (!code) return report(code.error(), session);
  if (!session.stdout_whole()) {
    session.error("stdout could not be written to its end.");
    return kExitMachine;
  }
  return *code;
}

int dispatch(const std::vector<std::string>& arguments, Session& session) {
  CommandList commands = all_commands();
  if (arguments.empty()) {
    session.note(program_help(commands));
    return kExitNotStarted;
  }
  const std::string& first = arguments.front();
  if (first == "-h" || first == "--help" || first == "help") {
    session.result(program_help(commands));
    return kExitDone;
  }
  if (first == "--version" || first == "version") {
    session.result(fmt::format("rali {}\n", drive::version()));
    return kExitDone;
  }
  for (const auto& command : commands) {
    if (command->name() != first) continue;
    return run_command(*command, {arguments.begin() + 1, arguments.end()}, session);
  }
  return unknown_command(first, commands, session);
}

}  // namespace

int exit_code_of(const Error& error, int signal_number) {
  switch (error.code) {
    case ErrorCode::kUsage:
    case ErrorCode::kInput:
    case ErrorCode::kNoAnswer:
      return kExitNotStarted;
    case ErrorCode::kMachine:
      return kExitMachine;
    case ErrorCode::kInterrupted:
      return kSignalBase + (signal_number != 0 ? signal_number : kSigint);
  }
  return kExitInternal;
}

int run_guarded(const std::function<int()>& body, Session& session) {
  try {
    return body();
  } catch (const std::bad_alloc& e) {
    mark_run(e.what(), session);
    session.error("out of memory. Use a smaller part of the data (--duration) or a larger voxel.");
    return kExitMachine;
  } catch (const std::exception& e) {  // InternalError carries its file and line
    report_fault(e.what(), session);
  } catch (...) {
    report_fault("of unknown kind", session);
  }
  return kExitInternal;
}

int run_app(const std::vector<std::string>& arguments, Session& session) {
  return run_guarded([&] { return dispatch(arguments, session); }, session);
}

}  // namespace rali::cli
