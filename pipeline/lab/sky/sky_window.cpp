#include "pipeline/lab/sky/sky_window.hpp"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "estimator/sky/dome.hpp"
#include "gles/air/dome_renderer.hpp"
#include "gles/picture/flat_picture.hpp"
#include "pipeline/machine/stop_signal.hpp"

namespace kasumi {
namespace {

constexpr int kBar_px = 52;
constexpr const char* kHelp =
    "drag: sun    t g: turbidity    a z: altitude    arrows: look    m: mountains    p: air on land    q: quit";

// Two lines of text on a dark bar.
Image<Rgba8> drawn_bar(const std::string& first, const std::string& second) {
  Image<Rgba8> bar(1000, kBar_px, Rgba8(0, 0, 0, 120));
  cv::Mat pixels(bar.height(), bar.width(), CV_8UC4, bar.elements().data());
  const auto line = [&](const std::string& text, int y, double size) {
    cv::putText(pixels, text, {10, y}, cv::FONT_HERSHEY_SIMPLEX, size, cv::Scalar(255, 255, 255, 255), 1, cv::LINE_AA);
  };
  line(first, 20, 0.55);
  line(second, 42, 0.45);
  return bar;
}

}  // namespace

bool SkyWindowState::apply(const WindowInput& input) {
  bool changed = !input.keys.empty();
  for (const char key : input.keys) switch (key) {
      case 't': sky.turbidity.value = std::min(sky.turbidity.value * 1.1, kHighestDomeTurbidity.value); break;
      case 'g': sky.turbidity.value = std::max(sky.turbidity.value / 1.1, kLowestTurbidity.value); break;
      case 'a':
        sky.altitude_m = std::min(sky.altitude_m + std::max(100.0, 0.1 * sky.altitude_m), kHighestDomeAltitude_m);
        break;
      case 'z': sky.altitude_m = std::max(sky.altitude_m - std::max(100.0, 0.1 * sky.altitude_m), 0.0); break;
      case 'm': mountains = !mountains; break;
      case 'p': sky.aerial_perspective = !sky.aerial_perspective; break;
      case '<': camera.heading_deg = std::fmod(camera.heading_deg - 5.0, 360.0); break;
      case '>': camera.heading_deg = std::fmod(camera.heading_deg + 5.0, 360.0); break;
      case '^': camera.pitch_deg = std::min(camera.pitch_deg + 2.0, 60.0); break;
      case 'v': camera.pitch_deg = std::max(camera.pitch_deg - 2.0, -60.0); break;
      default: break;
    }
  if (input.dragging) {
    const PanoramaView view = view_of(camera);
    const glm::dvec2 pixel(input.x_px - 0.5, input.y_px - 0.5);
    if (seen_share(view, pixel) <= 0.0) return changed;
    const Direction towards = direction_of(view, pixel);
    const SunDirection before = sky.sun;
    sky.sun = direction_from(std::min(zenith_angle(towards), kLowestDomeSun), azimuth_angle(towards));
    changed = changed || sky.sun != before;
  }
  return changed;
}

std::string SkyWindowState::caption() const {
  const auto aod = sky.like ? fmt::format("AOD {:.3f}    ", sky.aerosol().aod_550) : std::string();
  return aod + fmt::format("T {:.2f}    altitude {:.0f} m    sun {:.1f} deg from the zenith, azimuth {:.1f} deg",
                           sky.turbidity.value, sky.altitude_m, to_degrees(zenith_angle(sky.sun)),
                           to_degrees(azimuth_angle(sky.sun)));
}

Result<> show_sky_window(const DrawingTask& task) {
  SkyWindowState shown{task.camera, task.sky, task.mountains};
  auto window = open_window({"Kasumi: the sky", shown.camera.width, shown.camera.height, true});
  if (!window) return fail(window.error());
  auto dome = DomeRenderer::create(**window);
  if (!dome) return fail(dome.error());
  bool redraw = true;
  std::optional<LandAround> land;
  std::string land_of;
  std::optional<FlatPicture> bar;
  while (!stop_requested() && (*window)->handle_events()) {
    const DrawTarget target = (*window)->target();
    if (target.width != shown.camera.width || target.height != shown.camera.height) {
      shown.camera.width = std::max(target.width, 16);
      shown.camera.height = std::max(target.height, 16);
      redraw = true;
    }
    if (shown.apply((*window)->take_input()) || redraw) {
      redraw = false;
      const auto& c = shown.camera;
      // The land is rebuilt only when the view of it changes.
      const auto now = fmt::format("{} {} {} {} {} {}", c.width, c.height, c.heading_deg, c.pitch_deg, shown.mountains,
                                   shown.sky.altitude_m);
      if (now != land_of) {
        land = land_for(c, standing_on_land(c, shown.sky).altitude_m, shown.mountains);
        if (auto set = dome->set_land(land ? land->land : DomeLand{}); !set) return set;
        land_of = now;
      }
      const auto scene = scene_seen(c, standing_on_land(c, shown.sky), land ? &*land : nullptr);
      if (auto set = dome->set(view_of(c), scene); !set) return set;
      auto caption = FlatPicture::create(**window, drawn_bar(shown.caption(), kHelp));
      if (!caption) return fail(caption.error());
      bar.emplace(std::move(*caption));
    }
    if (auto drawn = dome->draw(target); !drawn) return drawn;
    const FlatPlace place{0.0, 0.0, static_cast<double>(bar->width()), static_cast<double>(bar->height())};
    if (auto drawn = bar->draw(target, place); !drawn) return drawn;
    (*window)->show();
  }
  return {};
}

}  // namespace kasumi
