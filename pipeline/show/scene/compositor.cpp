#include "pipeline/show/scene/compositor.hpp"

#include <array>
#include <utility>
#include <vector>

#include "pipeline/show/scene/aged_report.hpp"
#include "pipeline/show/scene/for_gles.hpp"

namespace kasumi {

Result<> Compositor::draw(const Frame& frame, const SkyReport& sky, const DrawTarget& target) {
  const auto picture = decode(frame, encoding_);
  if (!picture) return fail(picture.error());
  return draw(frame.metadata, *picture, sky, target);
}

Result<> Compositor::draw(const FrameMetadata& metadata, const DecodedPicture& picture, const SkyReport& sky,
                          const DrawTarget& target) {
  const bool dimmed = dims();
  if (auto passed = frame_.pass(renderer_, picture, dimmed); !passed) return passed;
  if (auto followed = follow(metadata, picture, sky); !followed) return followed;
  // The layer of another view has just become whole.
  if (dims() != dimmed)
    if (auto passed = frame_.pass(renderer_, picture, dims()); !passed) return passed;
  return show(target);
}

Result<const Image<glm::u8vec4>*> Compositor::mix(const FrameMetadata& metadata, const DecodedPicture& picture,
                                                  const SkyReport& sky) {
  if (auto passed = frame_.pass(renderer_, picture, dims()); !passed) return fail(passed.error());
  if (auto followed = follow(metadata, picture, sky); !followed) return fail(followed.error());
  return measured_ ? renderer_.mix(*measured_, noise_) : renderer_.mix_background();
}

// The air that the frame is drawn under, and the building's layer, which does not need the horizon as it is seen.
Result<> Compositor::follow(const FrameMetadata& metadata, const DecodedPicture& picture, const SkyReport& sky) {
  const auto now = air_.conditions(sky);
  air_.follow_exposure(metadata);
  auto horizon =
      around_.measure_horizon(air_, metadata, picture, sky.picture, now, renderer_.object_box(), clock_ != nullptr);
  const auto wanted = detail_for_gles(quality_, picture.view().layout, now.haze_blur_px);
  noise_ = noise_for_gles(quality_, white_balance_, metadata.gain.value_or(1.0), metadata.sequence);
  if (around_.sees_ground() && !clock_) {  // the layer is to know how this picture's ground is lit
    if (horizon.valid()) air_.adopt(horizon.get());
    if (auto fitted = layer_.fit(renderer_, wanted); !fitted) return fitted;
    const PixelBox box = renderer_.object_box();
    around_.look_at_ground(metadata, picture.view(), *layer_.appearance_at(now, air_, box), air_.measured(now, box));
  }
  const auto under = under_view(now, wanted, sky);
  auto updated = !clock_        ? layer_.update_at_once(renderer_, air_, under)
                 : layer_.any() ? layer_.update_in_slices(renderer_, air_, under, metadata.captured_at, *clock_)
                                : layer_.update_soon(renderer_, air_, under, metadata.captured_at);
  if (horizon.valid()) air_.adopt(horizon.get());
  measured_ = air_.measured(now, renderer_.object_box());
  if (!is_in_other_light() && layer_.view() == BuildingView::live)
    around_.ask_about_ground(layer_.appearance(), *measured_);
  measured_ = light_of_view(std::move(*measured_), now);
  if (!updated) return updated;
  return renderer_.set_in_front(around_.look_for_passers(picture.view(), metadata.captured_at, renderer_.object_box()));
}

bool Compositor::is_in_other_light() const {
  return view_ != BuildingView::live && view_ != BuildingView::alone;
}

LayerConditions Compositor::under_view(const SceneConditions& now, const ObjectDetail& detail,
                                       const SkyReport& sky) const {
  if (!is_in_other_light()) return {now, detail, around_.ground()};
  return {air_.conditions(lit_for(view_, sky, site_), view_), detail, GroundLook{}};
}

// The camera's exposure and white balance are those of now: another hour's horizon is as bright to it as this one, and has
// the colour that it would have.
AirlightGrid Compositor::light_of_view(AirlightGrid measured, const SceneConditions& now) {
  if (!is_another_hour(layer_.view()) || !layer_.appearance()) return measured;
  if (tint_.layer != layer_.drawn()) {
    const auto mean = [](const AirlightGrid& grid) {
      glm::dvec3 sum{0.0};
      for (const auto& light : grid.light) sum += light;
      return sum;
    };
    const glm::dvec3 ratio =
        mean(layer_.appearance()->horizon) / mean(air_.appearance(now, renderer_.object_box()).horizon);
    tint_ = {layer_.drawn(), ratio / ratio.g};
  }
  for (auto& light : measured.light) light *= tint_.factor;
  return measured;
}

void Compositor::adopt(const HorizonAnswer& answer) {
  air_.adopt(answer);
  around_.adopt(answer);
}

Result<> Compositor::take(const FrameMetadata& metadata, const DecodedPicture& picture, const SkyReport& sky) {
  if (auto lent = frame_.lend(picture); !lent) return lent;
  return follow(metadata, picture, sky);
}

Result<> Compositor::take_without_object(const DecodedPicture& picture) {
  measured_.reset();
  return frame_.lend(picture);
}

std::optional<BuildingLook> Compositor::look() const {
  if (!measured_) return std::nullopt;
  return BuildingLook{layer_.drawn(), *measured_, noise_, around_.outline()};
}

Result<> Compositor::draw_for_plane(const DrawTarget& target) {
  if (auto passed = frame_.pass_lent(renderer_); !passed) return passed;
  return renderer_.draw_for_plane(*measured_, target, noise_);
}

Result<> Compositor::begin_layer(const SkyReport& sky, PixelLayout layout) {
  const auto now = air_.conditions(sky);
  const auto under = under_view(now, detail_for_gles(quality_, layout, now.haze_blur_px), sky);
  if (auto fitted = layer_.fit(renderer_, under.detail); !fitted) return fitted;
  measured_ = air_.measured(now, renderer_.object_box());
  return layer_.begin(renderer_, under, air_.appearance(under.scene, renderer_.object_box(), under.ground));
}

Result<> Compositor::rehearse(PixelLayout layout, const DrawTarget& target) {
  PictureView grey{layout, encoding_, width_, height_, {}};
  const auto planes = static_cast<std::size_t>(plane_count(layout));
  std::array<std::vector<std::uint8_t>, 3> bytes;
  for (std::size_t i = 0; i < planes; ++i) {
    const auto size = plane_size(layout, width_, height_, static_cast<int>(i));
    bytes[i].assign(size.row_bytes * static_cast<std::size_t>(size.rows), 128);
    grey.planes[i] = {bytes[i].data(), size.row_bytes};
  }
  if (auto uploaded =
          renderer_.upload(grey, layer_.detail().jpeg_blocks ? std::make_shared<const JpegSteps>() : nullptr);
      !uploaded)
    return uploaded;
  noise_ = noise_for_gles(quality_, white_balance_, 1.0, 0);
  auto drawn = show(target);
  // Somebody in front is drawn by programs of their own, which must not be compiled when the first comes.
  if (drawn && around_.watches_passers()) {
    InFront somebody;
    somebody.pixels = Image<glm::u8vec4>(3, 3, glm::u8vec4{0, 0, 0, 255});
    if (auto set = renderer_.set_in_front(somebody); !set) return set;
    drawn = show(target);
    if (auto set = renderer_.set_in_front({}); !set) return set;
  }
  measured_.reset();
  return drawn;
}

Result<> Compositor::draw_without_object(const DecodedPicture& picture, const DrawTarget& target) {
  if (auto passed = frame_.pass(renderer_, picture); !passed) return passed;
  measured_.reset();
  return show(target);
}

Result<> Compositor::draw_again(const DrawTarget& target) {
  if (!frame_.any()) return fail(FaultKind::bad_input, "no frame of the scene camera has been drawn yet");
  if (auto copied = frame_.release(renderer_); !copied) return copied;
  return show(target);
}

Result<> Compositor::drop_camera_buffers() {
  if (auto copied = frame_.release(renderer_); !copied) return copied;
  renderer_.drop_camera_buffers();
  return {};
}

Result<> Compositor::show(const DrawTarget& target) {
  return measured_ ? renderer_.draw(*measured_, target, noise_) : renderer_.draw_background(target);
}

}  // namespace kasumi
