// What the camera's picture shows around the building: the horizon's light, the ground, and who passes.
#pragma once

#include <cstdint>
#include <future>
#include <memory>
#include <optional>
#include <utility>

#include "estimator/passers/passers.hpp"
#include "pipeline/show/scene/scene_air.hpp"

namespace kasumi {

class SurroundingsWatch {
 public:
  explicit SurroundingsWatch(const Installation& installation)
      : watches_passers_(installation.people_in_front),
        width_(installation.scene.width),
        height_(installation.scene.height),
        response_(installation.scene.response) {}
  // null: there is none to be seen, or no shadow on it.
  void watch_ground(std::shared_ptr<GroundWatch> ground) { ground_ = std::move(ground); }

  // Where the horizon is due: measures it beside the drawing, while all arguments must stay; or, with `ask`, notes a
  // question once a first horizon is known. Else nothing is valid.
  std::future<HorizonAnswer> measure_horizon(SceneAir& air, const FrameMetadata& metadata,
                                             const DecodedPicture& picture,
                                             const std::shared_ptr<const DecodedPicture>& sky_picture,
                                             const SceneConditions& now, const PixelBox& box, bool ask);
  // Adds the ground to a question that is noted.
  void ask_about_ground(const std::shared_ptr<const ObjectAppearance>& appearance, const AirlightGrid& measured);
  std::optional<HorizonQuestion> take_question() { return std::exchange(question_, std::nullopt); }
  void adopt(const HorizonAnswer& answer);  // the ground's part

  bool sees_ground() const { return ground_ != nullptr; }
  // Looks at it now. Needs sees_ground().
  void look_at_ground(const FrameMetadata& metadata, const PictureView& picture, const ObjectAppearance& appearance,
                      const AirlightGrid& measured);
  const GroundLook& ground() const { return ground_look_; }  // as seen last

  // Who passes before the building, which appears in `box`.
  InFront look_for_passers(const PictureView& picture, Instant captured_at, const PixelBox& box);
  bool watches_passers() const { return watches_passers_; }
  const PassersLook* passers() const { return passers_ ? &passers_->last() : nullptr; }  // null: not looked for
  std::uint64_t outline() const { return outline_; }  // changes with the outline seen last; 0: none
  std::optional<Passers> take_passers() { return std::exchange(passers_, std::nullopt); }
  void adopt(std::optional<Passers> passers) { passers_ = std::move(passers); }

 private:
  bool watches_passers_;
  int width_, height_;  // of the camera's pictures
  Response response_;
  std::optional<Passers> passers_;
  std::uint64_t outlines_ = 0, outline_ = 0;
  std::shared_ptr<GroundWatch> ground_;
  GroundLook ground_look_;
  std::optional<HorizonQuestion> question_;  // not yet taken
};

}  // namespace kasumi
