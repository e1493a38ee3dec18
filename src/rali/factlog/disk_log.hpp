#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "rali/factlog/fact_log.hpp"
#include "rali/factlog/file.hpp"

namespace rali::factlog {

struct DiskLogSettings {
  std::uint64_t segment_bytes = std::uint64_t{64} << 20;
};

/// The log in segments `facts-000000.log`, ... of one folder, with exclusive access.
class DiskLog final : public FactLog {
 public:
  /// Reads all segments. A torn end is cut; damage is a Finding, and its records are missing.
  /// @param folder must exist
  /// Errors: kUsage if another process has it; kInput for segments of a newer program; kMachine.
  [[nodiscard]] static Result<std::unique_ptr<DiskLog>> open(const std::string& folder,
                                                             const DiskLogSettings& settings = {});

  /// The same for a reader that changes nothing: no lock is taken, nothing is cut, synced or
  /// created, and nothing can be appended. A program may be writing meanwhile: its unfinished
  /// records count as torn. Errors: kInput for segments of a newer program; kMachine.
  [[nodiscard]] static Result<std::unique_ptr<FactLog>> open_to_read(const std::string& folder);

  [[nodiscard]] Status sync() override;

  [[nodiscard]] std::uint64_t free_bytes() const override { return folder_.free_bytes(); }

 private:
  struct Segment {
    File file;
    std::uint64_t end = 0;     ///< of the last whole record
    std::uint64_t synced = 0;  ///< bytes before this are on the disk
    bool closed = false;       ///< takes no more records
  };

  enum class Use { kKeep, kRead };

  DiskLog(File folder, const DiskLogSettings& settings, Use use)
      : folder_(std::move(folder)), settings_(settings), use_(use) {}

  [[nodiscard]] Result<std::optional<RecordPlace>> write(const RecordKey& key, std::uint8_t kind,
                                                         std::span<const std::byte> body) override;
  [[nodiscard]] Result<Bytes> body_of(const Entry& entry) const override;
  [[nodiscard]] Status read_segments();
  [[nodiscard]] Status read_segment(std::uint32_t number, bool last);
  [[nodiscard]] Status end_at(Segment& segment, std::uint64_t rest);
  [[nodiscard]] Finding damaged(const std::string& path, std::uint64_t bytes,
                                std::uint64_t offset) const;
  /// A segment with room for this many bytes, a new one if needed. Null: the disk is full.
  [[nodiscard]] Result<Segment*> segment_for(std::uint64_t bytes);
  [[nodiscard]] std::string path_of(std::uint32_t number) const;
  [[nodiscard]] Status sync_dirty();
  void forget_unsynced();

  File folder_;
  DiskLogSettings settings_;
  Use use_;
  std::map<std::uint32_t, Segment> segments_;
  bool names_dirty_ = false;  ///< a new segment's directory entry is not synced yet
};

}  // namespace rali::factlog
