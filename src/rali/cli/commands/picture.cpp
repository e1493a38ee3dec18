#include "rali/cli/commands/picture.hpp"

#include <optional>
#include <span>

#include "rali/cli/commands/report.hpp"
#include "rali/cli/picture/map_picture.hpp"
#include "rali/io/files/atomic_file.hpp"

namespace rali::cli {
namespace {

class PictureCommand final : public Command {
 public:
  [[nodiscard]] std::string name() const override { return "picture"; }

  [[nodiscard]] std::string summary() const override {
    return "draw maps from above for a paper: PNG, PDF or SVG";
  }

  [[nodiscard]] std::vector<std::string> examples() const override {
    return {"rali picture out",
            "rali picture alone together -o both.pdf --caption alone --caption joined"};
  }

  [[nodiscard]] std::string exit_codes() const override {
    return "0 done, 2 not readable or no points, 4 disk";
  }

  [[nodiscard]] Positional positional() override {
    return {"DIR",      "folders that rali map has written, drawn as panels at one scale",
            &folders_,  1,
            kPanelsMax, {}};
  }

  [[nodiscard]] std::vector<Option> options() override {
    return {
        {"-o,--out", "FILE", ".png, .pdf or .svg (default DIR/map.png)", &file_, false, {}},
        {"--width", "MM", "88: one column of a paper, 181: two; 60 to 420", &width_mm_, false, {}},
        {"--title", "TEXT", "printed above the maps", &title_, false, {}},
        {"--caption", "TEXT", "of each folder in turn; repeatable", &captions_, false, {}}};
  }

  [[nodiscard]] Result<int> run(Session& session) override {
    const std::string path = file_.empty() ? folders_.front() + "/map.png" : file_;
    const std::optional<PictureFormat> format = picture_format_of(path);
    if (!format) {
      return fail(ErrorCode::kInput, path, "the name of a picture ends in .png, .pdf or .svg");
    }
    warn_of_old_names(folders_, session);
    std::vector<MapPicture> panels;
    for (const std::string& folder : folders_) {
      Result<MapPicture> panel = picture_of_folder(folder);
      if (!panel) return tl::make_unexpected(panel.error());
      const std::size_t k = panels.size();
      if (k < captions_.size()) panel->caption = captions_[k] + ": " + panel->caption;
      panels.push_back(std::move(*panel));
    }
    if (const std::string sentence = missing_font(); !sentence.empty()) session.warning(sentence);
    const Result<std::vector<std::byte>> bytes = draw_maps(panels, {title_, width_mm_, *format});
    if (!bytes) return tl::make_unexpected(bytes.error());
    const Status written = io::write_file_atomic(path, std::span<const std::byte>(*bytes));
    if (!written) return tl::make_unexpected(written.error());
    session.result(path + '\n');
    return kExitDone;
  }

 private:
  std::vector<std::string> folders_, captions_;
  std::string file_, title_;
  double width_mm_ = kTwoColumns_mm;
};

}  // namespace

std::unique_ptr<Command> make_picture_command() { return std::make_unique<PictureCommand>(); }

}  // namespace rali::cli
