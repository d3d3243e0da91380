#include "pipeline/kiosk/appliance/next_stage.hpp"

#include <new>
#include <utility>

namespace kasumi {

void NextStage::order(StageOrder order) {
  making_.reset();
  made_.reset();
  order_ = std::move(order);
}

StageAnswer NextStage::answer(StageAnswer::Kind kind, std::string problem) const {
  return {order_.number, kind, std::move(problem)};
}

Result<bool> NextStage::step(GlContext& context, const Rehearsal& rehearsal) {
  try {
    if (making_) return making_->step();
    auto begun =
        StageMaking::begin(context, order_.content, std::exchange(order_.prepared, nullptr), std::nullopt, rehearsal);
    if (!begun) return fail(begun.error());
    making_.emplace(std::move(*begun));
    return false;
  } catch (const std::bad_alloc&) {
    return fail(FaultKind::device, "there is not enough memory for the new content beside the old one");
  }
}

std::optional<StageAnswer> NextStage::work(GlContext& context, const Rehearsal& rehearsal) {
  const auto whole = step(context, rehearsal);
  if (whole && !*whole) return std::nullopt;
  if (!whole && !context.check_alive()) return lose();  // the fault is not the content's
  if (!whole) {
    auto refused = answer(StageAnswer::Kind::refused, whole.error().message);
    order({});
    return refused;
  }
  made_ = making_->take();
  making_.reset();
  return answer(StageAnswer::Kind::ready);
}

std::optional<StageAnswer> NextStage::lose() {
  const bool unfinished = is_unfinished();
  const auto lost = answer(StageAnswer::Kind::no_display);
  order({});
  return unfinished ? std::optional(lost) : std::nullopt;
}

std::optional<Stage> NextStage::take(const ContentPtr& content) {
  if (!made_ || order_.content != content) return std::nullopt;
  auto taken = std::exchange(made_, std::nullopt);
  order({});
  return taken;
}

}  // namespace kasumi
