// An ordinary clear day over plain land, without a camera's pictures: what models are drawn over on the desk.
#pragma once

#include <optional>
#include <vector>

#include "base/geometry.hpp"
#include "gles/gl/context.hpp"
#include "pipeline/show/scene/compositor_making.hpp"
#include "pipeline/show/scene/sky_watch.hpp"
#include "pipeline/site/config/installation.hpp"

namespace kasumi {

inline constexpr Direction kAfternoon{-0.5, -0.65, 0.6};  // where the sun is, of any length

SkyReport clear_day(const Direction& sun);

// The sky that lights the model, over plain land, as the scene camera encodes it: another sky's colours would be taken
// for the camera's white balance. `air`: instead of an ordinary day's; `exposure`: times that for a landscape.
Image<Rgb8> backdrop(const Installation& installation, const SkyReport& sky,
                     const std::optional<Turbidity>& air = std::nullopt, double exposure = 1.0);

// A camera's picture as it sends it.
Frame rgb_frame(const Image<Rgb8>& picture);

// The scene camera's pictures of the model at its place, one for each day. `prepared`: null: made here. Errors: bad_input (the model), device.
struct ClearDay {
  SkyReport sky;
  Image<Rgb8> backdrop;
};
Result<std::vector<Image<Rgb8>>> drawn_over(GlContext& context, const Installation& installation, const Model& model,
                                            const std::vector<ClearDay>& days,
                                            std::shared_ptr<const CompositorInputs> prepared = nullptr);

}  // namespace kasumi
