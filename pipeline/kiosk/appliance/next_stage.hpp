// The stage of content that is not in use yet, made between the pictures of the one that is.
#pragma once

#include <optional>

#include "pipeline/kiosk/appliance/mailboxes.hpp"
#include "pipeline/show/stage/stage_making.hpp"

namespace kasumi {

// Belongs to the main thread, as GL does; its GL objects belong to the display's context.
class NextStage {
 public:
  // In the place of what was ordered before.
  void order(StageOrder order);
  bool is_unfinished() const { return order_.content && !made_; }

  // Makes a piece of it, of some milliseconds. The context must be current. Returns what there is to answer.
  std::optional<StageAnswer> work(GlContext& context, const Rehearsal& rehearsal);
  // The display is gone, and all GL objects with it. Returns what there is to answer.
  std::optional<StageAnswer> lose();
  // The finished stage of this content; empty: there is none.
  std::optional<Stage> take(const ContentPtr& content);

 private:
  StageAnswer answer(StageAnswer::Kind kind, std::string problem = {}) const;
  Result<bool> step(GlContext& context, const Rehearsal& rehearsal);

  StageOrder order_;
  std::optional<StageMaking> making_;
  std::optional<Stage> made_;
};

}  // namespace kasumi
