// Pictures of the sky, rendered one after the other by the GPU or by the CPU reference.
#pragma once

#include <memory>
#include <optional>

#include "base/image.hpp"
#include "base/picture.hpp"
#include "estimator/sky/sky_scene.hpp"
#include "gles/air/dome_renderer.hpp"
#include "gles/gl/context.hpp"
#include "gles/gl/offscreen.hpp"
#include "pipeline/lab/sky/sky_reference.hpp"
#include "pipeline/lab/sky/synthetic_land.hpp"

namespace kasumi {

struct Viewpoint {
  PanoramaProjection projection = PanoramaProjection::perspective;
  int width = 1280;
  int height = 720;
  double field_of_view_deg = 65.0;  // horizontal; the other projections show everything
  double heading_deg = 0.0;         // fisheye: the azimuth at the picture's top
  double pitch_deg = 12.0;          // not for the others
};
PanoramaView view_of(const Viewpoint& camera);

// Land for such a view, out to the horizon: mountains or the bare plain; none for a fisheye, which sees only sky.
struct LandAround {
  DomeLand land;
  Radians from, to;
};
std::optional<LandAround> land_for(const Viewpoint& camera, double observer_m, bool mountains);

// Keeps the observer at least 25 m above the plain wherever land is drawn.
DomeRequest standing_on_land(const Viewpoint& camera, DomeRequest sky);

// The sky as a camera shows it that meters on its own picture, unless an exposure is asked for. A sun behind the land
// shines into no lens. land: null for none.
DomeScene scene_seen(const Viewpoint& camera, const DomeRequest& sky, const LandAround* land);

class DomeDrawing {
 public:
  // Errors: unsupported (no GL here: --cpu needs none), device.
  static Result<DomeDrawing> by_gpu();
  static DomeDrawing by_cpu() { return DomeDrawing(nullptr); }
  Result<Image<Rgb8>> draw(const PanoramaView& view, const DomeScene& scene, const LandAround* land);

 private:
  explicit DomeDrawing(std::unique_ptr<GlContext> context) : context_(std::move(context)) {}
  std::unique_ptr<GlContext> context_;
  std::optional<DomeRenderer> dome_;
  std::optional<Offscreen> target_;
  int width_ = 0, height_ = 0;
};

}  // namespace kasumi
