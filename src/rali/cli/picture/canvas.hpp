#pragma once

#include <string_view>

#include "rali/io/files/png_writer.hpp"

namespace rali::cli {

struct Colour {
  std::uint8_t r = 0, g = 0, b = 0;
};

/// A sheet to draw on, with soft edges. Pixels from the top left corner, x to the right, y down;
/// what lies outside is cut off.
class Canvas {
 public:
  Canvas(std::uint32_t width, std::uint32_t height, Colour background);

  /// Mixes a colour into one pixel; share 0 to 1.
  void blend(int x, int y, Colour colour, double share);

  void rectangle(int x, int y, int width, int height, Colour colour);

  /// A line with round ends. Coordinates that are no numbers draw nothing.
  void line(double x0, double y0, double x1, double y1, double width, Colour colour);

  void disc(double x, double y, double radius, Colour colour) {
    line(x, y, x, y, 2.0 * radius, colour);
  }

  /// One line of text; (x, y) is the left end of its base line. Returns where it ends. Characters
  /// beyond ASCII are drawn as a box.
  double text(double x, double y, double height, std::string_view text, Colour colour);

  [[nodiscard]] static double text_width(double height, std::string_view text);

  [[nodiscard]] const io::RgbImage& image() const { return image_; }

 private:
  io::RgbImage image_;
};

}  // namespace rali::cli
