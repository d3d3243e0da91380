// What is shown instead of the scene: the curated picture, with the present sky behind its transparent parts, or the
// sky alone where there is no picture.
#pragma once

#include <optional>

#include "gles/air/dome_renderer.hpp"
#include "gles/picture/flat_picture.hpp"
#include "pipeline/show/scene/sky_watch.hpp"
#include "pipeline/site/config/content.hpp"

namespace kasumi {

// Around and instead of a curated picture: a dusky grey that is not mistaken for a black screen.
constexpr Rgba8 kStillBackground{38, 44, 52, 255};
// A longer side is halved: no screen shows more.
constexpr int kLargestStill_px = 4096;

// Parameters of its sky.
struct StillWeather {
  Turbidity turbidity{3.0};  // of an ordinary clear day
  SunDirection sun{0.0, 0.0, 1.0};
  double clouds = 0.0;  // share of the sky that they cover
};
// Empty at night and while the sun's position is unknown: then no sky is shown.
std::optional<StillWeather> still_sky(const SkyReport& report);

class StillPicture {
 public:
  // BLOCKS while the picture is uploaded. `texels`: the curated picture's, where it is known. Errors: bad_input (too
  // large for this GL), device.
  static Result<StillPicture> create(GlContext& context, const Content& content, const FlatTexels* texels = nullptr);

  // Blends it over the target's contents. The sky is redrawn when it has changed visibly: every few minutes. Errors:
  // device.
  Result<> draw(const DrawTarget& target, const SkyReport& report, double opacity);

 private:
  struct ComposedStill {  // the complete picture at a target's size
    FlatPicture picture;
    StillWeather sky;
    int width = 0, height = 0;
  };
  explicit StillPicture(GlContext& context) : context_(&context) {}
  bool holds(const DrawTarget& target, const StillWeather& sky) const;
  Result<> redraw(const DrawTarget& target, const StillWeather& sky);
  Result<> draw_plain(const DrawTarget& target, double opacity);

  GlContext* context_;
  Camera scene_;
  double altitude_m_ = 0.0;  // of the site
  bool shows_sky_ = true;
  std::optional<FlatPicture> curated_;
  std::optional<FlatPicture> background_;  // one pixel
  std::optional<Aerosol> aerosol_;         // exponent and kind, where they are given
  std::optional<DomeRenderer> dome_;       // while it is shown
  std::optional<ComposedStill> with_sky_;
};

}  // namespace kasumi
