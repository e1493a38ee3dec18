#include "document.hpp"

#include "common/document.hpp"
#include "table.hpp"

namespace rali::accuracy {

std::string command_of(const std::vector<std::string>& words) {
  return bench::command_of("accuracy", words, {"--cache", "--into", "--dump"});
}

std::string short_table(const std::vector<Scores>& runs) {
  return table_of(runs, {"APE rmse m", "APE max m", "z rmse m", "end m", "RPE 10 m m", "NEES 6",
                         "in 95 %", "CPU ms", "p99 ms", "peak MB"});
}

}  // namespace rali::accuracy
