// Models that are too large for a kiosk, reduced to what its scene camera can show of them; the loss is measured in that
// camera's pixels.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "pipeline/site/config/content.hpp"

namespace kasumi {

// Beyond one of these a model is too large.
inline constexpr std::size_t kManyTriangles = 200'000;
inline constexpr int kLargeTexture = 2048;  // texels a side
inline constexpr std::uintmax_t kLargeModelBytes = 20'000'000;

inline constexpr double kMostModelLoss = 0.3;  // of 255

struct ModelReduction {
  ContentPtr content;  // with the models as they are packed
  // Model files, and what is packed under their names in their place; it lies in the workplace.
  std::map<std::filesystem::path, std::filesystem::path> instead;
  std::vector<std::filesystem::path> left_out;  // buffers and pictures that reduced models no longer need
  std::vector<std::string> lines;               // for people: what was reduced, or why it was not
};

// Draws each model that is too large and coarser ones from the scene camera, under three suns of a clear day, and takes the
// coarsest whose mean absolute difference over the building's pixels is at most `most_loss` of 255 under each of them. A
// model stays as it is where none is, where no GL is at hand to draw it, or where the camera does not see it.
// Errors: io, bad_input where what was written cannot be read.
Result<ModelReduction> reduce_models(const ContentPtr& content, const std::filesystem::path& workplace,
                                     double most_loss = kMostModelLoss);

}  // namespace kasumi
