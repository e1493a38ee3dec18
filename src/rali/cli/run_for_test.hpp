#pragma once

#include <cstdio>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "rali/cli/app.hpp"
#include "rali/cli/session.hpp"

namespace rali::cli {

/// Results of a command.
struct Outcome {
  int code = -1;
  std::string out, err;
};

/// Runs `rali` with these words in this process and catches what it prints.
inline Outcome run_rali(const std::vector<std::string>& words) {
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  Outcome run;
  {
    Session session;  // its end flushes log and progress
    run.code = run_app(words, session);
  }
  std::fflush(stdout);
  run.out = testing::internal::GetCapturedStdout();
  run.err = testing::internal::GetCapturedStderr();
  return run;
}

}  // namespace rali::cli
