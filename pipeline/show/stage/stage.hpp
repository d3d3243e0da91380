// All that one content draws in one GL context: the scene with its building, the curated picture, the messages.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pipeline/show/scene/building_planes.hpp"
#include "pipeline/show/scene/compositor.hpp"
#include "pipeline/show/scene/scene_frame.hpp"
#include "pipeline/show/stage/key_hints.hpp"
#include "pipeline/show/stage/overlay.hpp"
#include "pipeline/show/stage/shown_story.hpp"
#include "pipeline/show/stage/still_picture.hpp"
#include "pipeline/show/stage/then_and_now.hpp"
#include "pipeline/show/stage/words.hpp"
#include "pipeline/site/config/content.hpp"
#include "pipeline/site/config/ladder.hpp"

namespace kasumi {

// What one picture consists of, besides the scene.
struct Composition {
  Rung rung;
  std::string message;                 // what is wrong, for visitors; empty: nothing
  std::vector<std::string> hints{};    // what each button does; none: nothing is written
  HandView hand{};                     // what a visitor wipes; Compositor::set_bare() draws it
  StoryView story{};                   // that a visitor reads
  std::optional<Language> language{};  // a visitor's choice; empty: the configured one
  double print = 1.0;                  // of the letters' usual size
  BuildingView view{};                 // that a visitor has chosen, seen or not yet
  double before = 0.0;                 // opacity of what Stage::fade_from() was given
  std::string over_scene() const;      // what is drawn over the scene, for people; empty: nothing is
  friend bool operator==(const Composition&, const Composition&) = default;
};

// Belongs to the thread of its GL context.
class Stage {
 public:
  // BLOCKS while model and pictures are uploaded; StageMaking does it in pieces. `air`: of an earlier stage of this
  // content. Errors: bad_input (too large for this GL), device, unsupported.
  static Result<Stage> create(GlContext& context, ContentPtr content, std::optional<SceneAir> air = std::nullopt);

  // Draws the scene, from a new frame or (null) as it was drawn last. Errors: bad_input (the frame has another size:
  // nothing was drawn), device.
  Result<> draw_scene(const SceneFrame* frame, const SkyReport& sky, const DrawTarget& target);
  // For a display that lays the building over the camera's picture by itself: takes a frame that lies in a driver's
  // buffer instead of drawing it, and gives the picture for Display::show_planes(). Errors: unsupported (the display has
  // no such buffers), and as draw_scene(); the frame is taken unless it is bad_input.
  Result<> take_scene(const SceneFrame& frame, const SkyReport& sky);
  Result<PlaneStack> scene_for_planes(Display& display, Instant now) {
    return buildings_.next(compositor_, display, now);
  }
  // The scene as it was drawn last, as a picture of its own. Errors: bad_input (nothing was drawn), device.
  Result<FlatPicture> still_scene(int width, int height);
  // What the stage before showed fades away over this one's scene, as Composition::before says; until that is 0.
  void fade_from(FlatPicture before) { before_ = std::move(before); }
  // Then draws what lies over it. Errors: device.
  Result<> draw_over(const Composition& composition, const SkyReport& sky, const DrawTarget& target);

  Compositor& scene() { return compositor_; }
  const Compositor& scene() const { return compositor_; }

  // Whether the scene drawn last includes the building.
  bool draws_object() const { return draws_object_; }

 private:
  friend class StageMaking;
  static Result<Stage> assemble(GlContext& context, ContentPtr content, Compositor compositor, StillPicture still);
  Stage(GlContext& context, ContentPtr content, Compositor compositor, StillPicture still)
      : context_(&context),
        content_(std::move(content)),
        compositor_(std::move(compositor)),
        still_(std::move(still)) {}
  Result<> draw_overlay(const DrawTarget& target);

  GlContext* context_;
  ContentPtr content_;
  Compositor compositor_;
  std::optional<Overlay> overlay_;  // empty: not enabled
  BuildingPlanes buildings_;
  StillPicture still_;
  std::optional<FlatPicture> before_;
  std::optional<FlatPicture> black_;  // one pixel, to fill the target
  Words caption_, trouble_;
  ThenAndNow then_and_now_;
  KeyHints hints_;
  ShownStory story_;
  bool has_scene_ = false;
  bool draws_object_ = false;
};

}  // namespace kasumi
