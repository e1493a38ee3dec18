#include "rali/drive/ranges/serial_log.hpp"

#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "rali/base/counted.hpp"
#include "rali/drive/ranges/linktrack_samples.hpp"
#include "rali/drive/ranges/radio_stamps.hpp"
#include "rali/io/files/csv_reader.hpp"
#include "rali/io/files/text.hpp"
#include "rali/wire/linktrack_serial.hpp"

namespace rali::drive {
namespace {

/// Between frames nothing is lost except at the start and the end of a recording.
constexpr std::uint64_t kSkippedMin = 4096;

int digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

/// False if the text is not whole bytes.
bool parse_hex(std::string_view text, std::vector<std::byte>& out) {
  out.clear();
  int high = -1;
  for (const char c : text) {
    if (c == ' ' && high < 0) continue;
    const int value = digit(c);
    if (value < 0) return false;
    if (high < 0) {
      high = value;
      continue;
    }
    out.push_back(static_cast<std::byte>(16 * high + value));
    high = -1;
  }
  return high < 0;
}

/// Converts the frames of one log to ranges with their times.
class Reading {
 public:
  Reading(const SerialLog& log, const RangeOptions& options)
      : log_(log), options_(options), stamps_(options.arrival) {}

  void take(std::span<const std::byte> bytes, Time arrival) {
    stream_.push(bytes);
    drain(arrival, false);
    last_ = arrival;
  }

  SerialRanges finish() {
    drain(last_, true);
    const wire::LinktrackStreamTally& tally = stream_.tally();
    if (tally.bad_checksums > 0 || tally.bytes_skipped > kSkippedMin) {
      Finding finding;
      finding.id = "ranges.serial_log";
      finding.text =
          fmt::format("{}: {} between {}, {} with a wrong checksum", log_.path,
                      counted(tally.bytes_skipped, "byte"), counted(tally.frames, "frame"),
                      counted(tally.bad_checksums, "frame"));
      finding.effect = "they are passed over";
      finding.value = static_cast<double>(tally.bytes_skipped);
      out_.findings.push_back(std::move(finding));
    }
    return std::move(out_);
  }

  [[nodiscard]] std::uint64_t frames() const { return stream_.tally().frames; }

 private:
  void drain(Time arrival, bool ended) {
    while (const auto frame = stream_.next(ended)) {
      const bool by_arrival = options_.stamp == RangeStamp::kRecord;
      const Time by_radio = stamps_.host_time(*frame, arrival);
      append_linktrack(*frame, by_arrival ? arrival : by_radio, log_.ids, log_.vehicle,
                       out_.samples);
      out_.zeros += frame->zeros;
    }
  }

  const SerialLog& log_;
  const RangeOptions& options_;
  RadioStamps stamps_;
  wire::LinktrackStream stream_;
  Time last_;
  SerialRanges out_;
};

}  // namespace

Result<SerialRanges> read_serial_log(const SerialLog& log, const RangeOptions& options) {
  auto csv = io::CsvReader::open(log.path);
  if (!csv) {
    Error error = csv.error();
    if (error.code == ErrorCode::kInput) error.remedy = kSerialLogFormat;
    return tl::make_unexpected(std::move(error));
  }
  const int stamp = csv->column("stamp_s"), hex = csv->column("hex");
  if (stamp < 0 || hex < 0) {
    return fail(ErrorCode::kInput, log.path, "is no log of a serial port with arrival stamps",
                kSerialLogFormat);
  }
  Reading reading(log, options);
  std::vector<std::byte> bytes;
  for (;;) {
    const Result<bool> more = csv->next();
    if (!more) return tl::make_unexpected(more.error());
    if (!*more) break;
    const auto t = io::parse_stamp(csv->cell(stamp));
    if (!t || !parse_hex(csv->cell(hex), bytes)) {
      return fail(ErrorCode::kInput, csv->where(),
                  t ? "hex is no list of bytes" : "stamp_s is no time in seconds",
                  kSerialLogFormat);
    }
    reading.take(bytes, *t);
  }
  SerialRanges ranges = reading.finish();
  if (reading.frames() == 0) {
    return fail(ErrorCode::kInput, log.path, "holds no frame of a LinkTrack radio",
                "Nodeframe2, 3, 5 and Tagframe0 are read; choose one of them in NAssistant.");
  }
  return ranges;
}

}  // namespace rali::drive
