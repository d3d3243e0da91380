#include "pipeline/show/stage/stage.hpp"

#include <spdlog/spdlog.h>

#include "pipeline/show/stage/stage_making.hpp"

namespace kasumi {

namespace {

constexpr Rgba8 kBlack{0, 0, 0, 255};  // opaque

}  // namespace

std::string Composition::over_scene() const {
  if (rung.dark > 0.0) return "the screen is dark";
  if (rung.still > 0.0) return "the still picture is shown";
  if (hand.bare > 0.0) return "a visitor wipes";
  if (view != BuildingView::live || !hand.then.empty()) return "a visitor looks at another view";
  if (before > 0.0) return "one era fades into another";
  if (!story.text.empty()) return "a visitor reads a story";
  if (!hints.empty()) return "the buttons are labelled";
  return message.empty() ? "" : "words are shown";
}

Result<Stage> Stage::create(GlContext& context, ContentPtr content, std::optional<SceneAir> air) {
  auto making = StageMaking::begin(context, std::move(content), nullptr, std::move(air));
  if (!making) return fail(making.error());
  for (;;) {
    const auto whole = making->step();
    if (!whole) return fail(whole.error());
    if (*whole) return making->take();
  }
}

Result<Stage> Stage::assemble(GlContext& context, ContentPtr content, Compositor compositor, StillPicture still) {
  Stage stage(context, content, std::move(compositor), std::move(still));
  if (content->config.overlay)
    stage.overlay_.emplace(context, content->config.installation, content->model->bounds(),
                           content->config.messages.font_file);
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

Result<> Stage::take_scene(const SceneFrame& frame, const SkyReport& sky) {
  const bool sun_known = sky.sun.source != SunSource::none;
  auto taken =
      sun_known ? compositor_.take(frame.metadata, frame.picture, sky) : compositor_.take_without_object(frame.picture);
  has_scene_ = has_scene_ || taken;
  if (taken) draws_object_ = sun_known;
  return taken;
}

Result<FlatPicture> Stage::still_scene(int width, int height) {
  auto unseen = Offscreen::create(context_->info(), width, height);
  if (!unseen) return fail(unseen.error());
  if (auto drawn = compositor_.draw_again(unseen->target()); !drawn) return fail(drawn.error());
  return FlatPicture::create(*context_, std::move(*unseen));
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

Result<> Stage::draw_over(const Composition& composition, const SkyReport& sky, const DrawTarget& target) {
  const auto& rung = composition.rung;
  auto letters = content_->config.messages;
  letters.language = composition.language.value_or(letters.language);
  letters.print = composition.print;
  if (before_ && composition.before > 0.0)
    if (auto drawn = before_->draw(target, everywhere(target), composition.before); !drawn) return drawn;
  if (composition.before <= 0.0) before_.reset();
  if (auto drawn = draw_overlay(target); !drawn) return drawn;
  if (auto drawn = hints_.draw(*context_, composition.hints, letters, target); !drawn) return drawn;
  // Each above the one before.
  if (auto drawn = then_and_now_.draw(*context_, composition.hand, letters, target, hints_.foot()); !drawn)
    return drawn;
  if (auto drawn = story_.draw(*context_, composition.story, *content_, target, then_and_now_.foot()); !drawn)
    return drawn;
  if (auto drawn = still_.draw(target, sky, rung.still); !drawn) return drawn;
  if (auto drawn = caption_.draw(*context_, content_->config.still.caption, letters, false, rung.still, target); !drawn)
    return drawn;
  if (auto drawn = trouble_.draw(*context_, composition.message, letters, true, 1.0, target); !drawn) return drawn;
  return rung.dark > 0.0 ? black_->draw(target, everywhere(target), rung.dark) : Result<>{};
}

}  // namespace kasumi
