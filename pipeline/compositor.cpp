#include "pipeline/compositor.hpp"

#include <cmath>

#include <glm/geometric.hpp>

#include "pipeline/for_gles.hpp"

namespace kasumi {

namespace {

// Below what the eye can see in one step: half a percent of the haze, a tenth of a degree of the sun.
constexpr double kLeastHazeChange = 0.005;
constexpr Radians kLeastSunMove = from_degrees(0.1);
constexpr double kLeastSkyChange = 0.03;  // of the sun's share, of a quarter of the sky

ExternalPicture external(const PictureView& view, const DmaBuf& memory) {
  ExternalPicture picture{memory.fd, memory.buffer, view.layout, view.encoding, view.width, view.height, {}};
  for (std::size_t i = 0; i < static_cast<std::size_t>(plane_count(view.layout)); ++i)
    picture.planes[i] = {memory.offset + static_cast<std::uint32_t>(view.planes[i].data - view.planes[0].data),
                         static_cast<std::uint32_t>(view.planes[i].stride)};
  return picture;
}

}  // namespace

Result<Compositor> Compositor::create(GlContext& context, const Installation& installation, SceneAirOptions options) {
  auto model = read_gltf(installation.object.model, {}, installation.object.scene);
  if (!model) return fail(model.error());
  return create(context, installation, *model, options);
}

Result<Compositor> Compositor::create(GlContext& context, const Installation& installation, const Model& model,
                                      SceneAirOptions options) {
  return create(context, installation, model, SceneAir(installation, options));
}

Result<Compositor> Compositor::create(GlContext& context, const Installation& installation, const Model& model,
                                      SceneAir air, const RendererOptions& options) {
  auto renderer = Renderer::create(context, options);
  if (!renderer) return fail(renderer.error());
  if (auto set = renderer->set_model(model); !set) return fail(set.error());

  const auto to_world = model_to_world(installation.object.placement);
  const auto bounds = model.bounds_with_ground();
  const glm::dvec3 lowest(bounds.lowest), highest(bounds.highest);
  const glm::dvec3 centre(to_world * glm::dvec4(0.5 * (lowest + highest), 1.0));
  const double radius = 0.5 * glm::length(highest - lowest) * installation.object.placement.scale;
  const auto view = view_for_gles(installation.scene, centre, radius);
  if (auto set = renderer->set_view(view, to_world); !set) return fail(set.error());
  if (auto set = renderer->set_foreground(installation.scene.mask); !set) return fail(set.error());
  if (auto set = renderer->set_scene_depth(depth_for_gles(installation.scene, installation.scene_distances_m)); !set)
    return fail(set.error());
  if (auto set = renderer->set_response(response_for_gles(installation.scene.response)); !set) return fail(set.error());
  return Compositor(std::move(*renderer), std::move(air), installation);
}

bool Compositor::is_stale(const SceneConditions& now) const {
  if (!layer_ || layer_->sky != now.sky) return true;
  if ((layer_->measured == nullptr) != (now.measured == nullptr)) return true;
  if (now.measured && difference(*layer_->measured, *now.measured) > kLeastSkyChange) return true;
  const double haze = now.turbidity.value - 1.0, drawn = layer_->turbidity.value - 1.0;
  return std::abs(haze - drawn) > kLeastHazeChange * drawn || angle_between(now.sun, layer_->sun) > kLeastSunMove;
}

Result<> Compositor::draw(const Frame& frame, const SkyReport& sky, const DrawTarget& target) {
  const auto picture = decode(frame, encoding_);
  if (!picture) return fail(picture.error());
  return draw(frame.metadata, *picture, sky, target);
}

Result<> Compositor::draw(const FrameMetadata& metadata, const DecodedPicture& picture, const SkyReport& sky,
                          const DrawTarget& target) {
  if (auto taken = take(picture); !taken) return taken;
  const auto conditions = air_.conditions(sky);
  air_.observe(metadata, picture.view(), sky.picture ? &sky.picture->view() : nullptr, &conditions);

  if (auto fitted = fit_detail(picture.view().layout, conditions); !fitted) return fitted;
  noise_ = noise_for_gles(quality_, white_balance_, metadata.gain.value_or(1.0), metadata.sequence);

  const auto box = renderer_.object_box();
  if (is_stale(conditions)) {
    if (auto drawn = renderer_.redraw_layer(air_.appearance(conditions, box)); !drawn) return drawn;
    layer_ = conditions;
    ++layers_drawn_;
  }
  measured_ = air_.measured(conditions, box);
  drawn_ = true;
  return show(target);
}

// Cameras hardly ever change their layout; the first frame tells it. Air changes by the hour.
Result<> Compositor::fit_detail(PixelLayout layout, const SceneConditions& conditions) {
  const auto detail = detail_for_gles(quality_, layout, air_.haze_blur_px(conditions));
  if (detail == detail_) return {};
  if (auto set = renderer_.set_detail(detail); !set) return set;
  detail_ = detail;
  layer_.reset();
  return {};
}

Result<> Compositor::draw_without_object(const DecodedPicture& picture, const DrawTarget& target) {
  if (auto taken = take(picture); !taken) return taken;
  measured_.reset();
  drawn_ = true;
  return show(target);
}

Result<> Compositor::take(const DecodedPicture& picture) {
  if (picture.dma_buf() && renderer_.import_frame(external(picture.view(), *picture.dma_buf()))) {
    lent_ = picture;
    return {};
  }
  if (auto uploaded = renderer_.upload(picture.view()); !uploaded) return uploaded;
  lent_.reset();
  return {};
}

Result<> Compositor::draw_again(const DrawTarget& target) {
  if (!drawn_) return fail(FaultKind::bad_input, "no frame of the scene camera has been drawn yet");
  if (lent_) {
    if (auto copied = renderer_.upload(lent_->view()); !copied) return copied;
    lent_.reset();
  }
  return show(target);
}

Result<> Compositor::show(const DrawTarget& target) {
  return measured_ ? renderer_.draw(*measured_, target, noise_) : renderer_.draw_background(target);
}

}  // namespace kasumi
