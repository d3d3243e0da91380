#include "pipeline/show/stage/shown_story.hpp"

#include <algorithm>

#include <spdlog/spdlog.h>

#include "pipeline/show/stage/font_patience.hpp"
#include "pipeline/site/config/sighting.hpp"

namespace kasumi {

std::optional<FlatPlace> building_on_screen(const Installation& installation, const Model& model, int width,
                                            int height) {
  const auto sighting = sight_object(installation, model.bounds());
  if (!sighting.in_picture()) return std::nullopt;
  const Camera& scene = installation.scene;
  const double scale = std::min(1.0 * width / scene.width, 1.0 * height / scene.height);
  const glm::dvec2 corner{(width - scale * scene.width) / 2.0, (height - scale * scene.height) / 2.0};
  const glm::dvec2 from = corner + scale * (sighting.least_px + 0.5),
                   to = corner + scale * (sighting.greatest_px + 0.5);
  return FlatPlace{from.x, from.y, to.x - from.x, to.y - from.y};
}

void ShownStory::lay_out(GlContext& context, const Content& content, const DrawTarget& target) {
  panel_.reset();
  if (view_.text.empty()) return;
  PanelRequest request{view_.title, view_.text, view_.language};
  request.font_file = content.config.messages.font_file;
  request.width = target.width;
  request.height = target.height;
  request.building = building_on_screen(content.config.installation, *content.model, target.width, target.height);
  request.reader = view_.reader;
  auto laid = with_fonts<Result<StoryPanel>>([request] {
                return draw_story_panel(request);
              }).value_or(fail(FaultKind::io, "the fonts' disk does not answer"));
  if (!laid) return spdlog::warn("the story \"{}\" is not shown: {}", view_.title, laid.error().message);
  auto picture = FlatPicture::create(context, laid->picture);
  if (!picture) return spdlog::warn("the story \"{}\" is not shown: {}", view_.title, picture.error().message);
  panel_ = std::move(*picture);
  place_ = laid->place;
}

Result<> ShownStory::draw(GlContext& context, const StoryView& view, const Content& content, const DrawTarget& target) {
  if (view_ != view || width_ != target.width || height_ != target.height) {
    view_ = view;
    width_ = target.width;
    height_ = target.height;
    lay_out(context, content, target);
  }
  return panel_ ? panel_->draw(target, place_) : Result<>{};
}

}  // namespace kasumi
