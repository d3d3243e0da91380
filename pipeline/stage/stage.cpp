#include "pipeline/stage/stage.hpp"

#include <algorithm>

#include <spdlog/spdlog.h>

#include "pipeline/stage/caption.hpp"

namespace kasumi {

namespace {

constexpr Rgba8 kBlack{0, 0, 0, 255};

}  // namespace

Result<Stage> Stage::create(GlContext& context, ContentPtr content, std::optional<SceneAir> air) {
  const auto& installation = content->config.installation;
  auto compositor = Compositor::create(context, installation, content->model,
                                       air ? std::move(*air) : SceneAir(installation, SceneAirOptions{}));
  if (!compositor) return fail(compositor.error());
  auto still = StillPicture::create(context, *content);
  if (!still) return fail(still.error());
  Stage stage(context, content, std::move(*compositor), std::move(*still));
  if (content->config.overlay)
    stage.overlay_.emplace(context, installation, content->model.bounds(), content->config.messages.font_file);

  auto black = FlatPicture::create(context, Image<Rgba8>(1, 1, kBlack));
  if (!black) return fail(black.error());
  stage.black_ = std::move(*black);
  return stage;
}

Result<> Stage::draw_scene(const SceneFrame* frame, const SkyReport& sky, const DrawTarget& target) {
  if (frame) {
    const bool sun_known = sky.sun.source != SunSource::none;
    auto drawn = sun_known ? compositor_.draw(frame->metadata, frame->picture, sky, target)
                           : compositor_.draw_without_object(frame->picture, target);
    has_scene_ = has_scene_ || drawn;
    if (drawn) draws_object_ = sun_known;
    return drawn;
  }
  if (has_scene_) return compositor_.draw_again(target);
  clear_to(target, glm::vec3(kStillBackground) / 255.0f);
  return {};
}

// An overlay that cannot be drawn is dropped, and the picture goes on without it.
Result<> Stage::draw_overlay(const DrawTarget& target) {
  if (!overlay_ || !has_scene_) return {};
  auto drawn = overlay_->draw(target);
  if (drawn || drawn.error().kind == FaultKind::device) return drawn;
  spdlog::warn("the overlay cannot be drawn: {}", drawn.error().message);
  overlay_.reset();
  return {};
}

void Stage::update_text(DrawnText& drawn, const std::string& text, const DrawTarget& target) {
  if (drawn.text == text && drawn.target_width == target.width) return;
  drawn = {text, target.width, std::nullopt};
  if (text.empty()) return;
  CaptionStyle style;
  style.font_file = content_->config.messages.font_file;
  style.height_px = std::max(14.0, target.height / 28.0);
  style.largest_width_px = std::max(64, target.width * 8 / 10);
  const auto picture = draw_caption(text, style);
  if (!picture) {
    spdlog::warn("a message cannot be drawn: {}", picture.error().message);
    return;
  }
  if (auto flat = FlatPicture::create(*context_, *picture)) drawn.picture = std::move(*flat);
}

Result<> Stage::draw_text(DrawnText& drawn, const std::string& text, bool at_top, double opacity,
                          const DrawTarget& target) {
  update_text(drawn, text, target);
  if (!drawn.picture || opacity <= 0.0) return {};
  const double width = drawn.picture->width(), height = drawn.picture->height(), margin = target.height / 24.0;
  const FlatPlace place{(target.width - width) / 2.0, at_top ? margin : target.height - margin - height, width, height};
  return drawn.picture->draw(target, place, opacity);
}

Result<> Stage::draw_over(const Composition& composition, const SkyReport& sky, const DrawTarget& target) {
  const auto& rung = composition.rung;
  if (auto drawn = draw_overlay(target); !drawn) return drawn;
  if (auto drawn = still_.draw(target, sky, rung.still); !drawn) return drawn;
  if (auto drawn = draw_text(caption_, content_->config.still.caption, false, rung.still, target); !drawn) return drawn;
  if (auto drawn = draw_text(trouble_, composition.message, true, 1.0, target); !drawn) return drawn;
  return rung.dark > 0.0 ? black_->draw(target, everywhere(target), rung.dark) : Result<>{};
}

}  // namespace kasumi
