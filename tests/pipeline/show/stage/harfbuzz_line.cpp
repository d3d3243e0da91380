#include "tests/pipeline/show/stage/harfbuzz_line.hpp"

#include <cmath>

#include <ft2build.h>
#include FT_FREETYPE_H
#include FT_OUTLINE_H

#include <hb-ft.h>
#include <hb.h>

namespace kasumi {

Image<float> harfbuzz_line(const std::string& text, const std::filesystem::path& font, double em_px, double shift_px) {
  FT_Library library = nullptr;
  FT_Face face = nullptr;
  FT_Init_FreeType(&library);
  Image<float> line;
  if (FT_New_Face(library, font.c_str(), 0, &face) == 0) {
    FT_Set_Char_Size(face, 0, std::lround(em_px * 64.0), 72, 72);
    hb_font_t* shaper = hb_ft_font_create_referenced(face);
    hb_ft_font_set_load_flags(shaper, FT_LOAD_NO_HINTING);
    hb_buffer_t* glyphs = hb_buffer_create();
    hb_buffer_add_utf8(glyphs, text.c_str(), -1, 0, -1);
    hb_buffer_guess_segment_properties(glyphs);
    hb_shape(shaper, glyphs, nullptr, 0);
    unsigned count = 0;
    const hb_glyph_info_t* info = hb_buffer_get_glyph_infos(glyphs, &count);
    const hb_glyph_position_t* at = hb_buffer_get_glyph_positions(glyphs, &count);
    double length = 0.0;
    for (unsigned i = 0; i < count; ++i) length += at[i].x_advance / 64.0;
    const int margin = static_cast<int>(em_px);
    line = Image<float>(static_cast<int>(length) + 2 * margin, 3 * margin);
    double pen = margin + shift_px;
    for (unsigned i = 0; i < count; ++i) {
      const double x = pen + at[i].x_offset / 64.0, y = 2.0 * margin - at[i].y_offset / 64.0;
      pen += at[i].x_advance / 64.0;
      if (FT_Load_Glyph(face, info[i].codepoint, FT_LOAD_TARGET_LIGHT | FT_LOAD_NO_BITMAP) != 0) continue;
      const double left = std::floor(x), top = std::ceil(y);
      FT_Outline_Translate(&face->glyph->outline, std::lround((x - left) * 64.0), std::lround((top - y) * 64.0));
      FT_Render_Glyph(face->glyph, FT_RENDER_MODE_NORMAL);
      const FT_Bitmap& bitmap = face->glyph->bitmap;
      for (int row = 0; row < static_cast<int>(bitmap.rows); ++row)
        for (int column = 0; column < static_cast<int>(bitmap.width); ++column) {
          const int to_x = static_cast<int>(left) + face->glyph->bitmap_left + column,
                    to_y = static_cast<int>(top) - face->glyph->bitmap_top + row;
          if (!line.contains(to_x, to_y)) continue;
          float& pixel = line.at(to_x, to_y);
          pixel += static_cast<float>(bitmap.buffer[row * bitmap.pitch + column]) / 255.0f * (1.0f - pixel);
        }
    }
    hb_buffer_destroy(glyphs);
    hb_font_destroy(shaper);
    FT_Done_Face(face);
  }
  FT_Done_FreeType(library);
  return line;
}

}  // namespace kasumi
