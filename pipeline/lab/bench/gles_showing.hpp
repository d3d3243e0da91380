// A renderer that is ready to draw the bench's scene, and its redraws of a day.
#pragma once

#include <memory>

#include <glm/geometric.hpp>

#include "gles/composite/renderer.hpp"
#include "gles/gl/context.hpp"
#include "pipeline/lab/bench/gles_scene.hpp"

namespace kasumi {

inline Result<Renderer> showing(GlContext& context, const BenchScene& scene, const Model& model,
                                const ObjectDetail& detail = {}, Mixing mixing = Mixing::gpu) {
  auto renderer = Renderer::create(context, {.mixing = mixing});
  if (!renderer) return renderer;
  if (auto set = renderer->set_model(model); !set) return fail(set.error());
  if (auto set = renderer->set_view(scene.view, scene.model_to_world); !set) return fail(set.error());
  if (auto set = renderer->set_detail(detail); !set) return fail(set.error());
  if (auto drawn = renderer->redraw_layer(scene.appearance); !drawn) return fail(drawn.error());
  if (auto loaded = renderer->upload(scene.frame.rgba()); !loaded) return fail(loaded.error());
  return renderer;
}

// Of a JPEG of quality 85, nearly.
inline std::shared_ptr<const JpegSteps> steps_of_jpeg() {
  JpegSteps steps;
  for (std::size_t i = 0; i < steps.luma.size(); ++i) {
    const auto order = static_cast<std::uint16_t>(i / 8 + i % 8);  // across and down
    steps.luma[i] = static_cast<std::uint16_t>(4 + 2 * order);
    steps.chroma[i] = static_cast<std::uint16_t>(5 + 3 * order);
  }
  return std::make_shared<const JpegSteps>(steps);
}

// The layer under a sun and a sky that have moved since it was drawn last, as every redraw of a day.
class MovingSun {
 public:
  MovingSun(Renderer& renderer, const ObjectAppearance& appearance, bool shadows)
      : renderer_(renderer), appearance_(appearance) {
    appearance_.shadows = shadows;
  }
  Result<> operator()() {
    const double turn = 0.002;
    const glm::dvec3 d = appearance_.light.sun_direction;
    appearance_.light.sun_direction = glm::normalize(glm::dvec3{d.x - turn * d.y, d.y + turn * d.x, d.z});
    for (glm::vec3& light : appearance_.light.around.radiance.elements()) light *= 1.001f;
    return renderer_.redraw_layer(appearance_);
  }

 private:
  Renderer& renderer_;
  ObjectAppearance appearance_;
};

}  // namespace kasumi
