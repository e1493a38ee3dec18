#include "rali/cli/picture/sheet.hpp"

#include <cmath>

#include <cairo-ft.h>
#include <cairo-pdf.h>
#include <cairo-svg.h>
#include <fmt/format.h>

namespace rali::cli {
namespace {

constexpr const char* kFont = "DejaVu Sans";

cairo_status_t append(void* closure, const unsigned char* data, unsigned size) {
  auto& bytes = *static_cast<std::vector<std::byte>*>(closure);
  const auto* first = reinterpret_cast<const std::byte*>(data);
  bytes.insert(bytes.end(), first, first + size);
  return CAIRO_STATUS_SUCCESS;
}

cairo_surface_t* make_surface(double width_pt, double height_pt, PictureFormat format,
                              std::vector<std::byte>* bytes) {
  if (format == PictureFormat::kSvg) {
    return cairo_svg_surface_create_for_stream(append, bytes, width_pt, height_pt);
  }
  if (format == PictureFormat::kPdf) {
    cairo_surface_t* pdf = cairo_pdf_surface_create_for_stream(append, bytes, width_pt, height_pt);
    cairo_pdf_surface_set_metadata(pdf, CAIRO_PDF_METADATA_CREATE_DATE, "");
    return pdf;
  }
  return cairo_image_surface_create(CAIRO_FORMAT_RGB24,
                                    static_cast<int>(std::ceil(width_pt / kDotPt)),
                                    static_cast<int>(std::ceil(height_pt / kDotPt)));
}

/// Bytes of the UTF-8 character that `text` starts with; 0 if invalid.
std::size_t character_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned first = byte(0);
  if (first < 0x80) return first >= 0x20 && first != 0x7F ? 1 : 0;
  const std::size_t length = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  if (first < 0xC2 || first > 0xF4 || text.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0U) != 0x80U) return 0;
  }
  const unsigned second = byte(1);
  const bool too_long = (first == 0xE0 && second < 0xA0) || (first == 0xF0 && second < 0x90);
  const bool too_high = (first == 0xED && second >= 0xA0) || (first == 0xF4 && second >= 0x90);
  return too_long || too_high ? 0 : length;
}

}  // namespace

std::optional<PictureFormat> picture_format_of(std::string_view path) {
  if (path.ends_with(".png")) return PictureFormat::kPng;
  if (path.ends_with(".pdf")) return PictureFormat::kPdf;
  if (path.ends_with(".svg")) return PictureFormat::kSvg;
  return std::nullopt;
}

std::string drawable(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const std::size_t length = character_length(text);
    out += length > 0 ? text.substr(0, length) : "?";
    text.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return out;
}

Sheet::Sheet(double width_pt, double height_pt, PictureFormat format)
    : format_(format),
      bytes_(std::make_unique<std::vector<std::byte>>()),
      surface_(make_surface(width_pt, height_pt, format, bytes_.get())),
      cairo_(cairo_create(surface_.get())) {
  if (format == PictureFormat::kPng) cairo_scale(cairo(), 1.0 / kDotPt, 1.0 / kDotPt);
  set_colour({255, 255, 255});
  cairo_paint(cairo());
}

void Sheet::set_colour(Colour colour) {
  cairo_set_source_rgb(cairo(), colour.r / 255.0, colour.g / 255.0, colour.b / 255.0);
}

void Sheet::line(double x0, double y0, double x1, double y1, double width, Colour colour) {
  set_colour(colour);
  cairo_set_line_width(cairo(), width);
  cairo_move_to(cairo(), x0, y0);
  cairo_line_to(cairo(), x1, y1);
  cairo_stroke(cairo());
}

void Sheet::set_font(double size, bool bold) {
  cairo_select_font_face(cairo(), kFont, CAIRO_FONT_SLANT_NORMAL,
                         bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(cairo(), size);
  cairo_font_options_t* options = cairo_font_options_create();
  cairo_font_options_set_antialias(options, CAIRO_ANTIALIAS_GRAY);
  cairo_font_options_set_hint_style(options, CAIRO_HINT_STYLE_NONE);
  cairo_font_options_set_hint_metrics(options, CAIRO_HINT_METRICS_OFF);
  cairo_set_font_options(cairo(), options);
  cairo_font_options_destroy(options);
}

void Sheet::text(double x, double y, double size, std::string_view text, Colour colour, bool bold) {
  set_font(size, bold);
  set_colour(colour);
  cairo_move_to(cairo(), x, y);
  cairo_show_text(cairo(), drawable(text).c_str());
  cairo_new_path(cairo());
}

double Sheet::text_width(double size, std::string_view text, bool bold) {
  set_font(size, bold);
  cairo_text_extents_t extents;
  cairo_text_extents(cairo(), drawable(text).c_str(), &extents);
  return extents.x_advance;
}

Result<std::vector<std::byte>> Sheet::finish() {
  cairo_status_t status = cairo_status(cairo());
  if (format_ == PictureFormat::kPng && status == CAIRO_STATUS_SUCCESS) {
    status = cairo_surface_write_to_png_stream(surface_.get(), append, bytes_.get());
  }
  cairo_surface_finish(surface_.get());
  if (status == CAIRO_STATUS_SUCCESS) status = cairo_surface_status(surface_.get());
  if (status != CAIRO_STATUS_SUCCESS) {
    return fail(ErrorCode::kMachine, "picture",
                fmt::format("cairo cannot draw it: {}", cairo_status_to_string(status)));
  }
  return std::move(*bytes_);
}

std::string missing_font() {
  Sheet sheet(1.0, 1.0, PictureFormat::kPng);
  (void)sheet.text_width(8.0, "x");  // chooses the font
  cairo_scaled_font_t* font = cairo_get_scaled_font(sheet.cairo());
  std::string found;
  if (const FT_Face face = cairo_ft_scaled_font_lock_face(font); face != nullptr) {
    found = face->family_name != nullptr ? face->family_name : "a font without a name";
    cairo_ft_scaled_font_unlock_face(font);
  }
  if (found == kFont) return {};
  return fmt::format(
      "the font {} is not installed: texts of the picture are drawn in {}. Install {} (Debian: "
      "fonts-dejavu-core).",
      kFont, found.empty() ? "the plain letters of cairo" : found, kFont);
}

}  // namespace rali::cli
