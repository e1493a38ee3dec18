#pragma once

#include <cstddef>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/drive/input/input_report.hpp"
#include "rali/drive/input/topic_choice.hpp"
#include "rali/io/message_source.hpp"
#include "rali/wire/message_kind.hpp"

namespace rali::drive {

/// One message of a recording, with the kind and type of its topic. `data` is valid until the next
/// call.
struct RecordedMessage {
  wire::MessageKind kind = wire::MessageKind::kOther;
  std::string_view topic;
  std::string_view type;
  wire::Encoding encoding = wire::Encoding::kOther;
  Time t_record;
  std::span<const std::byte> data;
  std::uint64_t offset = 0;
  std::size_t file = 0;  ///< index in the list of files
};

/// Recordings read one after the other as one stream of the messages that RaLI can use.
class RecordingChain {
 public:
  /// Opens the first file. Errors: kInput.
  [[nodiscard]] static Result<RecordingChain> open(std::vector<std::string> paths,
                                                   const InputOptions& options);

  /// True: `out` is set. False: the end of the last file. An Error only when opening the first
  /// file; later damage ends its file and goes to `gaps` and `findings`.
  [[nodiscard]] bool next(RecordedMessage& out, InputGaps& gaps, FindingList& findings);

  /// Topics of the file being read, with the counts so far.
  [[nodiscard]] std::vector<TopicCount> topics() const;

  [[nodiscard]] const std::vector<std::string>& paths() const { return paths_; }

  /// Index of the file being read.
  [[nodiscard]] std::size_t file() const { return file_; }

  /// Whether the computer's clock was set back in this file; `file` must not be after the one being
  /// read.
  [[nodiscard]] bool clock_was_set(std::size_t file) const { return clock_set_[file]; }

  [[nodiscard]] double progress() const;

 private:
  RecordingChain(std::vector<std::string> paths, const InputOptions& options);

  void sort_files();
  [[nodiscard]] Status open_file(std::size_t index);
  void close_file(InputGaps& gaps, FindingList& findings);

  std::vector<std::string> paths_;
  std::string lidar_topic_, imu_topic_, vehicle_;
  std::shared_ptr<const RangeOptions> ranges_;
  double max_s_ = 0.0;  ///< of data requested; 0: all
  std::size_t file_ = 0;
  std::unique_ptr<io::MessageSource> source_;
  std::vector<std::uint64_t> seen_;
  std::vector<bool> clock_set_;  ///< of each file
  FindingList found_;            ///< before the first message
};

}  // namespace rali::drive
