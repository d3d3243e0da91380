// Then and now: the edge between the camera's picture alone, to the left, and the one with the building, each with what
// it is written on it.
#pragma once

#include <optional>
#include <string>

#include "gles/picture/flat_picture.hpp"
#include "pipeline/show/scene/sky_watch.hpp"
#include "pipeline/show/stage/words.hpp"
#include "pipeline/site/config/run_config.hpp"
#include "pipeline/site/visitor/building_view.hpp"

namespace kasumi {

struct HandView {
  double bare = 0.0;      // of the screen's width: the camera's picture alone
  std::string now, then;  // what is to be seen left and right of the edge; `then` also without one, in a view
  friend bool operator==(const HandView&, const HandView&) = default;
};

// Of a picture with the building drawn under that air, in that view; `hour`: hour_of() it.
HandView hand_view(double bare, const SkyReport& sky, Language language, BuildingView view = BuildingView::live,
                   const std::string& hour = {});
// "The building this evening (18:25)"; empty: live.
std::string title_of(BuildingView view, Language language, const std::string& hour = {});
// Of a view of another hour that day, to five minutes by the clock of that zone; without one by the mean sun. Empty: of
// other views.
std::string hour_of(BuildingView view, Utc now, const Site& site, const std::string& time_zone);

class ThenAndNow {
 public:
  // Over a picture that was drawn with Compositor::set_bare(). A side that is too narrow for its words has none.
  // `foot`: pixels that are left to others there. Errors: device.
  Result<> draw(GlContext& context, const HandView& view, const MessageStyle& letters, const DrawTarget& target,
                double foot = 0.0);
  double foot() const { return foot_; }  // of the picture, that these words took last, `foot` included: pixels

 private:
  struct Label {
    std::string text;
    CaptionKey key{};
    std::optional<FlatPicture> picture;
  };
  Result<> draw(Label& label, const std::string& text, double from, double to, double foot, GlContext& context,
                const MessageStyle& letters, const DrawTarget& target);
  Label now_, then_;
  double foot_ = 0.0;
  std::optional<FlatPicture> edge_;
};

}  // namespace kasumi
