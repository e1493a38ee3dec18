#include "rali/drive/output/traffic_file.hpp"

#include <algorithm>

#include "rali/io/files/atomic_file.hpp"
#include "rali/io/files/csv_writer.hpp"

namespace rali::drive {

double mb_per_min(std::uint64_t bytes, double duration_s) {
  return duration_s > 0.0 ? static_cast<double>(bytes) * 1e-6 / (duration_s / 60.0) : 0.0;
}

Status write_traffic_table(const std::string& folder, const std::vector<std::string>& names,
                           const std::vector<fleet::TrafficCount>& reported, double duration_s) {
  std::string text = "vehicle,kind,messages,bytes,mb_per_min\n";
  for (std::size_t v = 0; v < std::min(names.size(), reported.size()); ++v) {
    for (std::size_t k = 0; k < reported[v].of_kind.size(); ++k) {
      const fleet::TrafficCount::Row& count = reported[v].of_kind[k];
      if (count.messages == 0) continue;
      io::CsvRow row;
      row.text(names[v]).text(fleet::name_of(static_cast<fleet::Kind>(k)));
      row.integer(count.messages).integer(count.bytes);
      row.fixed(mb_per_min(count.bytes, duration_s), 4);
      text += row.line() + '\n';
    }
  }
  return io::write_file_atomic(folder + "/traffic.csv", text);
}

}  // namespace rali::drive
