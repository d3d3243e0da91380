#include "pipeline/stage/caption.hpp"

#include <ft2build.h>
#include FT_FREETYPE_H
#include FT_OUTLINE_H

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include <glm/common.hpp>

#include "base/files.hpp"
#include "pipeline/stage/text_breaking.hpp"

namespace kasumi {
namespace {

// Debian's paths; the second group supplies glyphs that the first lacks (Japanese).
constexpr std::array kFonts{
    "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf",  // fonts-dejavu-core
    "/usr/share/fonts/truetype/liberation/LiberationSans-Regular.ttf",
    "/usr/share/fonts/truetype/freefont/FreeSans.ttf",
    "/usr/share/fonts/truetype/vlgothic/VL-Gothic-Regular.ttf",  // fonts-vlgothic
    "/usr/share/fonts/opentype/ipafont-gothic/ipag.ttf",
    "/usr/share/fonts/opentype/noto/NotoSansCJK-Regular.ttc",
    "/usr/share/fonts-droid-fallback/truetype/DroidSansFallbackFull.ttf",
};
constexpr std::size_t kMostCharacters = 4000;
constexpr double kMinHeight = 6.0, kMostHeight = 512.0;
constexpr int kMostWidth = 16384;
constexpr std::size_t kMostFontBytes = 64 << 20;

// A font may claim glyphs of any size, and each pixel of one takes memory. The widest of usual fonts, a whole sentence
// in one character (U+FDFD), has a dozen.
constexpr double kLargestGlyph_em = 16.0;

constexpr glm::dvec3 kTextColour{247, 246, 241};
constexpr glm::dvec3 kBackground{17, 19, 23};
constexpr double kBackgroundOpacity = 0.72;

// FreeType counts in 64ths of a pixel.
double from_26_6(FT_Pos value) {
  return static_cast<double>(value) / 64.0;
}

struct CloseLibrary {
  void operator()(FT_Library library) const { FT_Done_FreeType(library); }
};
struct CloseFace {
  void operator()(FT_Face face) const { FT_Done_Face(face); }
};
using Library = std::unique_ptr<FT_LibraryRec_, CloseLibrary>;
using Face = std::unique_ptr<FT_FaceRec_, CloseFace>;

struct Glyph {
  FT_Face face = nullptr;
  FT_UInt index = 0;
};

// Fonts in order of preference: a character comes from the first that has it.
class Fonts {
 public:
  static Result<Fonts> open(const CaptionStyle& style) {
    FT_Library library = nullptr;
    if (FT_Init_FreeType(&library) != 0) return fail(FaultKind::unsupported, "FreeType cannot be initialised");
    Fonts fonts{Library(library)};
    if (style.font_file) {
      auto file = read_file(*style.font_file, {.most_bytes = kMostFontBytes});
      if (!file) return fail(file.error());
      if (const FT_Error error = fonts.add(std::move(*file), style.height_px); error != 0)
        return fail(FaultKind::bad_input, "{}: expected a font that can be scaled: FreeType error {}",
                    style.font_file->string(), error);
    }
    for (const char* file : kFonts) fonts.add(file, style.height_px);
    if (fonts.faces_.empty())
      return fail(FaultKind::unsupported, "no font for text on the picture (on Debian: apt install fonts-dejavu-core)");
    return fonts;
  }

  Glyph glyph(char32_t character) const {
    for (const Face& face : faces_)
      if (const FT_UInt index = FT_Get_Char_Index(face.get(), character); index != 0) return {face.get(), index};
    return {faces_.front().get(), 0};
  }

