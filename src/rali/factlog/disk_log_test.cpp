#include "rali/factlog/disk_log.hpp"

#include <csignal>

#include <gtest/gtest.h>
#include <sys/resource.h>

#include "rali/base/crc32c.hpp"
#include "rali/factlog/folder_for_test.hpp"

namespace rali::factlog {
namespace {

const std::string kFirst = "facts-000000.log", kSecond = "facts-000001.log";

std::unique_ptr<DiskLog> opened(const TestFolder& folder, std::uint64_t segment_bytes = 1 << 20) {
  auto log = DiskLog::open(folder.path(), {.segment_bytes = segment_bytes});
  EXPECT_TRUE(log.has_value()) << log.error().message();
  return std::move(*log);
}

void append(DiskLog& log, std::uint32_t first, std::uint32_t end, std::size_t bytes = 50) {
  for (std::uint32_t seq = first; seq < end; ++seq) {
    ASSERT_EQ(log.append(key_of(seq), 3, body_of(seq, bytes)), Appended::kWritten);
  }
  ASSERT_TRUE(log.sync().has_value());
}

std::vector<std::string> ids_of(const FindingList& findings) {
  std::vector<std::string> ids;
  for (const Finding& finding : findings) ids.push_back(finding.id);
  return ids;
}

TEST(DiskLog, reopens_with_all_records_and_continues) {
  const TestFolder folder;
  append(*opened(folder, 300), 0, 10);
  {
    const auto log = opened(folder, 300);
    EXPECT_EQ(log->size(), 10U);
    EXPECT_TRUE(log->take_findings().empty());
    append(*log, 10, 20);
  }
  const auto log = opened(folder, 300);
  EXPECT_TRUE(log->take_findings().empty());
  for (std::uint32_t seq = 0; seq < 20; ++seq) EXPECT_EQ(log->read(key_of(seq)), body_of(seq, 50));
  EXPECT_GE(bytes_in(folder.path("facts-000005.log")).size(), 16U) << "three records per segment";
}

TEST(DiskLog, refuses_a_second_process_with_an_explanation) {
  const TestFolder folder;
  const auto log = opened(folder);
  const auto second = DiskLog::open(folder.path());
  ASSERT_FALSE(second.has_value());
  EXPECT_EQ(second.error().code, ErrorCode::kUsage);
  EXPECT_EQ(second.error().message(),
            folder.path() +
                ": is in use by another process. Stop that one, or give this one a folder of its "
                "own.");
}

std::size_t records_in(const TestFolder& folder, std::vector<std::string>& found) {
  const auto log = DiskLog::open_to_read(folder.path());
  EXPECT_TRUE(log.has_value());
  found = ids_of((*log)->take_findings());
  std::size_t records = 0;
  (*log)->for_each([&](const RecordKey& key, std::uint8_t, std::span<const std::byte> body) {
    EXPECT_EQ(Bytes(body.begin(), body.end()), body_of(key.seq, 50));
    return ++records > 0;
  });
  return records;
}

TEST(DiskLog, can_be_read_while_another_process_writes) {
  const TestFolder folder;
  const auto log = opened(folder, 300);
  append(*log, 0, 7);
  std::vector<std::string> found;
  EXPECT_EQ(records_in(folder, found), 7U);
  EXPECT_TRUE(found.empty());
  append(*log, 7, 9);
  EXPECT_EQ(records_in(folder, found), 9U);
}

TEST(DiskLog, a_reader_does_not_repair_a_torn_end_or_damage) {
  const TestFolder folder;
  append(*opened(folder), 0, 5);
  Bytes torn = bytes_in(folder.path(kFirst));
  torn.resize(torn.size() - 7);
  torn[kSegmentHeadBytes + kRecordHeadBytes] ^= std::byte{1};  // of the first body
  write_bytes(folder.path(kFirst), torn);
  std::vector<std::string> found;
  EXPECT_EQ(records_in(folder, found), 3U);
  EXPECT_EQ(found, (std::vector<std::string>{"log.damaged", "log.torn"}));
  EXPECT_EQ(bytes_in(folder.path(kFirst)), torn) << "not one byte is changed";
}

TEST(DiskLog, releases_its_lock_when_closed) {
  const TestFolder folder;
  opened(folder).reset();
  EXPECT_TRUE(DiskLog::open(folder.path()).has_value());
}

TEST(DiskLog, removes_a_torn_record_and_accepts_its_number_again) {
  const TestFolder folder;
  append(*opened(folder), 0, 3);
  const Bytes whole = bytes_in(folder.path(kFirst));
  const std::size_t last = whole.size() - (kRecordHeadBytes + 50);
  for (std::size_t size = last; size < whole.size(); ++size) {
    write_bytes(folder.path(kFirst),
                Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)));
    const auto log = opened(folder);
    ASSERT_EQ(log->size(), 2U) << size;
    const auto ids = ids_of(log->take_findings());
    EXPECT_EQ(ids,
              size == last ? std::vector<std::string>{} : std::vector<std::string>{"log.torn"});
    EXPECT_EQ(bytes_in(folder.path(kFirst)).size(), last) << size;
    append(*log, 2, 3);
    EXPECT_EQ(bytes_in(folder.path(kFirst)), whole) << size;
  }
}

