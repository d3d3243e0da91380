#include "gles/shadow/sun_shadow.hpp"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "gles/gl/depth.hpp"
#include "gles/gl/gl.hpp"
#include "gles/gl/texture_units.hpp"

namespace kasumi {
namespace {

constexpr int kMapsPerSide = 4;
static_assert(kMapsPerSide * kMapsPerSide == kSunPoints);
constexpr int kMinTexels = 256, kMaxTexels = 1024, kStep_texels = 64;
constexpr double kBorder_texels = 3.0;   // margin around the object
constexpr double kDepthBorder = 0.01;    // depth margin in front and behind
constexpr double kStepOff_texels = 0.6;  // see sun_shadow.glsl
constexpr double kSteepest = 60.0;       // tangent: a sun 1 degree above a surface lights it by a sixtieth

constexpr double kMargin_texels = 0.05;  // of depth, when two are compared

// A step of 16 bits must be well below what depths are compared by.
bool enough_in_16_bits(const SunFrame& frame) {
  return kMargin_texels * frame.texel_m / frame.depth_m >= 2.0 / 65536.0;
}

GlTexture make_maps(const SunFrame& frame, bool packed, const GlInfo& info) {
  const int side = kMapsPerSide * frame.texels;
  const bool short_depth = enough_in_16_bits(frame);
  const auto sized = short_depth ? GL_DEPTH_COMPONENT16 : GL_DEPTH_COMPONENT24_OES;
  GlTexture texture = make_texture();
  glBindTexture(GL_TEXTURE_2D, texture.name());
  if (packed)
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA, side, side, 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
  else
    glTexImage2D(GL_TEXTURE_2D, 0, info.es_major >= 3 ? sized : GL_DEPTH_COMPONENT, side, side, 0, GL_DEPTH_COMPONENT,
                 short_depth ? GL_UNSIGNED_SHORT : GL_UNSIGNED_INT, nullptr);
  set_filter(TextureFilter::nearest);
  clamp_to_edge();
  return texture;
}

void set_frame(const Program& program, const SunFrame& frame) {
  program.set("sun_from_model", frame.from_model);
  program.set("sun_spread", frame.spread);
  program.set("sun_map_texels", static_cast<double>(frame.texels));
}

}  // namespace

SunFrame make_sun_frame(const ModelBounds& bounds, const glm::dmat4& model_to_world, const glm::dvec3& sun,
                        int texels) {
  // The x axis is horizontal, so that vertical walls stay vertical in the maps.
  const glm::dvec3 level = glm::cross(glm::dvec3{0, 0, 1}, sun);
  const glm::dvec3 across = glm::length(level) > 1e-3 ? glm::normalize(level) : glm::dvec3{1, 0, 0};
  const glm::dmat3 turn = glm::transpose(glm::dmat3{across, glm::normalize(glm::cross(sun, across)), -sun});
  glm::dvec3 lowest{1e300}, highest{-1e300};
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 at{corner & 1 ? bounds.highest.x : bounds.lowest.x,
                        corner & 2 ? bounds.highest.y : bounds.lowest.y,
                        corner & 4 ? bounds.highest.z : bounds.lowest.z};
    const glm::dvec3 in_sun_frame = turn * glm::dvec3(model_to_world * glm::dvec4(at, 1.0));
    lowest = glm::min(lowest, in_sun_frame);
    highest = glm::max(highest, in_sun_frame);
  }
  SunFrame frame;
  frame.texels = texels;
  frame.depth_m = std::max(highest.z - lowest.z, 0.1) / (1.0 - 2.0 * kDepthBorder);
  const double moved_m = std::tan(kSunRadius.value) * frame.depth_m;
  const glm::dvec2 size = glm::max(glm::dvec2(highest - lowest), glm::dvec2{0.1}) + moved_m;
  const glm::dvec2 texel = size / (texels - 2.0 * kBorder_texels);
  frame.texel_m = std::max(texel.x, texel.y);
  frame.spread = moved_m / texel;
  const glm::dvec3 unit{1.0 / texel.x, 1.0 / texel.y, 1.0 / frame.depth_m};
  const glm::dvec3 middle = 0.5 * (lowest + highest) - glm::dvec3{0.0, 0.0, 0.5 * frame.depth_m};
  const auto scaled = [](const glm::dvec3& by) {
    return glm::dmat3{{by.x, 0.0, 0.0}, {0.0, by.y, 0.0}, {0.0, 0.0, by.z}};
  };
  frame.from_world = scaled(unit) * turn;
  frame.from_normal = scaled(1.0 / unit) * turn;
  glm::dmat4 from_world(frame.from_world);
  from_world[3] = glm::dvec4(-unit * middle, 1.0);
  frame.from_model = from_world * model_to_world;
  return frame;
}

