#include "pipeline/show/stage/stories_on_glass.hpp"

#include "pipeline/show/stage/shown_story.hpp"
#include "pipeline/site/config/story_sight.hpp"

namespace kasumi {
namespace {

// Letters grow with the screen: any will do of the shape of most.
constexpr int kUsualWidth = 1280, kUsualHeight = 720;

void read_story(const Story& story, const Content& content, const std::optional<FlatPlace>& building,
                std::vector<std::string>& faults) {
  for (const auto& language : content.visitor->languages) {
    const auto where =
        fmt::format("{}: {}.text.{} ({})", content.visitor->file.string(), story.key, language, story.name);
    PanelRequest request{story.title.at(language), story.text.at(language), language};
    request.font_file = content.config.messages.font_file;
    request.width = kUsualWidth;
    request.height = kUsualHeight;
    request.building = building;
    const auto panel = draw_story_panel(request);
    if (!panel) faults.push_back(fmt::format("{}: {}", where, panel.error().message));
    if (panel)
      for (const auto& fault : panel->faults) faults.push_back(fmt::format("{}: {}", where, fault));
  }
}

}  // namespace

std::vector<std::string> stories_that_cannot_be_seen(const Content& content) {
  std::vector<std::string> faults;
  if (!content.visitor) return faults;
  const auto& installation = content.config.installation;
  const auto models = shown_models(content);
  const auto building = building_on_screen(installation, *models.front().model, kUsualWidth, kUsualHeight);
  for (const Story& story : content.visitor->stories) {
    std::string unseen;
    bool seen = false;
    for (const auto& shown : models) {
      const auto place = is_told_in(story, shown.era) ? place_of(story, *shown.model) : std::nullopt;
      if (!place || seen) continue;
      const auto why = why_unseen(installation, *shown.model, *place);
      seen = why.empty();
      if (unseen.empty()) unseen = why;
    }
    if (!seen && !unseen.empty())
      faults.push_back(fmt::format("{}: {}.{} ({}): never seen from the kiosk: {}", content.visitor->file.string(),
                                   story.key, story.node.empty() ? "place_m" : "node", story.name, unseen));
    read_story(story, content, building, faults);
  }
  return faults;
}

}  // namespace kasumi