  // Calls put(glyph, extent) for each glyph, from pen position to pen position.
  template <class Put>
  void walk(std::u32string_view line, Put put) const {
    double pen = 0.0;
    Glyph before;
    for (const char32_t character : line) {
      const Glyph now = glyph(character);
      FT_Vector kerning{};
      if (before.face == now.face && FT_HAS_KERNING(now.face))
        FT_Get_Kerning(now.face, before.index, now.index, FT_KERNING_UNFITTED, &kerning);
      const double from = pen + from_26_6(kerning.x);
      // 16.16 fixed point, not rounded to whole pixels
      FT_Fixed advance = 0;
      if (FT_Load_Glyph(now.face, now.index, FT_LOAD_NO_HINTING | FT_LOAD_NO_BITMAP) == 0)
        advance = now.face->glyph->linearHoriAdvance;
      pen = from + static_cast<double>(advance) / 65536.0;
      put(now, GlyphExtent{from, pen});
      before = now;
    }
  }

  double em_px() const { return em_px_; }
  double ascender() const { return from_26_6(faces_.front()->size->metrics.ascender); }
  double descender() const { return from_26_6(faces_.front()->size->metrics.descender); }

 private:
  explicit Fonts(Library library) : library_(std::move(library)) {}

  FT_Error add(const char* file, double height_px) {
    FT_Face opened = nullptr;
    if (const FT_Error error = FT_New_Face(library_.get(), file, 0, &opened); error != 0) return error;
    return add(opened, height_px);
  }

  FT_Error add(std::vector<std::uint8_t> file, double height_px) {
    own_ = std::move(file);
    FT_Face opened = nullptr;
    if (const FT_Error error =
            FT_New_Memory_Face(library_.get(), own_.data(), static_cast<FT_Long>(own_.size()), 0, &opened);
        error != 0)
      return error;
    return add(opened, height_px);
  }

  FT_Error add(FT_Face opened, double height_px) {
    Face face(opened);
    if (!FT_IS_SCALABLE(opened)) return FT_Err_Unknown_File_Format;
    // The first font's ascenders and descenders fit a line; the others use its size.
    if (faces_.empty()) {
      const double tall = static_cast<double>(opened->ascender - opened->descender) / opened->units_per_EM;
      em_px_ = height_px / std::clamp(tall, 1.2, 2.0);
    }
    const auto size = static_cast<FT_F26Dot6>(std::lround(em_px_ * 64.0));
    if (const FT_Error error = FT_Set_Char_Size(opened, 0, size, 72, 72); error != 0) return error;
    faces_.push_back(std::move(face));
    return 0;
  }

