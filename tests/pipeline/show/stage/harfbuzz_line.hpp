// A line of text as HarfBuzz shapes it and FreeType draws it, by which Pango's is judged.
#pragma once

#include <filesystem>
#include <string>

#include "base/image.hpp"

namespace kasumi {

// Coverage, 0..1, of the line in that font, in the direction of its script, the pen `shift_px` right of a whole pixel. Empty:
// the font cannot be read.
Image<float> harfbuzz_line(const std::string& text, const std::filesystem::path& font, double em_px, double shift_px);

}  // namespace kasumi
