#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <string_view>

#include "rali/base/result.hpp"

namespace rali::cli {

/// Options that every command has.
struct CommonOptions {
  bool json = false;
  bool quiet = false;
  int verbose = 0;
  std::string progress = "auto";  ///< auto, json, off
  std::string log;                ///< file with a copy of everything on stderr
};

/// Output channels of a command: results to stdout, all else to stderr and the log.
class Session {
 public:
  Session();
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  CommonOptions options;
  std::string command_line;  ///< as typed, for run.log
  std::string run_log;       ///< of the current run; needed by the report of an internal error
  /// Folder of the run that the command is writing; an internal error is recorded there.
  std::string written_run;

  /// Opens the log file. Errors: kMachine.
  [[nodiscard]] Status open_log();

  /// A result, to stdout as it is.
  void result(std::string_view text);

  /// Results go into `text` instead of stdout; nullptr: to stdout again.
  void results_into(std::string* text) { results_ = text; }

  void error(std::string_view sentence);    ///< rali: error: ...
  void warning(std::string_view sentence);  ///< rali: warning: ...; not with -q
  void note(std::string_view sentence);     ///< as it is; not with -q
  void detail(std::string_view sentence);   ///< only with -v

  /// A line of progress: to stderr even with -q; the caller checks the options.
  void progress_text(std::string_view line) { report("", "", line); }

  /// The last line of the terminal, overwritten each time; "" removes it.
  void live_line(std::string_view text);

  [[nodiscard]] bool live() const { return live_; }  ///< stderr is a terminal with cursor control

  /// False after a failed write to stdout (a full disk).
  [[nodiscard]] bool stdout_whole() const { return stdout_whole_; }

 private:
  void report(std::string_view label, std::string_view colour, std::string_view sentence);

  struct Log;
  std::unique_ptr<Log> log_;
  std::string* results_ = nullptr;
  bool live_ = false;
  bool coloured_ = false;
  bool live_line_shown_ = false;
  bool stdout_whole_ = true;
};

/// SIGINT and SIGTERM: the first sets `stop`, the second ends the process at once with 128 + n.
void watch_signals();
[[nodiscard]] const std::atomic<bool>& stop_requested();
/// The signal that asked to stop, 0 if none.
[[nodiscard]] int stop_signal();

/// Protects terminals from control bytes in files: these become '?', except line ends.
[[nodiscard]] std::string printable(std::string_view text);

}  // namespace rali::cli
