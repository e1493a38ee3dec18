#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <string>

#include <gtest/gtest.h>

#include "rali/report/internal/test_run.hpp"
#include "rali/report/report.hpp"

namespace rali::report {

namespace assets {
std::string_view script();
}

namespace {

std::optional<std::string> browser() {
  for (const char* name : {"chromium", "chromium-browser", "google-chrome"}) {
    const std::string command = std::string("command -v ") + name + " >/dev/null 2>&1";
    if (std::system(command.c_str()) == 0) return name;
  }
  return std::nullopt;
}

/// A browser's result for a page: the document after its scripts ran, and the console errors.
struct Shown {
  std::string document, complaints;
};

Shown shown(const io::TestFolder& folder, const std::string& name) {
  // No shared memory and no profile of the user: works in containers too.
  const std::string command = fmt::format(
      "timeout 120 {} --headless --no-sandbox --disable-dev-shm-usage --use-gl=angle "
      "--use-angle=swiftshader --enable-unsafe-swiftshader --user-data-dir='{}' "
      "--virtual-time-budget=10000 --enable-logging=stderr --dump-dom 'file://{}' >'{}' 2>'{}'",
      *browser(), folder.path("profile"), folder.path(name), folder.path("dom"),
      folder.path("err"));
  EXPECT_EQ(std::system(command.c_str()), 0) << folder.read("err");
  return {folder.read("dom"), folder.read("err")};
}

bool has(const std::string& text, std::string_view part) {
  return text.find(part) != std::string::npos;
}

#define RALI_NEEDS_BROWSER()                                                               \
  if (!browser()) GTEST_SKIP() << "NO BROWSER: chromium is not there, no page was opened"; \
  if (assets::script().empty()) GTEST_SKIP() << "BUILT WITHOUT SCRIPTS (RALI_WEB)"

/// Puts the pointer over the middle of the first plot of speed. The title of the page becomes the
/// legend's text and the number of rings on the maps.
constexpr std::string_view kPointer = R"(<script>
  const plot = [...document.querySelectorAll('.u-title')].find((e) => e.textContent === 'speed').parentElement;
  const over = plot.querySelector('.u-over');
  const box = over.getBoundingClientRect();
  const at = {clientX: box.left + box.width / 2, clientY: box.top + 20, bubbles: true};
  over.dispatchEvent(new MouseEvent('mouseenter', at));
  over.dispatchEvent(new MouseEvent('mousemove', at));
  setTimeout(() => {
    const rings = document.querySelectorAll('.place').length;
    document.title = plot.querySelector('.u-legend').textContent + ', rings ' + rings;
  }, 100);
</script>)";

TEST(Browser, shows_the_numbers_the_plots_and_the_map_in_3_d_without_an_error) {
  RALI_NEEDS_BROWSER();
  const io::TestFolder folder;
  TestRun run;
  run.vehicles = test_names(2);
  run.fleet = run.truth = true;
  write_test_run(folder, run);
  ASSERT_TRUE(write_report(folder.path(), folder.path("report.html")));
  folder.write("report.html", folder.read("report.html") + std::string(kPointer));
  const Shown page = shown(folder, "report.html");
  EXPECT_TRUE(has(page.document, "data-scripts=\"done\"")) << "the scripts ran to their end";
  // At 9.9 s x increases by 1.2 m/s and y = 0.3 sin x by 0.26 m/s.
  EXPECT_TRUE(has(page.document, "time9.90speed1.23 m/s")) << "values under the pointer";
  EXPECT_TRUE(has(page.document, "rings 2</title>")) << "on the map from above and from the side";
  EXPECT_FALSE(has(page.complaints, "Uncaught")) << page.complaints;
  EXPECT_FALSE(has(page.complaints, "Content Security Policy")) << page.complaints;
  for (const char* text : {"0.13 m", "24.1 m",
                           "20\xE2\x80\xAF"
                           "000",
                           "all 2 vehicles in one frame", "no line of sight", "46 ms"}) {
    EXPECT_TRUE(has(page.document, text)) << text;
  }
  EXPECT_TRUE(has(page.document, "<canvas")) << "the 3-D view";
  EXPECT_TRUE(has(page.document, "data-figures=\"9\"")) << "map, side, 3-D, held, two vehicles, "
                                                           "residuals, roles, truth";
  EXPECT_TRUE(has(page.document, "data-state=\"20000 points drawn\""));
}

TEST(Browser, shows_hostile_names_as_plain_text) {
  RALI_NEEDS_BROWSER();
  const io::TestFolder folder;
  TestRun run;
  run.vehicles = {"<img src=x onerror=document.title='broken'>"};
  run.warning = "</script><script>document.title='broken'</script>";
  write_test_run(folder, run);
  ASSERT_TRUE(write_report(folder.path(), folder.path("report.html")));
  const Shown page = shown(folder, "report.html");
  EXPECT_TRUE(has(page.document, "data-scripts=\"done\""));
  EXPECT_FALSE(has(page.document, "<title>broken"));
  EXPECT_FALSE(has(page.complaints, "Uncaught")) << page.complaints;
}

TEST(Browser, opens_a_page_without_a_map) {
  RALI_NEEDS_BROWSER();
  const io::TestFolder folder;
  TestRun run;
  run.points = 0;
  write_test_run(folder, run);
  ASSERT_TRUE(write_report(folder.path(), folder.path("report.html")));
  const Shown page = shown(folder, "report.html");
  EXPECT_TRUE(has(page.document, "data-scripts=\"done\""));
  EXPECT_FALSE(has(page.complaints, "Uncaught")) << page.complaints;
}

}  // namespace
}  // namespace rali::report
