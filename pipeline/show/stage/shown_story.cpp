#include "pipeline/show/stage/shown_story.hpp"

#include <algorithm>

#include <spdlog/spdlog.h>
#include <glm/common.hpp>

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

Result<StoryPanel> panel_of(const StoryView& view, const Content& content, const Installation& kiosk, int width,
                            int height, double foot) {
  PanelRequest request{view.title, view.text, view.language};
  request.font_file = content.config.messages.font_file;
  request.width = width;
  request.height = height;
  request.building = building_on_screen(kiosk, *content.model, width, height);
  request.foot = foot;
  request.reader = view.reader;
  return with_fonts<Result<StoryPanel>>([request] { return draw_story_panel(request); })
      .value_or(fail(FaultKind::io, "the fonts' disk does not answer"));
}

Result<> lay_story_over(Image<Rgb8>& picture, const StoryView& view, const Content& content,
                        const Installation& kiosk) {
  const auto laid = panel_of(view, content, kiosk, picture.width(), picture.height());
  if (!laid) return fail(laid.error());
  const auto& panel = laid->picture;
  const int left = static_cast<int>(laid->place.left), top = static_cast<int>(laid->place.top);
  for (int y = std::max(0, -top); y < std::min(panel.height(), picture.height() - top); ++y)
    for (int x = std::max(0, -left); x < std::min(panel.width(), picture.width() - left); ++x) {
      const Rgba8 over = panel.at(x, y);
      Rgb8& under = picture.at(left + x, top + y);
      under = Rgb8(glm::round(glm::mix(glm::dvec3(under), glm::dvec3(over), over.a / 255.0)));
    }
  return {};
}

void ShownStory::lay_out(GlContext& context, const Content& content, const DrawTarget& target) {
  panel_.reset();
  if (view_.text.empty()) return;
  const auto laid = panel_of(view_, content, content.config.installation, target.width, target.height, foot_);
  if (!laid) return spdlog::warn("the story \"{}\" is not shown: {}", view_.title, laid.error().message);
  auto picture = FlatPicture::create(context, laid->picture);
  if (!picture) return spdlog::warn("the story \"{}\" is not shown: {}", view_.title, picture.error().message);
  panel_ = std::move(*picture);
  place_ = laid->place;
}

Result<> ShownStory::draw(GlContext& context, const StoryView& view, const Content& content, const DrawTarget& target,
                          double foot) {
  const bool same = view_ == view && width_ == target.width && height_ == target.height;
  if (!same || foot > foot_) {  // less foot: what is being read stays where it is
    view_ = view;
    foot_ = foot;
    width_ = target.width;
    height_ = target.height;
    lay_out(context, content, target);
  }
  return panel_ ? panel_->draw(target, place_) : Result<>{};
}

}  // namespace kasumi