  Library library_;
  std::vector<std::uint8_t> own_;  // the given font's file: FreeType would map it, and die with the disk
  std::vector<Face> faces_;        // closed before either
  double em_px_ = 0.0;
};

bool is_larger(const FT_Outline& outline, double largest_px) {
  FT_BBox box{};
  FT_Outline_Get_CBox(&outline, &box);
  return from_26_6(box.xMax - box.xMin) > largest_px || from_26_6(box.yMax - box.yMin) > largest_px;
}

// Adds a glyph's coverage to each pixel; one that is larger than that is left out.
void add_glyph(Image<float>& coverage, const Glyph& glyph, double x, double baseline, double largest_px) {
  if (FT_Load_Glyph(glyph.face, glyph.index, FT_LOAD_NO_HINTING | FT_LOAD_NO_BITMAP) != 0) return;
  const FT_GlyphSlot slot = glyph.face->glyph;
  if (slot->format != FT_GLYPH_FORMAT_OUTLINE || is_larger(slot->outline, largest_px)) return;
  const double left = std::floor(x);
  FT_Outline_Translate(&slot->outline, static_cast<FT_Pos>(std::lround((x - left) * 64.0)), 0);
  if (FT_Render_Glyph(slot, FT_RENDER_MODE_NORMAL) != 0) return;
  const FT_Bitmap& bitmap = slot->bitmap;
  const int first_x = static_cast<int>(left) + slot->bitmap_left;
  const int first_y = static_cast<int>(baseline) - slot->bitmap_top;
  for (int row = 0; row < static_cast<int>(bitmap.rows); ++row)
    for (int column = 0; column < static_cast<int>(bitmap.width); ++column) {
      if (!coverage.contains(first_x + column, first_y + row)) continue;
      const float covered = static_cast<float>(bitmap.buffer[row * bitmap.pitch + column]) / 255.0f;
      float& pixel = coverage.at(first_x + column, first_y + row);
      pixel += covered * (1.0f - pixel);
    }
}

// Coverage of a pixel by the rounded rectangle that fills the picture, from its centre's distance to the edge.
double inside_rounded(int x, int y, int width, int height, double radius) {
  const double dx = std::max(std::abs(x + 0.5 - width / 2.0) - (width / 2.0 - radius), 0.0);
  const double dy = std::max(std::abs(y + 0.5 - height / 2.0) - (height / 2.0 - radius), 0.0);
  if (dx == 0.0 || dy == 0.0) return 1.0;
  return std::clamp(radius - std::hypot(dx, dy) + 0.5, 0.0, 1.0);
}

Rgba8 text_over_background(double text, double background) {
  const double opacity = text + background * (1.0 - text);
  if (opacity <= 0.0) return {};
  const glm::dvec3 colour = (kTextColour * text + kBackground * background * (1.0 - text)) / opacity;
  return {glm::round(glm::dvec4(colour, 255.0 * opacity))};
}

}  // namespace

Result<Image<Rgba8>> draw_caption(const std::string& text, const CaptionStyle& style) {
  Problems problems;
  if (!(style.height_px >= kMinHeight && style.height_px <= kMostHeight))
    problems.add("caption: lines of {} pixels: expected {} to {}", style.height_px, kMinHeight, kMostHeight);
  if (style.largest_width_px < 1 || style.largest_width_px > kMostWidth)
    problems.add("caption: {} pixels wide: expected 1 to {}", style.largest_width_px, kMostWidth);
  auto characters = characters_of(text);
  if (!characters) problems.add("caption: {}", characters.error().message);
  if (characters && characters->size() > kMostCharacters)
    problems.add("caption: {} characters: expected {} at most", characters->size(), kMostCharacters);
  if (!problems.empty()) return fail(problems.fault());
  std::erase(*characters, U'\r');
  const auto fonts = Fonts::open(style);
  if (!fonts) return fail(fonts.error());

  const auto extents_of = [&](std::u32string_view line) {
    std::vector<GlyphExtent> extents;
    fonts->walk(line, [&](const Glyph&, const GlyphExtent& extent) { extents.push_back(extent); });
    return extents;
  };
  const auto width_of = [&](std::u32string_view line) { return line.empty() ? 0.0 : extents_of(line).back().to; };
  const double side = 0.6 * fonts->em_px(), above = 0.35 * fonts->em_px();
  const auto lines = break_lines(*characters, std::max(style.largest_width_px - 2.0 * side, 1.0), extents_of);
  double widest = 0.0;
  for (const auto& line : lines) widest = std::max(widest, width_of(line));

  const int width = std::clamp(static_cast<int>(std::ceil(widest + 2.0 * side)), 1, kMostWidth);
  const int height = std::min(
      static_cast<int>(std::ceil(static_cast<double>(lines.size()) * style.height_px + 2.0 * above)), kMostWidth);
  Image<float> coverage(width, height);
  const double first_baseline =
      above + 0.5 * (style.height_px - (fonts->ascender() - fonts->descender())) + fonts->ascender();
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const double baseline = std::round(first_baseline + static_cast<double>(i) * style.height_px);
    const double left = 0.5 * (width - width_of(lines[i]));
    fonts->walk(lines[i], [&](const Glyph& glyph, const GlyphExtent& extent) {
      add_glyph(coverage, glyph, left + extent.from, baseline, kLargestGlyph_em * fonts->em_px());
    });
  }

  Image<Rgba8> picture(width, height);
  const double radius = std::min({0.45 * fonts->em_px(), 0.5 * width, 0.5 * height});
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      picture.at(x, y) =
          text_over_background(coverage.at(x, y), kBackgroundOpacity * inside_rounded(x, y, width, height, radius));
  return picture;
}

}  // namespace kasumi
