// A picture's light in the papers' two terms (M Fig 11, M14 Fig 7): what the air before the building scatters in, and
// what comes through.
#pragma once

#include <filesystem>

#include "gles/gl/offscreen.hpp"
#include "pipeline/show/scene/compositor.hpp"

namespace kasumi {

// Found by drawing the building black, once behind its air and once without: the difference is the airlight. What the
// camera saw beside the building stays whole, for its distance is not known, and counts as direct.
class LightTerms {
 public:
  // Errors: those of Compositor::create and Offscreen::create.
  static Result<LightTerms> create(GlContext& context, const Installation& installation, const Model& model,
                                   AirRendering air, Mixing mixing);

  // `picture`: of this frame, as the compositor drew it. Writes FOLDER/frame-NUMBER.airlight.png and .direct.png, 16
  // bits, in the camera's encoding: in linear light they add up to it. Errors: those of Compositor::draw, io.
  Result<> write(const std::filesystem::path& folder, std::size_t number, const Frame& frame, const SkyReport& sky,
                 const Image<Rgb8>& picture);

 private:
  LightTerms(Response response, Compositor black_in_air, Compositor black, Offscreen target)
      : response_(std::move(response)),
        black_in_air_(std::move(black_in_air)),
        black_(std::move(black)),
        target_(std::move(target)) {}
  Result<Image<Rgb8>> drawn_by(Compositor& compositor, const Frame& frame, const SkyReport& sky);

  Response response_;
  Compositor black_in_air_, black_;
  Offscreen target_;
};

}  // namespace kasumi