SunShadow::Options SunShadow::options_for(const GlInfo& info, const Options& asked) {
  return {asked.packed || !(info.es_major >= 3 || info.has("GL_OES_depth_texture")),
          asked.face_slopes && info.has("GL_OES_standard_derivatives")};
}

int SunShadow::texels_for(const GpuModel& model, const Projection& projection, const GlInfo& info,
                          const Options& options) {
  const glm::dvec3 size(model.bounds().highest - model.bounds().lowest);
  const double across_m = glm::length(glm::dmat3(projection.model_to_world) * size);
  const double pixel_m =
      depth_range(projection, model.bounds()).near_m / std::max(projection.view.focal_px.x, projection.view.focal_px.y);
  int most = options.packed ? kMaxTexels / 2 : kMaxTexels;
  while (kMapsPerSide * most > info.max_texture_size) most /= 2;
  const double wanted = std::clamp(across_m / pixel_m, 1.0 * kMinTexels, 1.0 * kMaxTexels);
  return std::min(most, kStep_texels * static_cast<int>(std::ceil(wanted / kStep_texels)));
}

Result<SunShadow> SunShadow::draw(const GpuModel& model, const SunFrame& frame, const Options& options,
                                  const GlInfo& info, Programs& programs) {
  auto drawing = SunShadowDrawing::begin(model, frame, options, info, programs);
  if (!drawing) return fail(drawing.error());
  for (;;) {
    const auto whole = drawing->step();
    if (!whole) return fail(whole.error());
    if (*whole) return drawing->take();
  }
}

Result<SunShadowDrawing> SunShadowDrawing::begin(const GpuModel& model, const SunFrame& frame,
                                                 const SunShadow::Options& options, const GlInfo& info,
                                                 Programs& programs) {
  SunShadowDrawing drawing(model, programs);
  drawing.made_.frame_ = frame;
  drawing.made_.options_ = options;
  glActiveTexture(GL_TEXTURE0 + kPlaneUnit);  // no other texture is in use here
  drawing.made_.maps_ = make_maps(frame, options.packed, info);
  drawing.framebuffer_ = make_framebuffer();
  glBindFramebuffer(GL_FRAMEBUFFER, drawing.framebuffer_.name());
  glFramebufferTexture2D(GL_FRAMEBUFFER, options.packed ? GL_COLOR_ATTACHMENT0 : GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D,
                         drawing.made_.maps_.name(), 0);
  if (options.packed) {
    drawing.depth_ = make_renderbuffer();
    glBindRenderbuffer(GL_RENDERBUFFER, drawing.depth_.name());
    const int side = kMapsPerSide * frame.texels;
    glRenderbufferStorage(GL_RENDERBUFFER, depth_format(info), side, side);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, drawing.depth_.name());
  }
  if (auto complete = check_framebuffer("the maps of the sun's shadow"); !complete) return fail(complete.error());
  glClearColor(1, 1, 1, 1);
  glDepthMask(GL_TRUE);
  glClear(GL_DEPTH_BUFFER_BIT | (options.packed ? GL_COLOR_BUFFER_BIT : 0u));
  return drawing;
}

Result<bool> SunShadowDrawing::step() {
  const SunFrame& frame = made_.frame_;
  const int number = drawn_++;
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.name());
  glViewport(number % kMapsPerSide * frame.texels, number / kMapsPerSide * frame.texels, frame.texels, frame.texels);
  const auto drawn = model_->draw_shadow(*programs_, made_.options_.packed ? Defines{"PACKED_DEPTH"} : Defines{},
                                         [&](const Program& program) {
                                           set_frame(program, frame);
                                           program.set("map_number", static_cast<double>(number));
                                         });
  if (!drawn) return fail(drawn.error());
  if (auto sound = check_gl("drawing the sun's shadow"); !sound) return fail(sound.error());
  return drawn_ == kSunPoints;
}

Defines SunShadow::defines() const {
  Defines defines{"SUN_SHADOW"};
  if (options_.packed) defines.insert("PACKED_DEPTH");
  if (options_.face_slopes) defines.insert("FACE_SLOPES");
  return defines;
}

void SunShadow::bind(const Program& program, int unit) const {
  glActiveTexture(GL_TEXTURE0 + static_cast<unsigned>(unit));
  glBindTexture(GL_TEXTURE_2D, maps_.name());
  program.set("sun_maps", unit);
  set_frame(program, frame_);
  program.set("sun_from_world", frame_.from_world);
  program.set("sun_from_normal", frame_.from_normal);
  program.set("step_off_m", kStepOff_texels * frame_.texel_m);
  program.set("steepest", kSteepest * frame_.texel_m / frame_.depth_m);
  program.set("depth_margin", kMargin_texels * frame_.texel_m / frame_.depth_m);
}

}  // namespace kasumi
