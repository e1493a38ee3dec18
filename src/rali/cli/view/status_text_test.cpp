#include "rali/cli/view/status_text.hpp"

#include <gtest/gtest.h>

namespace rali::cli {
namespace {

constexpr const char* kState = R"({
  "schema": 1, "t_s": 10, "vehicle": "v1", "term": 4, "waits_for": "v1 waits for nothing.",
  "mission": {"round": 4, "state": "Round 4: v2 stands."},
  "anchor": {"vehicle": "v2", "lost": {"vehicle": "v2", "age_s": 14.2, "position_m": [31.2, 4, 0],
    "message": "No message from v2.", "command": "rali operator assume-lost v2"}},
  "vehicles": [{"name": "v1", "position_m": [12.34, -4.5, 0.1], "role": "tag", "mode": "explore",
    "ellipse": {"major_m": 0.21, "minor_m": 0.1, "angle_rad": 0}, "battery": 0.81, "age_s": 0.1,
    "degenerate": {"axis": [1, 0, 0]}}, {"name": "v2"}],
  "links": [{"from": "v1", "to": "v2", "connected": true, "loss": 0.2, "rate_Bps": 21500, "delay_s": 0.05},
            {"from": "v2", "to": "v1", "connected": false}],
  "ranges": [{"from": "v1", "to": "v2", "range_m": 18.4, "used": false, "reason": "no line of sight"}],
  "diagnostics": [{"level": "ok", "name": "imu", "message": "fine"},
                  {"level": "warn", "name": "uwb", "message": "No range.", "remedy": "Look at it."}]})";

constexpr const char* kText = R"(v1: round 4, term 4, anchor v2
Round 4: v2 stands.
v1 waits for nothing.

ANCHOR LOST: v2, last seen 14 s ago at 31.2, 4.0, 0.0.
No message from v2.
If it will not come back: rali operator assume-lost v2

vehicle  role  mode     position [m]     sigma   battery  age    LiDAR
v1       tag   explore  12.3, -4.5, 0.1  0.21 m  81 %     0.1 s  degenerate
v2       -     -        -                -       -        -      ok

link     loss  rate       delay
v1 > v2  20 %  21.5 kB/s  50 ms
v2 > v1  cut   -          -

range    distance  use
v1 - v2  18.40 m   no line of sight

warn   uwb: No range.
       Look at it.
)";

TEST(StatusText, shows_the_fleet_in_a_terminal) {
  const auto status = read_status(kState);
  ASSERT_TRUE(status);
  EXPECT_EQ(status->text, kText);
  EXPECT_TRUE(status->alarm) << "the anchor is lost";
}

TEST(StatusText, shows_a_nearly_empty_state) {
  const auto status = read_status(R"({"schema":1,"t_s":0,"vehicle":"v1"})");
  ASSERT_TRUE(status);
  EXPECT_EQ(status->text, "v1\n");
  EXPECT_FALSE(status->alarm);
}

TEST(StatusText, ignores_fields_of_wrong_type) {
  EXPECT_TRUE(
      read_status(R"({"schema":1,"vehicle":7,"mission":[],"anchor":"x","vehicles":[1,{"name":
    {},"position_m":["a",1,2],"battery":"full","degenerate":1}],"links":{},"ranges":[[]],
    "diagnostics":[null,{"level":[]}],"table":3})"));
  for (const char* text : {"", "[]", "<html>", "{}", R"({"schema":"1"})"}) {
    EXPECT_FALSE(read_status(text)) << text;
  }
}

TEST(StatusText, removes_terminal_escape_sequences) {
  const auto status = read_status("{\"schema\":1,\"vehicle\":\"\\u001b[2J\"}");
  ASSERT_TRUE(status);
  EXPECT_EQ(status->text.find('\x1b'), std::string::npos);
}

}  // namespace
}  // namespace rali::cli
