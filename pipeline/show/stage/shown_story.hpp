// The story that a visitor reads, in its panel beside the building. Laid out anew only when story or screen change.
#pragma once

#include <optional>
#include <string>

#include "gles/picture/flat_picture.hpp"
#include "pipeline/show/stage/story_panel.hpp"
#include "pipeline/site/config/content.hpp"

namespace kasumi {

struct StoryView {
  std::string title, text;  // UTF-8; no text: no story is read
  std::string language;     // ISO 639
  PanelReader reader{};
  friend bool operator==(const StoryView&, const StoryView&) = default;
};

// The building in the scene camera's picture, as a screen of that size shows it. Empty: outside the picture.
std::optional<FlatPlace> building_on_screen(const Installation& installation, const Model& model, int width,
                                            int height);

// The panel that a visitor reads on a screen of that size. Errors: as draw_story_panel().
Result<StoryPanel> panel_of(const StoryView& view, const Content& content, const Installation& kiosk, int width,
                            int height, double foot = 0.0);
// The same laid over a picture of the scene camera, by the processor.
Result<> lay_story_over(Image<Rgb8>& picture, const StoryView& view, const Content& content, const Installation& kiosk);

class ShownStory {
 public:
  // A panel that has no room beside the building is left out, and logged once. BLOCKS for as long as the letters take.
  // `foot`: of the screen, that others take: while one story is read, the most that they took. Errors: device.
  Result<> draw(GlContext& context, const StoryView& view, const Content& content, const DrawTarget& target,
                double foot = 0.0);

 private:
  void lay_out(GlContext& context, const Content& content, const DrawTarget& target);

  StoryView view_;
  int width_ = 0, height_ = 0;  // of the target
  double foot_ = 0.0;
  FlatPlace place_;
  std::optional<FlatPicture> panel_;  // empty: no story, or no room
};

}  // namespace kasumi
