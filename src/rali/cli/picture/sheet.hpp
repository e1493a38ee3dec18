#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <cairo.h>

#include "rali/base/result.hpp"

namespace rali::cli {

struct Colour {
  std::uint8_t r = 0, g = 0, b = 0;
};

inline constexpr double kPointsPerInch = 72.0;
inline constexpr double kPointsPerMm = kPointsPerInch / 25.4;
/// Of a PNG, and of the rasterised map points in all formats: what journals require of figures.
inline constexpr double kDotsPerInch = 300.0;
inline constexpr double kDotPt = kPointsPerInch / kDotsPerInch;

enum class PictureFormat { kPng, kPdf, kSvg };

/// By the extension of a file's name; nothing for other extensions.
[[nodiscard]] std::optional<PictureFormat> picture_format_of(std::string_view path);

/// A white sheet that cairo draws on. Lengths are points (1/72 inch) from the top left corner, y
/// down. The same drawing gives the same bytes: text is neither hinted nor rounded to pixels, and
/// no file contains a date.
class Sheet {
 public:
  Sheet(double width_pt, double height_pt, PictureFormat format);

  [[nodiscard]] cairo_t* cairo() const { return cairo_.get(); }

  void set_colour(Colour colour);
  void line(double x0, double y0, double x1, double y1, double width, Colour colour);

  /// One line of text; (x, y) is the left end of its baseline. Bytes that are not UTF-8 and control
  /// characters become '?'.
  void text(double x, double y, double size, std::string_view text, Colour colour,
            bool bold = false);

  [[nodiscard]] double text_width(double size, std::string_view text, bool bold = false);

  /// The file. Nothing can be drawn afterwards. Errors (kMachine): cairo has failed.
  [[nodiscard]] Result<std::vector<std::byte>> finish();

 private:
  struct Destroy {
    void operator()(cairo_t* cairo) const { cairo_destroy(cairo); }

    void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
  };

  void set_font(double size, bool bold);

  PictureFormat format_;
  std::unique_ptr<std::vector<std::byte>> bytes_;  ///< at a fixed address while cairo writes into
                                                   ///< it
  std::unique_ptr<cairo_surface_t, Destroy> surface_;
  std::unique_ptr<cairo_t, Destroy> cairo_;
};

/// Name of the fallback font if the font of all pictures is not installed, as one sentence for
/// users; empty if it is installed.
[[nodiscard]] std::string missing_font();

/// The text with a '?' for each byte that is not UTF-8 or a control character: such bytes make
/// cairo reject the whole sheet.
[[nodiscard]] std::string drawable(std::string_view text);

}  // namespace rali::cli
