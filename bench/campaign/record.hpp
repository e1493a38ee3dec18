#pragma once

#include <string>
#include <vector>

#include "judge.hpp"

namespace rali::campaign {

/// One line of the results: all data for the table, and enough to reproduce the run.
struct RunRecord {
  std::uint64_t seed = 0;
  std::string block;  ///< name of the block of seeds
  std::string build;  ///< version of the program, as named by the caller
  std::uint64_t ranges_hash = 0;
  std::string scene, plan, priors;
  std::vector<std::string> features;
  int vehicles = 1;
  double duration_s = 0.0;
  double cpu_simulated_s = 0.0, cpu_mapped_s = 0.0;
  RunScore score;
};

[[nodiscard]] std::string to_json(const RunRecord& record);

/// Errors: a line that is not such a record.
[[nodiscard]] Result<RunRecord> from_json(const std::string& line);

/// All lines of a file; a truncated last line is ignored. Errors: no such file.
[[nodiscard]] Result<std::vector<RunRecord>> read_records(const std::string& path);

/// The table of a campaign in Markdown: blocks, failures by cause, figures.
[[nodiscard]] std::string table_of(const std::vector<RunRecord>& records);

}  // namespace rali::campaign