TEST(DiskLog, reports_a_flipped_bit_as_a_gap_that_can_be_filled) {
  const TestFolder folder;
  append(*opened(folder), 0, 5);
  const Bytes good = bytes_in(folder.path(kFirst));
  for (std::size_t byte = kSegmentHeadBytes; byte < good.size(); byte += 7) {
    Bytes bytes = good;
    bytes[byte] ^= std::byte{0x10};
    write_bytes(folder.path(kFirst), bytes);
    const auto log = opened(folder);
    ASSERT_EQ(log->size(), 4U) << byte;
    const auto lost = static_cast<std::uint32_t>((byte - kSegmentHeadBytes) / 78);
    EXPECT_FALSE(log->contains(key_of(lost))) << byte;
    EXPECT_EQ(ids_of(log->take_findings()),
              std::vector<std::string>{lost == 4 ? "log.torn" : "log.damaged"});
    append(*log, lost, lost + 1);
    for (std::uint32_t seq = 0; seq < 5; ++seq) EXPECT_EQ(log->read(key_of(seq)), body_of(seq, 50));
  }
}

TEST(DiskLog, a_damaged_segment_header_loses_no_record) {
  const TestFolder folder;
  append(*opened(folder), 0, 3);
  Bytes bytes = bytes_in(folder.path(kFirst));
  bytes[3] ^= std::byte{1};
  write_bytes(folder.path(kFirst), bytes);
  const auto log = opened(folder);
  EXPECT_EQ(log->size(), 3U);
  EXPECT_EQ(ids_of(log->take_findings()), std::vector<std::string>{"log.damaged"});
  append(*log, 3, 4);
  EXPECT_EQ(log->read(key_of(3)), body_of(3, 50)) << "in a new segment";
}

TEST(DiskLog, bytes_changed_under_an_open_log_give_a_read_error) {
  const TestFolder folder;
  const auto log = opened(folder);
  append(*log, 0, 2);
  Bytes bytes = bytes_in(folder.path(kFirst));
  bytes[kSegmentHeadBytes + kRecordHeadBytes + 10] ^= std::byte{1};
  write_bytes(folder.path(kFirst), bytes);
  EXPECT_EQ(log->read(key_of(0)).error().code, ErrorCode::kInput);
  std::vector<std::uint32_t> read;
  log->for_each([&](const RecordKey& key, std::uint8_t, std::span<const std::byte>) {
    read.push_back(key.seq);
    return true;
  });
  EXPECT_EQ(read, std::vector<std::uint32_t>{1});
  EXPECT_EQ(ids_of(log->take_findings()), std::vector<std::string>{"log.damaged"});
}

TEST(DiskLog, reports_a_missing_segment) {
  const TestFolder folder;
  append(*opened(folder, 300), 0, 9);
  std::filesystem::remove(folder.path(kSecond));
  const auto log = opened(folder, 300);
  EXPECT_EQ(log->size(), 6U);
  EXPECT_EQ(ids_of(log->take_findings()), std::vector<std::string>{"log.missing"});
}

