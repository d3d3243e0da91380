#include "pipeline/lab/recording/record_screen.hpp"

#include <algorithm>
#include <cmath>

#include "pipeline/show/scene/for_gles.hpp"
#include "pipeline/show/stage/caption.hpp"

namespace kasumi {

namespace {

constexpr glm::vec3 kBackground{0.15f, 0.17f, 0.2f};
constexpr int kLightSize = 64;

// The usual red recording light, with a soft edge.
Image<Rgba8> red_light() {
  Image<Rgba8> light(kLightSize, kLightSize, Rgba8(224, 32, 32, 0));
  const double middle = 0.5 * (kLightSize - 1), radius = 0.5 * kLightSize - 2.0;
  for (int y = 0; y < kLightSize; ++y)
    for (int x = 0; x < kLightSize; ++x) {
      const double inside = std::clamp(radius - std::hypot(x - middle, y - middle) + 0.5, 0.0, 1.0);
      light.at(x, y).a = static_cast<std::uint8_t>(std::lround(255.0 * inside));
    }
  return light;
}

}  // namespace

Result<RecordScreen> RecordScreen::open(std::unique_ptr<Display> display, const RunConfig& config) {
  auto& context = display->context();
  auto renderer = Renderer::create(context);
  if (!renderer) return fail(renderer.error());
  const auto& scene = config.installation.scene;
  if (auto set = renderer->set_view(view_for_gles(scene, {0.0, 1000.0, 0.0}, 1.0), glm::dmat4{1.0}); !set)
    return fail(set.error());
  if (auto set = renderer->set_response(response_for_gles(scene.response)); !set) return fail(set.error());
  auto light = FlatPicture::create(context, red_light());
  if (!light) return fail(light.error());
  return RecordScreen(std::move(display), std::move(*renderer), std::move(*light), config);
}

Result<> RecordScreen::set_text(const std::string& text, const DrawTarget& target) {
  if (caption_ && text == text_ && target.height == caption_for_height_) return {};
  CaptionStyle style;
  style.font_file = font_;
  style.height_px = std::max(14.0, target.height / 28.0);
  style.largest_width_px = target.width * 3 / 4;
  const auto picture = draw_caption(text, style);
  if (!picture) return fail(picture.error());
  auto caption = FlatPicture::create(display_->context(), *picture);
  if (!caption) return fail(caption.error());
  caption_ = std::move(*caption);
  text_ = text;
  caption_for_height_ = target.height;
  return {};
}

Result<> RecordScreen::show(const Frame* frame, const std::string& text, Instant deadline) {
  const auto target = display_->begin(deadline);
  if (!target) return target.error().kind == FaultKind::timeout ? Result<>{} : fail(target.error());

  // A damaged picture is recorded but not shown.
  if (frame)
    if (const auto picture = decode(*frame, encoding_); picture && renderer_.upload(picture->view()))
      has_picture_ = true;
  if (!has_picture_)
    clear_to(*target, kBackground);
  else if (auto drawn = renderer_.draw_background(*target); !drawn)
    return drawn;

  const double line = std::max(14.0, target->height / 28.0), margin = target->height / 24.0;
  double left = margin;
  if (auto drawn = light_.draw(*target, {left, margin + 0.4 * line, line, line}); !drawn) return drawn;
  left += 1.5 * line;
  // Without a font the red light alone is shown.
  if (set_text(text, *target) && caption_) {
    const FlatPlace place{left, margin, static_cast<double>(caption_->width()),
                          static_cast<double>(caption_->height())};
    if (auto drawn = caption_->draw(*target, place); !drawn) return drawn;
  }
  const auto shown = display_->show();
  if (!shown) return fail(shown.error());
  display_->take_flips();
  return {};
}

}  // namespace kasumi
