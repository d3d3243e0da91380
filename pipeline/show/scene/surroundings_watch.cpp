#include "pipeline/show/scene/surroundings_watch.hpp"

namespace kasumi {

namespace {

constexpr int kAroundBuilding_px = 32;  // margin in which ambient light and approaching people are measured

}  // namespace

std::future<HorizonAnswer> SurroundingsWatch::measure_horizon(SceneAir& air, const FrameMetadata& metadata,
                                                              const DecodedPicture& picture,
                                                              const std::shared_ptr<const DecodedPicture>& sky_picture,
                                                              const SceneConditions& now, const PixelBox& box,
                                                              bool ask) {
  if (!air.horizon_is_due(metadata)) return {};
  if (!ask || !air.horizon().usable())
    return std::async(std::launch::async,
                      [&metadata, &picture, &now, sky = sky_picture, observer = air.observer(), box] {
                        return answer(observer, metadata, picture.view(), sky ? &sky->view() : nullptr, now, box);
                      });
  air.asked(metadata);
  question_ = HorizonQuestion{air.observer(), metadata, CopiedPicture(picture.view()), sky_picture, now, box};
  return {};
}

void SurroundingsWatch::ask_about_ground(const std::shared_ptr<const ObjectAppearance>& appearance,
                                         const AirlightGrid& measured) {
  if (question_ && ground_ && appearance) question_->ground = GroundQuestion{ground_, appearance, measured};
}

void SurroundingsWatch::adopt(const HorizonAnswer& answer) {
  if (answer.watch && answer.watch == ground_) ground_look_ = answer.ground;
}

void SurroundingsWatch::look_at_ground(const FrameMetadata& metadata, const PictureView& picture,
                                       const ObjectAppearance& appearance, const AirlightGrid& measured) {
  ground_->see(picture, metadata, appearance, measured);
  ground_->shade_foot(true);
  ground_look_ = ground_->look();
}

InFront SurroundingsWatch::look_for_passers(const PictureView& picture, Instant captured_at, const PixelBox& box) {
  outline_ = 0;
  if (!watches_passers_ || box.empty()) {
    passers_.reset();
    return {};
  }
  const auto place = part_around(box.left, box.top, box.right, box.bottom, kAroundBuilding_px, width_, height_);
  if (!passers_ || passers_->place() != place) passers_.emplace(place, response_);
  const auto& in_front = passers_->look(picture, captured_at).in_front;
  if (!in_front.empty()) outline_ = ++outlines_;
  return {in_front.left, in_front.top, in_front.pixels};
}

}  // namespace kasumi
