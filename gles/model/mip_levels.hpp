// The smaller levels of a model's textures, averaged in linear light. They take seconds for large pictures, so threads
// that must not wait leave them to the thread that reads the model.
#pragma once

#include <optional>
#include <vector>

#include "gles/model/model.hpp"

namespace kasumi {

// The mean over the area that each new texel covers; sizes need not be multiples. Colours are averaged in linear light
// and weighted by alpha; data directly.
Image<glm::u8vec4> shrunk(const Image<glm::u8vec4>& picture, int width, int height, bool data);
// Half the size each way, rounded down, at least 1.
Image<glm::u8vec4> halved(const Image<glm::u8vec4>& picture, bool data = false);

// The share of a picture whose alpha, interpolated bilinearly, is at least `cutoff`.
double share_above(const Image<glm::u8vec4>& picture, double cutoff, double alpha_scale = 1.0);

// The lowest alpha cutoff of the masked materials that use this texture; empty: no such material.
std::optional<double> cutoff_of(const Model& model, int texture);

// Each half of the one before, down to one texel, without the picture itself. With a cutoff they keep the picture's
// coverage (Castano 2010), or a fence would vanish with distance.
std::vector<Image<glm::u8vec4>> smaller_levels(const Image<glm::u8vec4>& picture, bool data,
                                               std::optional<double> cutoff);
// Gives texels that are wholly transparent the colour of what is visible around them, in the picture and its smaller
// levels: a texel between them and visible ones would else take a part of a colour that was never meant to be seen.
void spread_visible_colours(Image<glm::u8vec4>& picture, std::vector<Image<glm::u8vec4>>& smaller);

// Of all its textures. Alpha that no material of a texture shows is discarded first, since it would weigh colours; where
// all of them show it, visible colours are spread.
void make_levels(Model& model);

}  // namespace kasumi
