// Tables, inertial data, ranges, radio, rounds and trajectories of any content: no crash, no hang.
#include <cstdint>
#include <string>

#include "rali/base/assert.hpp"
#include "rali/drive/output/rounds_input.hpp"
#include "rali/io/files/csv_reader.hpp"
#include "rali/io/files/imu_csv.hpp"
#include "rali/io/files/range_csv.hpp"
#include "rali/io/files/tum.hpp"

namespace {

void read_table(const std::string& text) {
  auto csv = rali::io::CsvReader::from_text(text, "fuzz.csv");
  if (!csv) return;
  std::uint64_t line = 0;
  while (true) {
    const auto more = csv->next();
    if (!more || !*more) return;
    RALI_ASSERT(csv->line() > line);
    line = csv->line();
    for (std::size_t i = 0; i <= csv->header().size(); ++i) {
      RALI_ASSERT(csv->cell(static_cast<int>(i)).size() <= text.size());
    }
  }
}

void read_imu(const std::string& text) {
  auto imu = rali::io::ImuCsvReader::from_text(text, "imu.csv");
  if (!imu) return;
  rali::sensor::ImuSample sample;
  while (true) {
    const auto more = imu->next(sample);
    if (!more || !*more) break;
    RALI_ASSERT(sample.gyro_radps.allFinite() && sample.accel_mps2.allFinite());
  }
  RALI_ASSERT(imu->findings().size() <= 3);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  read_table(text);
  read_imu(text);
  const rali::io::RadioNames names = {{"v1", {rali::VehicleId{0}, 0}},
                                      {"v2", {rali::VehicleId{1}, 0}}};
  (void)rali::io::parse_ranges_csv(text, "ranges.csv", names);
  (void)rali::io::parse_radio_csv(text, "radio.csv", names);
  const auto rounds = rali::drive::parse_rounds_csv(text, "rounds.csv", names);
  if (rounds) RALI_ASSERT(rali::fleet::rounds_of_table(*rounds).has_value());
  const auto tum = rali::io::parse_tum(text, "a.tum");
  RALI_ASSERT(!tum || !tum->poses.empty());
  return 0;
}
