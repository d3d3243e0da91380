// Masks as pictures: for the program, and for a person.
#pragma once

#include <filesystem>
#include <string>

#include "base/image.hpp"
#include "base/picture.hpp"
#include "base/result.hpp"
#include "calib/scene_mask.hpp"

namespace kasumi {

// The mask itself: a grey PNG that any paint program edits.
Result<> write_grey_png(const std::filesystem::path& path, const Image<std::uint8_t>& grey);

// The picture with what is hidden in red, by how much, its edge in yellow; strokes, where there are any, as they were
// drawn. Scaled to at most 1280 pixels across.
Image<Rgb8> plot_mask(const Image<Rgb8>& picture, const Image<std::uint8_t>& mask, const Image<Stroke>& strokes,
                      const std::string& title);

}  // namespace kasumi
