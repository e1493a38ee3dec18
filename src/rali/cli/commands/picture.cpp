#include "rali/cli/commands/picture.hpp"

#include "rali/cli/commands/report.hpp"
#include "rali/cli/picture/map_picture.hpp"

namespace rali::cli {
namespace {

class PictureCommand final : public Command {
 public:
  [[nodiscard]] std::string name() const override { return "picture"; }

  [[nodiscard]] std::string summary() const override {
    return "draw the map of a run from above, with its trajectories, as a PNG";
  }

  [[nodiscard]] std::vector<std::string> examples() const override {
    return {"rali picture out",
            "rali picture alone together -o both.png --caption alone --caption joined"};
  }

  [[nodiscard]] std::string exit_codes() const override {
    return "0 done, 2 not readable or no points, 4 disk";
  }

  [[nodiscard]] Positional positional() override {
    return {"DIR",       "folders that rali map has written, drawn one below the other",
            &folders_,   1,
            kPanelsMost, {}};
  }

  [[nodiscard]] std::vector<Option> options() override {
    return {{"-o,--out", "FILE", "the picture (default DIR/map.png)", &file_, false, {}},
            {"--title", "TEXT", "printed above the map", &title_, false, {}},
            {"--caption", "TEXT", "of each folder in turn; repeatable", &captions_, false, {}}};
  }

  [[nodiscard]] Result<int> run(Session& session) override {
    warn_of_old_names(folders_, session);
    std::vector<MapPicture> panels;
    for (const std::string& folder : folders_) {
      Result<MapPicture> picture = picture_of_folder(folder);
      if (!picture) return tl::make_unexpected(picture.error());
      const std::size_t k = panels.size();
      if (k < captions_.size()) picture->title = captions_[k];
      panels.push_back(std::move(*picture));
    }
    if (panels.size() == 1 && !title_.empty()) panels.front().title = title_;
    const Result<io::RgbImage> image =
        panels.size() == 1 ? draw_map(panels.front()) : draw_maps(title_, panels);
    if (!image) return tl::make_unexpected(image.error());
    const std::string path = file_.empty() ? folders_.front() + "/map.png" : file_;
    if (Status status = io::write_png(path, *image); !status) {
      return tl::make_unexpected(status.error());
    }
    session.result(path + '\n');
    return kExitDone;
  }

 private:
  std::vector<std::string> folders_, captions_;
  std::string file_, title_;
};

}  // namespace

std::unique_ptr<Command> make_picture_command() { return std::make_unique<PictureCommand>(); }

}  // namespace rali::cli
