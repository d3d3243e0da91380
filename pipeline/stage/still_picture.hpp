// What is shown instead of the scene: the curator's picture, and where that is transparent, or where there is none, the
// sky as it is now behind it.
#pragma once

#include <optional>

#include "gles/air/dome_renderer.hpp"
#include "gles/picture/flat_picture.hpp"
#include "pipeline/config/content.hpp"
#include "pipeline/scene/sky_watch.hpp"

namespace kasumi {

// Around and instead of a curated picture: a dusk that no one mistakes for black.
constexpr Rgba8 kStillBackground{38, 44, 52, 255};

// What its sky is drawn from.
struct StillSky {
  Turbidity turbidity{3.0};  // of an ordinary clear day
  SunDirection sun{0.0, 0.0, 1.0};
  double clouds = 0.0;  // share of the sky: the more, the greyer
};
// Empty while nobody knows where the sun is, or that it is night or the lens covered: then there is no sky to show.
std::optional<StillSky> still_sky(const SkyReport& report);

class StillPicture {
 public:
  // BLOCKS while the picture is uploaded. Errors: bad_input (too large for this GL), device.
  static Result<StillPicture> create(GlContext& context, const Content& content);

  // Blends it over what the target shows. The sky is drawn anew where it has changed for the eye: every few minutes.
  // Errors: device.
  Result<> draw(const DrawTarget& target, const SkyReport& report, double opacity);

 private:
  struct WithSky {  // the whole picture, of a target's size
    FlatPicture picture;
    StillSky sky;
    int width = 0, height = 0;
  };
  explicit StillPicture(GlContext& context) : context_(&context) {}
  bool holds(const DrawTarget& target, const StillSky& sky) const;
  Result<> redraw(const DrawTarget& target, const StillSky& sky);
  Result<> draw_plain(const DrawTarget& target, double opacity);

  GlContext* context_;
  Camera scene_;
  double altitude_m_ = 0.0;  // of the site
  bool shows_sky_ = true;
  std::optional<FlatPicture> curated_;
  std::optional<FlatPicture> background_;  // one pixel
  std::optional<DomeRenderer> dome_;       // once it has been wanted
  std::optional<WithSky> with_sky_;
};

}  // namespace kasumi
