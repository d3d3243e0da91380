#include "pipeline/lab/bench/gles_papers.hpp"

#include <GLES2/gl2.h>

#include "gles/gl/texture_units.hpp"
#include "gles/light/airlight_grid.hpp"
#include "gles/light/appearance.hpp"

namespace kasumi {
namespace {

Result<GlFramebuffer> make_framebuffer_of(const GlTexture& colour, const GlTexture* depth) {
  GlFramebuffer framebuffer = make_framebuffer();
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, colour.name(), 0);
  if (depth != nullptr) glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depth->name(), 0);
  if (auto complete = check_framebuffer("a buffer of the papers' layout"); !complete) return fail(complete.error());
  return framebuffer;
}

GlTexture make_nearest_texture(int width, int height, GLenum format, GLenum type, const void* pixels) {
  GlTexture texture = make_texture();
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, texture.name());
  glTexImage2D(GL_TEXTURE_2D, 0, static_cast<GLint>(format), width, height, 0, format, type, pixels);
  set_filter(TextureFilter::nearest);
  clamp_to_edge();
  return texture;
}

}  // namespace

GlTexture make_picture_texture(int width, int height, const void* pixels) {
  return make_nearest_texture(width, height, GL_RGBA, GL_UNSIGNED_BYTE, pixels);
}

Result<TwoBufferLayout> TwoBufferLayout::create(const GlInfo& info, unsigned picture, const BenchScene& scene,
                                                GammaBy gamma) {
  if (info.es_major < 3 && !info.has("GL_OES_depth_texture"))
    return fail(FaultKind::unsupported, "{}: no depth textures, which the papers' layout needs", info.renderer);
  TwoBufferLayout layout;
  layout.scene_ = scene;
  std::vector<std::string> notes;
  auto model = GpuModel::upload(scene.facade, info, false, notes);
  if (!model) return fail(model.error());
  auto projection = make_projection(scene.view, scene.model_to_world);
  if (!projection) return fail(projection.error());
  layout.projection_ = *projection;
  model->look_from(layout.projection_);
  layout.range_ = depth_range(layout.projection_, model->bounds());
  layout.model_.push_back(std::move(*model));

  const int width = scene.view.width, height = scene.view.height;
  layout.object_colour_ = make_picture_texture(width, height, nullptr);
  layout.object_depth_ = make_nearest_texture(width, height, GL_DEPTH_COMPONENT, GL_UNSIGNED_INT, nullptr);
  layout.background_colour_ = make_picture_texture(width, height, nullptr);
  auto object = make_framebuffer_of(layout.object_colour_, &layout.object_depth_);
  if (!object) return fail(object.error());
  layout.object_ = std::move(*object);
  auto background = make_framebuffer_of(layout.background_colour_, nullptr);
  if (!background) return fail(background.error());
  layout.background_ = std::move(*background);

  if (auto lit = layout.sky_.update(scene.appearance.light.around, false); !lit) return fail(lit.error());
  auto blit = ScreenPass::blit(picture);
  if (!blit) return fail(blit.error());
  layout.passes_.push_back(std::move(*blit));
  auto compositing = ScreenPass::compositing(layout.object_colour_.name(), layout.object_depth_.name(),
                                             layout.background_colour_.name(), layout.range_, scene, gamma);
  if (!compositing) return fail(compositing.error());
  layout.passes_.push_back(std::move(*compositing));
  return layout;
}

Result<> TwoBufferLayout::draw_object() {
  const double w = projection_.view.width, h = projection_.view.height;
  glBindFramebuffer(GL_FRAMEBUFFER, object_.name());
  glViewport(0, 0, projection_.view.width, projection_.view.height);
  glClearColor(0, 0, 0, 0);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  glFrontFace(GL_CW);  // the picture's top is row 0
  const glm::dmat3 pixel_to_clip{{2.0 / w, 0.0, 0.0}, {0.0, 2.0 / h, 0.0}, {1.0 / w - 1.0, 1.0 / h - 1.0, 1.0}};
  return model_.front().draw(GpuModel::Which::solid, programs_, {"FINAL_COLOUR", "NO_AIR", "LAYOUT_RGB"},
                             units_for_layer(), {}, [&](const Program& program) {
                               set_projection(program, projection_, range_);
                               set_appearance(program, scene_.appearance);
                               sky_.bind(program, units_for_layer().sky);
                               set_airlight(program, "measured", scene_.measured);
                               program.set("pixel_to_clip", pixel_to_clip);
                               program.set("dither_pattern", kDitherUnit);
                             });
}

Result<> TwoBufferLayout::draw(const DrawTarget& target) {
  if (auto drawn = draw_object(); !drawn) return drawn;
  if (auto drawn = passes_.front().draw({background_.name(), target.width, target.height, true}); !drawn) return drawn;
  return passes_.back().draw(target);
}

}  // namespace kasumi