TEST(DiskLog, reports_conflicting_content_of_one_key_and_keeps_the_first) {
  const TestFolder folder;
  append(*opened(folder), 0, 1);
  Bytes bytes = bytes_in(folder.path(kFirst));
  const Bytes clone = encode_record(key_of(0), 3, body_of(9, 50), {0, bytes.size()});
  bytes.insert(bytes.end(), clone.begin(), clone.end());
  write_bytes(folder.path(kFirst), bytes);
  const auto log = opened(folder);
  EXPECT_EQ(log->read(key_of(0)), body_of(0, 50));
  EXPECT_EQ(ids_of(log->take_findings()), std::vector<std::string>{"log.conflict"});
}

TEST(DiskLog, refuses_segments_of_a_newer_version) {
  const TestFolder folder;
  Bytes head = encode_segment_head();
  head[8] = std::byte{2};
  const std::uint32_t sum = crc32c(std::span(head).first(12));
  for (std::size_t k = 0; k < 4; ++k) head[12 + k] = static_cast<std::byte>(sum >> (8 * k) & 0xFF);
  write_bytes(folder.path(kFirst), head);
  const auto log = DiskLog::open(folder.path());
  ASSERT_FALSE(log.has_value());
  EXPECT_EQ(log.error().code, ErrorCode::kInput);
}

TEST(DiskLog, skips_a_segment_with_an_incomplete_header) {
  const TestFolder folder;
  for (std::size_t size = 0; size < kSegmentHeadBytes; ++size) {
    const Bytes head = encode_segment_head();
    write_bytes(folder.path(kFirst),
                Bytes(head.begin(), head.begin() + static_cast<std::ptrdiff_t>(size)));
    append(*opened(folder), 0, 1);
    EXPECT_EQ(opened(folder)->read(key_of(0)), body_of(0, 50)) << size;
    std::filesystem::remove(folder.path(kSecond));
  }
}

/// Limits the size of files, as on a full disk.
class SmallDisk {
 public:
  explicit SmallDisk(std::uint64_t bytes) {
    before_ = std::signal(SIGXFSZ, SIG_IGN);
    ::getrlimit(RLIMIT_FSIZE, &limit_);
    rlimit small = limit_;
    small.rlim_cur = bytes;
    ::setrlimit(RLIMIT_FSIZE, &small);
  }

  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;

  ~SmallDisk() {
    ::setrlimit(RLIMIT_FSIZE, &limit_);
    static_cast<void>(std::signal(SIGXFSZ, before_));
  }

 private:
  rlimit limit_ = {};
  void (*before_)(int) = nullptr;
};

TEST(DiskLog, a_full_disk_is_reported_without_losing_or_tearing_records) {
  for (std::uint64_t room = 0; room < 200; room += 7) {
    const TestFolder folder;
    {
      const auto log = opened(folder);
      append(*log, 0, 2);
      const SmallDisk small(16 + 2 * 78 + room);
      std::uint32_t seq = 2;
      while (log->append(key_of(seq), 3, body_of(seq, 50)) == Appended::kWritten) ++seq;
      EXPECT_EQ(seq, 2 + room / 78);
      EXPECT_EQ(log->append(key_of(seq), 3, body_of(seq, 50)), Appended::kFull);
      EXPECT_TRUE(log->sync().has_value());
      EXPECT_EQ(log->size(), seq);
    }
    const auto log = opened(folder);
    EXPECT_TRUE(log->take_findings().empty()) << "nothing is torn";
    const auto size = static_cast<std::uint32_t>(log->size());
    append(*log, size, size + 1);
    EXPECT_EQ(log->read(key_of(size)), body_of(size, 50)) << "there is room again";
  }
}

TEST(DiskLog, without_room_for_a_new_segment_nothing_is_lost) {
  const TestFolder folder;
  const auto log = opened(folder, 100);
  append(*log, 0, 1);
  {
    const SmallDisk small(10);
    EXPECT_EQ(log->append(key_of(1), 3, body_of(1, 50)), Appended::kFull);
  }
  append(*log, 1, 2);
  EXPECT_EQ(log->read(key_of(0)), body_of(0, 50));
  EXPECT_EQ(log->read(key_of(1)), body_of(1, 50));
}

TEST(DiskLog, a_missing_folder_is_an_error) {
  const TestFolder folder;
  const auto log = DiskLog::open(folder.path("nowhere"));
  ASSERT_FALSE(log.has_value());
  EXPECT_EQ(log.error().code, ErrorCode::kMachine);
}

}  // namespace
}  // namespace rali::factlog
