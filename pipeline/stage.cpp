#include "pipeline/stage.hpp"

#include <algorithm>

#include <spdlog/spdlog.h>

#include "pipeline/caption.hpp"

namespace kasumi {

namespace {

constexpr Rgba8 kGround{38, 44, 52,
                        255};  // around and instead of a curated picture: a dusk that no one mistakes for black
constexpr Rgba8 kBlack{0, 0, 0, 255};

FlatPlace everywhere(const DrawTarget& target) {
  return {0.0, 0.0, static_cast<double>(target.width), static_cast<double>(target.height)};
}

}  // namespace

Result<Stage> Stage::create(GlContext& context, ContentPtr content, std::optional<SceneAir> air) {
  const auto& installation = content->config.installation;
  auto compositor = Compositor::create(context, installation, content->model,
                                       air ? std::move(*air) : SceneAir(installation, SceneAirOptions{}));
  if (!compositor) return fail(compositor.error());
  Stage stage(context, content, std::move(*compositor));
  if (content->config.overlay)
    stage.overlay_.emplace(context, installation, content->model.bounds(), content->config.words.font_file);

  const auto upload = [&](std::optional<FlatPicture>& to, const Image<Rgba8>& picture) -> Result<> {
    auto flat = FlatPicture::create(context, picture);
    if (!flat) return fail(flat.error());
    to = std::move(*flat);
    return {};
  };
  if (auto done = upload(stage.ground_, Image<Rgba8>(1, 1, kGround)); !done) return fail(done.error());
  if (auto done = upload(stage.black_, Image<Rgba8>(1, 1, kBlack)); !done) return fail(done.error());
  if (content->still)
    if (auto done = upload(stage.still_, *content->still); !done) return fail(done.error());
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
  clear_to(target, glm::vec3(kGround) / 255.0f);
  return {};
}

// The picture goes on without one that cannot be drawn.
Result<> Stage::draw_overlay(const DrawTarget& target) {
  if (!overlay_ || !has_scene_) return {};
  auto drawn = overlay_->draw(target);
  if (drawn || drawn.error().kind == FaultKind::device) return drawn;
  spdlog::warn("the overlay cannot be drawn: {}", drawn.error().message);
  overlay_.reset();
  return {};
}

Result<> Stage::draw_still(double opacity, const DrawTarget& target) {
  if (opacity <= 0.0) return {};
  if (auto drawn = ground_->draw(target, everywhere(target), opacity); !drawn) return drawn;
  if (!still_) return {};
  return still_->draw(target, fitted(target, still_->width(), still_->height()), opacity);
}

void Stage::set_words(Words& drawn, const std::string& text, const DrawTarget& target) {
  if (drawn.text == text && drawn.target_width == target.width) return;
  drawn = {text, target.width, std::nullopt};
  if (text.empty()) return;
  CaptionStyle style;
  style.font_file = content_->config.words.font_file;
  style.height_px = std::max(14.0, target.height / 28.0);
  style.largest_width_px = std::max(64, target.width * 8 / 10);
  const auto picture = draw_caption(text, style);
  if (!picture) {
    spdlog::warn("words cannot be drawn: {}", picture.error().message);
    return;
  }
  if (auto flat = FlatPicture::create(*context_, *picture)) drawn.picture = std::move(*flat);
}

Result<> Stage::draw_words(Words& drawn, const std::string& text, bool at_top, double opacity,
                           const DrawTarget& target) {
  set_words(drawn, text, target);
  if (!drawn.picture || opacity <= 0.0) return {};
  const double width = drawn.picture->width(), height = drawn.picture->height(), margin = target.height / 24.0;
  const FlatPlace place{(target.width - width) / 2.0, at_top ? margin : target.height - margin - height, width, height};
  return drawn.picture->draw(target, place, opacity);
}

Result<> Stage::draw_over(const Composition& composition, const DrawTarget& target) {
  const auto& rung = composition.rung;
  if (auto drawn = draw_overlay(target); !drawn) return drawn;
  if (auto drawn = draw_still(rung.still, target); !drawn) return drawn;
  if (auto drawn = draw_words(caption_, content_->config.still.caption, false, rung.still, target); !drawn)
    return drawn;
  if (auto drawn = draw_words(trouble_, composition.words, true, 1.0, target); !drawn) return drawn;
  return rung.dark > 0.0 ? black_->draw(target, everywhere(target), rung.dark) : Result<>{};
}

}  // namespace kasumi
