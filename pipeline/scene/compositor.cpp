#include "pipeline/scene/compositor.hpp"

#include <glm/geometric.hpp>

#include "pipeline/scene/for_gles.hpp"

namespace kasumi {

namespace {

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

Result<> Compositor::draw(const Frame& frame, const SkyReport& sky, const DrawTarget& target) {
  const auto picture = decode(frame, encoding_);
  if (!picture) return fail(picture.error());
  return draw(frame.metadata, *picture, sky, target);
}

Result<> Compositor::draw(const FrameMetadata& metadata, const DecodedPicture& picture, const SkyReport& sky,
                          const DrawTarget& target) {
  if (auto taken = pass_to_gpu(picture); !taken) return taken;
  const auto now = air_.observe(metadata, picture.view(), sky);
  if (auto fitted = update_detail(picture.view().layout, now.haze_blur_px); !fitted) return fitted;
  noise_ = noise_for_gles(quality_, white_balance_, metadata.gain.value_or(1.0), metadata.sequence);

  const auto air = air_.drawn_air(now, renderer_.object_box(), layer_ ? &*layer_ : nullptr);
  if (air.appearance) {
    if (auto drawn = renderer_.redraw_layer(*air.appearance); !drawn) return drawn;
    layer_ = now;
    ++layers_drawn_;
  }
  measured_ = air.measured;
  drawn_ = true;
  return show(target);
}

// Rarely does anything: the layout is known from the first frame on, and the air changes within hours.
Result<> Compositor::update_detail(PixelLayout layout, double haze_blur_px) {
  const auto detail = detail_for_gles(quality_, layout, haze_blur_px);
  if (detail == detail_) return {};
  if (auto set = renderer_.set_detail(detail); !set) return set;
  detail_ = detail;
  layer_.reset();
  return {};
}

Result<> Compositor::draw_without_object(const DecodedPicture& picture, const DrawTarget& target) {
  if (auto taken = pass_to_gpu(picture); !taken) return taken;
  measured_.reset();
  drawn_ = true;
  return show(target);
}

Result<> Compositor::pass_to_gpu(const DecodedPicture& picture) {
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
