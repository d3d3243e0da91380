#include "pipeline/show/scene/compositor_making.hpp"

#include <algorithm>

#include <spdlog/spdlog.h>
#include <glm/geometric.hpp>

#include "gles/model/mip_levels.hpp"
#include "pipeline/show/scene/for_gles.hpp"

namespace kasumi {

Result<Compositor> Compositor::create(GlContext& context, const Installation& installation, AirRendering options) {
  auto model = read_gltf(installation.object.model, {}, installation.object.scene);
  if (!model) return fail(model.error());
  make_levels(*model);
  for (const auto& note : model->notes) spdlog::info("{}", note);
  return create(context, installation, *model, options);
}

Result<Compositor> Compositor::create(GlContext& context, const Installation& installation, const Model& model,
                                      AirRendering options) {
  return create(context, installation, model, SceneAir(installation, options));
}

Result<Compositor> Compositor::create(GlContext& context, const Installation& installation, const Model& model,
                                      SceneAir air, const RendererOptions& options,
                                      std::shared_ptr<const CompositorInputs> prepared) {
  auto making = CompositorMaking::begin(context, installation, model, std::move(prepared), std::move(air), options);
  if (!making) return fail(making.error());
  for (;;) {
    const auto whole = making->step();
    if (!whole) return fail(whole.error());
    if (*whole) return making->take();
  }
}

CompositorInputs prepare_scene(const Installation& installation, const Model& model) {
  CompositorInputs prepared{cut_model(model), depth_for_gles(installation.scene, installation.scene_distances_m),
                            nullptr};
  if (!installation.object.shadows || !installation.object.ground_light || model.ground.empty()) return prepared;
  auto ground = std::make_shared<GroundWatch>(installation.scene, model, installation.object.placement);
  if (!ground->empty()) prepared.ground = std::move(ground);
  return prepared;
}

Result<CompositorMaking> CompositorMaking::begin(GlContext& context, const Installation& installation,
                                                 const Model& model, std::shared_ptr<const CompositorInputs> prepared,
                                                 SceneAir air, const RendererOptions& options) {
  if (auto sound = check(model); !sound) return fail(sound.error());
  if (!prepared) prepared = std::make_shared<const CompositorInputs>(prepare_scene(installation, model));
  auto renderer = Renderer::create(context, options);
  if (!renderer) return fail(renderer.error());
  const bool reflects = std::ranges::any_of(model.materials, &ModelMaterial::reflects);
  auto filters = reflects ? std::async(std::launch::async, prepare_atlas_squares) : std::future<void>();
  const std::shared_ptr<const TriangleChunks> chunks(prepared, &prepared->chunks);
  if (auto begun = renderer->begin_model(model, chunks); !begun) return fail(begun.error());
  Compositor made(std::move(*renderer), std::move(air), installation);
  made.filters_ = std::move(filters);
  made.around_.watch_ground(prepared->ground);
  return CompositorMaking(std::move(made), installation, model, std::move(prepared));
}

Result<bool> CompositorMaking::step() {
  const auto whole = made_.renderer_.continue_model();
  if (!whole || !*whole) return whole;
  if (auto set = set_scene(); !set) return fail(set.error());
  prepared_.reset();
  return true;
}

Result<> CompositorMaking::set_scene() {
  Renderer& renderer = made_.renderer_;
  const Camera& scene = installation_->scene;
  const auto to_world = model_to_world(installation_->object.placement);
  const auto bounds = model_->bounds_with_ground();
  const glm::dvec3 lowest(bounds.lowest), highest(bounds.highest);
  const glm::dvec3 centre(to_world * glm::dvec4(0.5 * (lowest + highest), 1.0));
  const double radius = 0.5 * glm::length(highest - lowest) * installation_->object.placement.scale;
  if (auto set = renderer.set_view(view_for_gles(scene, centre, radius), to_world); !set) return set;
  if (auto set = renderer.set_foreground(scene.mask, installation_->scene_quality.point_spread_px); !set) return set;
  if (auto set = renderer.set_scene_depth(prepared_->depth_m); !set) return set;
  return renderer.set_response(response_for_gles(scene.response));
}

}  // namespace kasumi
