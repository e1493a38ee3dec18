#include "rali/factlog/role_slots.hpp"

#include <gtest/gtest.h>

#include "rali/factlog/folder_for_test.hpp"

namespace rali::factlog {
namespace {

using State = RoleSlots::State;

DiskSlots opened(const TestFolder& folder) {
  auto slots = DiskSlots::open(folder.path(), "role.slots");
  EXPECT_TRUE(slots.has_value()) << slots.error().message();
  return std::move(*slots);
}

/// A file that was saved this often, the last time with body_of(saves).
void save(const TestFolder& folder, std::uint32_t saves) {
  DiskSlots slots = opened(folder);
  for (std::uint32_t k = 1; k <= saves; ++k) {
    ASSERT_TRUE(slots.save(body_of(k, 30)).has_value());
  }
}

TEST(RoleSlots, a_new_file_is_empty_and_has_its_full_size) {
  const TestFolder folder;
  EXPECT_EQ(opened(folder).state(), State::kNew);
  EXPECT_EQ(bytes_in(folder.path("role.slots")).size(), 2 * kSlotBytes);
  EXPECT_EQ(opened(folder).state(), State::kNew);
}

TEST(RoleSlots, return_the_last_saved_content) {
  const TestFolder folder;
  for (std::uint32_t k = 1; k <= 5; ++k) {
    save(folder, 1);
    ASSERT_TRUE(opened(folder).save(body_of(k, k)).has_value());
    const DiskSlots slots = opened(folder);
    EXPECT_EQ(slots.state(), State::kRead);
    EXPECT_EQ(slots.content(), body_of(k, k));
    EXPECT_FALSE(slots.one_is_damaged());
  }
}

// An interrupted write leaves some new bytes first; the rest is of two saves before.
TEST(RoleSlots, a_write_interrupted_at_any_byte_keeps_the_previous_content) {
  const TestFolder folder;
  save(folder, 4);
  const Bytes before = bytes_in(folder.path("role.slots"));
  ASSERT_TRUE(opened(folder).save(body_of(5, 30)).has_value());
  const Bytes after = bytes_in(folder.path("role.slots"));
  for (std::size_t cut = 0; cut < kSlotHeadBytes + 30; ++cut) {
    Bytes bytes = before;
    std::copy_n(after.begin() + kSlotBytes, cut, bytes.begin() + kSlotBytes);
    write_bytes(folder.path("role.slots"), bytes);
    DiskSlots slots = opened(folder);
    ASSERT_EQ(slots.state(), State::kRead) << cut;
    if (bytes == after) continue;  // equal bytes: nothing is missing
    EXPECT_EQ(slots.content(), body_of(4, 30)) << cut;
    ASSERT_TRUE(slots.save(body_of(6, 30)).has_value());
    EXPECT_EQ(opened(folder).content(), body_of(6, 30)) << cut;
  }
}

TEST(RoleSlots, are_unreadable_only_if_both_slots_are_damaged) {
  const TestFolder folder;
  save(folder, 2);
  Bytes bytes = bytes_in(folder.path("role.slots"));
  bytes[kSlotHeadBytes] ^= std::byte{1};
  write_bytes(folder.path("role.slots"), bytes);
  {
    const DiskSlots one = opened(folder);
    EXPECT_EQ(one.state(), State::kRead);
    EXPECT_TRUE(one.one_is_damaged());
    EXPECT_EQ(one.content(), body_of(1, 30));
  }
  bytes[kSlotBytes + kSlotHeadBytes] ^= std::byte{1};
  write_bytes(folder.path("role.slots"), bytes);
  EXPECT_EQ(opened(folder).state(), State::kUnreadable);
}

TEST(RoleSlots, a_flipped_bit_never_returns_content_that_was_not_saved) {
  const TestFolder folder;
  save(folder, 3);
  const Bytes good = bytes_in(folder.path("role.slots"));
  for (const std::size_t slot : {std::size_t{0}, kSlotBytes}) {
    for (std::size_t bit = 0; bit < 8 * (kSlotHeadBytes + 30); bit += 5) {
      Bytes bytes = good;
      bytes[slot + bit / 8] ^= static_cast<std::byte>(1U << (bit % 8));
      write_bytes(folder.path("role.slots"), bytes);
      const DiskSlots slots = opened(folder);
      ASSERT_EQ(slots.state(), State::kRead);
      EXPECT_EQ(slots.content(), body_of(slot == 0 ? 3 : 2, 30)) << slot << ' ' << bit;
    }
  }
}

TEST(RoleSlots, an_interrupted_first_save_leaves_a_new_file) {
  const TestFolder folder;
  save(folder, 1);
  Bytes bytes = bytes_in(folder.path("role.slots"));
  bytes[kSlotBytes + 3] ^= std::byte{0xFF};
  write_bytes(folder.path("role.slots"), bytes);
  EXPECT_EQ(opened(folder).state(), State::kNew);
}

TEST(RoleSlots, content_above_the_slot_size_is_refused_and_the_last_kept) {
  const TestFolder folder;
  DiskSlots slots = opened(folder);
  ASSERT_TRUE(slots.save(body_of(1, kSlotContentMax)).has_value());
  EXPECT_EQ(slots.save(body_of(2, kSlotContentMax + 1)).error().code, ErrorCode::kInput);
  EXPECT_EQ(slots.content(), body_of(1, kSlotContentMax));
  EXPECT_EQ(opened(folder).content(), body_of(1, kSlotContentMax));
}

TEST(RoleSlots, in_memory_behave_as_on_disk) {
  MemorySlots slots;
  EXPECT_EQ(slots.reopened().state(), State::kNew);
  ASSERT_TRUE(slots.save(body_of(1, 30)).has_value());
  ASSERT_TRUE(slots.save(body_of(2, 30)).has_value());
  EXPECT_EQ(slots.reopened().content(), body_of(2, 30));
  slots.bytes()[0] ^= std::byte{1};
  slots.bytes()[kSlotBytes] ^= std::byte{1};
  EXPECT_EQ(slots.reopened().state(), State::kUnreadable);
}

}  // namespace
}  // namespace rali::factlog
