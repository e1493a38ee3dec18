#include "rali/cli/session.hpp"

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>

#include <fmt/format.h>
#include <unistd.h>

namespace rali::cli {
namespace {

// Signal handlers can access only globals; both are lock-free.
std::atomic<bool> g_stop{false};
std::atomic<int> g_signal{0};

extern "C" void on_signal(int number) {
  if (g_stop.exchange(true)) _exit(128 + number);
  g_signal.store(number);
}

bool write_all(std::FILE* file, std::string_view text) {
  return std::fwrite(text.data(), 1, text.size(), file) == text.size();
}

}  // namespace

struct Session::Log {
  std::FILE* file = nullptr;

  ~Log() {
    if (file != nullptr) std::fclose(file);
  }
};

Session::Session() : log_(std::make_unique<Log>()) {
  const char* const no_color = std::getenv("NO_COLOR");
  const char* const term = std::getenv("TERM");
  const bool dumb = term == nullptr || std::string_view(term) == "dumb";
  live_ = isatty(STDERR_FILENO) == 1 && !dumb && (no_color == nullptr || *no_color == '\0');
  coloured_ = live_;
}

Session::~Session() { live_line(""); }

Status Session::open_log() {
  if (options.log.empty()) return {};
  log_->file = std::fopen(options.log.c_str(), "w");
  if (log_->file == nullptr) {
    return fail(ErrorCode::kMachine, options.log, "the log cannot be written");
  }
  return {};
}

void Session::result(std::string_view text) {
  live_line("");
  if (results_ != nullptr) {
    *results_ += text;
    return;
  }
  if (write_all(stdout, text) && std::fflush(stdout) == 0) return;
  if (errno != EPIPE) stdout_whole_ = false;  // a reader that closed the pipe is no error
}

void Session::error(std::string_view sentence) { report("rali: error: ", "\033[1;31m", sentence); }

void Session::warning(std::string_view sentence) {
  if (!options.quiet) report("rali: warning: ", "\033[33m", sentence);
}

void Session::note(std::string_view sentence) {
  if (!options.quiet) report("", "", sentence);
}

void Session::detail(std::string_view sentence) {
  if (options.verbose > 0 && !options.quiet) report("", "", sentence);
}

void Session::report(std::string_view label, std::string_view colour, std::string_view sentence) {
  live_line("");
  const std::string text = printable(sentence);
  const bool paint = coloured_ && !colour.empty();
  write_all(stderr,
            fmt::format("{}{}{}{}\n", paint ? colour : "", label, paint ? "\033[0m" : "", text));
  if (log_->file != nullptr) {
    write_all(log_->file, fmt::format("{}{}\n", label, text));
    std::fflush(log_->file);
  }
}

void Session::live_line(std::string_view text) {
  if (!live_ || (text.empty() && !live_line_shown_)) return;
  write_all(stderr, fmt::format("\r\033[K{}", printable(text)));
  std::fflush(stderr);
  live_line_shown_ = !text.empty();
}

void watch_signals() {
  struct sigaction action = {};
  action.sa_handler = on_signal;
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  // A closed pipe must not end a run that still has files to finish.
  std::signal(SIGPIPE, SIG_IGN);
}

const std::atomic<bool>& stop_requested() { return g_stop; }

int stop_signal() { return g_signal.load(); }

std::string printable(std::string_view text) {
  std::string out(text);
  for (char& c : out) {
    const auto byte = static_cast<unsigned char>(c);
    if ((byte < 0x20 && c != '\n' && c != '\t') || byte == 0x7f) c = '?';
  }
  return out;
}

}  // namespace rali::cli
