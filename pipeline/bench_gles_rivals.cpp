#include "pipeline/bench_gles_rivals.hpp"

#include <GLES2/gl2.h>

#include <array>

#include <glm/gtc/type_ptr.hpp>

#include "calib/radiometry.hpp"
#include "estimator/scattering.hpp"
#include "gles/airlight.hpp"
#include "gles/appearance.hpp"

namespace kasumi {
namespace {

constexpr double kFarthest_km = 50.0;

constexpr auto kVertex = R"(#version 100
attribute vec2 position;
uniform vec2 path_scale_km;  // density-weighted kilometres from the left edge to the right: Rayleigh, Mie
varying vec2 v_place;
varying vec2 v_path_km;
void main() {
  v_place = 0.5 + 0.5 * position;
  v_path_km = path_scale_km * v_place.x;
  gl_Position = vec4(position, 0.0, 1.0);
}
)";

constexpr auto kPreamble = R"(#version 100
precision highp float;
varying vec2 v_place;
varying vec2 v_path_km;
)";

constexpr auto kTwoNodes = R"(
uniform vec3 weight[2];
uniform vec3 rayleigh_per_km[2];
uniform vec3 mie_per_km[2];
vec3 attenuation(vec2 path_km) {
  return weight[0] * exp(-(rayleigh_per_km[0] * path_km.x + mie_per_km[0] * path_km.y)) +
         weight[1] * exp(-(rayleigh_per_km[1] * path_km.x + mie_per_km[1] * path_km.y));
}
)";

constexpr auto kWavelengths = R"(
uniform vec3 q[WAVELENGTHS];     // each channel's sum is 1
uniform vec2 scattering_per_km;  // at 1 um: Rayleigh, Mie
vec3 attenuation(vec2 path_km) {
  vec2 thickness = scattering_per_km * path_km;
  vec3 sum = vec3(0.0);
  for (int i = 0; i < WAVELENGTHS; ++i) {
    float wavelength_um = 0.38 + 0.4 / float(WAVELENGTHS - 1) * float(i);
    float inverse_square = 1.0 / (wavelength_um * wavelength_um);
    sum += q[i] * exp(-inverse_square * (thickness.x * inverse_square + thickness.y));
  }
  return sum;
}
)";

constexpr auto kBlit = R"(
uniform sampler2D picture_0;
void main() { gl_FragColor = texture2D(picture_0, v_place); }
)";

constexpr auto kUnderAir = R"(
uniform sampler2D picture_0;
uniform vec3 airlight;
void main() {
  vec3 passed = attenuation(v_path_km);
  gl_FragColor = vec4(texture2D(picture_0, v_place).rgb * passed + airlight * (1.0 - passed), 1.0);
}
)";

constexpr auto kCompositing = R"(
uniform sampler2D picture_0;  // object
uniform sampler2D picture_1;  // its depth
uniform sampler2D picture_2;  // background
uniform vec3 airlight;
uniform vec2 near_far_km;
uniform vec2 density;  // along the path: Rayleigh, Mie
void main() {
  float depth = texture2D(picture_1, v_place).r;
  float range_km = near_far_km.x / (1.0 - depth * (1.0 - near_far_km.x / near_far_km.y));
  vec3 passed = attenuation(range_km * density);
  vec3 object = texture2D(picture_0, v_place).rgb * passed + airlight * (1.0 - passed);
  gl_FragColor = vec4(depth < 1.0 ? object : texture2D(picture_2, v_place).rgb, 1.0);
}
)";

int count_of(GammaBy gamma) {
  return gamma == GammaBy::wavelengths_81 ? 81 : 41;
}

std::string attenuation_text(GammaBy gamma) {
  if (gamma == GammaBy::two_nodes) return kTwoNodes;
  return fmt::format("#define WAVELENGTHS {}\n", count_of(gamma)) + kWavelengths;
}

// Uniforms of the program in use.
class Uniforms {
 public:
  explicit Uniforms(const GlProgram& program) : program_(program.name()) { glUseProgram(program_); }
  void set(const char* name, const glm::dvec2& value) const {
    glUniform2fv(place(name), 1, glm::value_ptr(glm::vec2(value)));
  }
  void set(const char* name, const glm::dvec3& value) const { set(name, std::vector{value}); }
  void set(const char* name, const std::vector<glm::dvec3>& values) const {
    const std::vector<glm::vec3> floats(values.begin(), values.end());
    glUniform3fv(place(name), static_cast<GLsizei>(floats.size()), glm::value_ptr(floats.front()));
  }
  void set(const char* name, int value) const { glUniform1i(place(name), value); }

 private:
  GLint place(const char* name) const { return glGetUniformLocation(program_, name); }
  GLuint program_;
};

void set_attenuation(const Uniforms& uniforms, const Haze& haze, GammaBy gamma) {
  constexpr double kPerKm = 1000.0;
  if (gamma == GammaBy::two_nodes) {
    std::vector<glm::dvec3> rayleigh, mie;
    for (const auto& value : haze.rayleigh_per_m) rayleigh.push_back(kPerKm * value);
    for (const auto& value : haze.mie_per_m) mie.push_back(kPerKm * value);
    uniforms.set("weight", std::vector(haze.weight.begin(), haze.weight.end()));
    uniforms.set("rayleigh_per_km", rayleigh);
    uniforms.set("mie_per_km", mie);
    return;
  }
  const auto sensitivity = generic_sensitivity();
  std::vector<glm::dvec3> q;
  glm::dvec3 sum{0.0};
  for (int i = 0; i < count_of(gamma); ++i)
    sum += q.emplace_back(sensitivity.at(380.0 + 400.0 * i / (count_of(gamma) - 1)));
  for (auto& value : q) value /= sum;
  uniforms.set("q", q);
  constexpr auto kModel = ScatteringModel::morales2017;
  uniforms.set("scattering_per_km",
               kPerKm * glm::dvec2{rayleigh_per_m(kModel, 1000.0), mie_per_m(kModel, 1000.0, kBenchTurbidity)});
}

glm::dvec2 density_at(const Haze& haze) {
  return glm::exp(-haze.observer_altitude_m / glm::dvec2{haze.rayleigh_scale_height_m, haze.mie_scale_height_m});
}

Result<GlFramebuffer> make_framebuffer_of(const GlTexture& colour, const GlTexture* depth) {
  GlFramebuffer framebuffer = make_framebuffer();
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, colour.name(), 0);
  if (depth != nullptr) glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depth->name(), 0);
  if (auto complete = check_framebuffer("a buffer of the papers' layout"); !complete)
    return tl::unexpected(complete.error());
  return framebuffer;
}

GlTexture make_nearest_texture(int width, int height, GLenum format, GLenum type, const void* pixels) {
  GlTexture texture = make_texture();
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, texture.name());
  glTexImage2D(GL_TEXTURE_2D, 0, static_cast<GLint>(format), width, height, 0, format, type, pixels);
  for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    glTexParameteri(GL_TEXTURE_2D, filter, GL_NEAREST);
  for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
    glTexParameteri(GL_TEXTURE_2D, wrap, GL_CLAMP_TO_EDGE);
  return texture;
}

}  // namespace

GlTexture make_picture_texture(int width, int height, const void* pixels) {
  return make_nearest_texture(width, height, GL_RGBA, GL_UNSIGNED_BYTE, pixels);
}

Result<ScreenPass> ScreenPass::build(const std::string& name, const std::string& fragment,
                                     std::vector<unsigned> textures) {
  auto program = link_program(name, kVertex, kPreamble + fragment, {{kPosition, "position"}});
  if (!program) return tl::unexpected(program.error());
  ScreenPass pass;
  pass.program_ = std::move(*program);
  pass.textures_ = std::move(textures);
  const Uniforms uniforms(pass.program_);
  for (int i = 0; i < static_cast<int>(pass.textures_.size()); ++i)
    uniforms.set(fmt::format("picture_{}", i).c_str(), i);
  constexpr std::array<float, 8> kCorners{-1, -1, 1, -1, -1, 1, 1, 1};
  pass.square_ = make_buffer();
  glBindBuffer(GL_ARRAY_BUFFER, pass.square_.name());
  glBufferData(GL_ARRAY_BUFFER, sizeof(kCorners), kCorners.data(), GL_STATIC_DRAW);
  if (auto made = check_gl(name); !made) return tl::unexpected(made.error());
  return pass;
}

Result<ScreenPass> ScreenPass::blit(unsigned picture) {
  return build("bench blit", kBlit, {picture});
}

Result<ScreenPass> ScreenPass::under_air(unsigned picture, const BenchScene& scene, GammaBy gamma) {
  auto pass = build("bench picture under air", attenuation_text(gamma) + kUnderAir, {picture});
  if (!pass) return pass;
  const Uniforms uniforms(pass->program_);
  set_attenuation(uniforms, scene.appearance.haze, gamma);
  uniforms.set("airlight", scene.measured.light.front());
  uniforms.set("path_scale_km", kFarthest_km * density_at(scene.appearance.haze));
  return pass;
}

Result<ScreenPass> ScreenPass::compositing(unsigned object, unsigned depth, unsigned background,
                                           const DepthRange& range, const BenchScene& scene, GammaBy gamma) {
  auto pass = build("bench compositing", attenuation_text(gamma) + kCompositing, {object, depth, background});
  if (!pass) return pass;
  const Uniforms uniforms(pass->program_);
  set_attenuation(uniforms, scene.appearance.haze, gamma);
  uniforms.set("airlight", scene.measured.light.front());
  uniforms.set("near_far_km", 0.001 * glm::dvec2{range.near_m, range.far_m});
  uniforms.set("density", density_at(scene.appearance.haze));
  return pass;
}

Result<> ScreenPass::draw(const DrawTarget& target) const {
  glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
  glViewport(0, 0, target.width, target.height);
  glUseProgram(program_.name());
  for (std::size_t i = 0; i < textures_.size(); ++i) {
    glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(i));
    glBindTexture(GL_TEXTURE_2D, textures_[i]);
  }
  glBindBuffer(GL_ARRAY_BUFFER, square_.name());
  glEnableVertexAttribArray(kPosition);
  glVertexAttribPointer(kPosition, 2, GL_FLOAT, GL_FALSE, 0, nullptr);
  glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
  glDisableVertexAttribArray(kPosition);
  return check_gl("a full-screen pass");
}

Result<TwoBufferLayout> TwoBufferLayout::create(const GlInfo& info, unsigned picture, const BenchScene& scene,
                                                GammaBy gamma) {
  if (info.es_major < 3 && !info.has("GL_OES_depth_texture"))
    return fail(FaultKind::unsupported, "{}: no depth textures, which the papers' layout needs", info.renderer);
  TwoBufferLayout layout;
  layout.scene_ = scene;
  std::vector<std::string> notes;
  auto model = GpuModel::upload(scene.facade, info, false, notes);
  if (!model) return tl::unexpected(model.error());
  auto projection = make_projection(scene.view, scene.model_to_world);
  if (!projection) return tl::unexpected(projection.error());
  layout.projection_ = *projection;
  model->look_from(layout.projection_);
  layout.range_ = depth_range(layout.projection_, model->bounds());
  layout.model_.push_back(std::move(*model));

  const int width = scene.view.width, height = scene.view.height;
  layout.object_colour_ = make_picture_texture(width, height, nullptr);
  layout.object_depth_ = make_nearest_texture(width, height, GL_DEPTH_COMPONENT, GL_UNSIGNED_INT, nullptr);
  layout.background_colour_ = make_picture_texture(width, height, nullptr);
  auto object = make_framebuffer_of(layout.object_colour_, &layout.object_depth_);
  if (!object) return tl::unexpected(object.error());
  layout.object_ = std::move(*object);
  auto background = make_framebuffer_of(layout.background_colour_, nullptr);
  if (!background) return tl::unexpected(background.error());
  layout.background_ = std::move(*background);

  auto blit = ScreenPass::blit(picture);
  if (!blit) return tl::unexpected(blit.error());
  layout.passes_.push_back(std::move(*blit));
  auto compositing = ScreenPass::compositing(layout.object_colour_.name(), layout.object_depth_.name(),
                                             layout.background_colour_.name(), layout.range_, scene, gamma);
  if (!compositing) return tl::unexpected(compositing.error());
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
  return model_.front().draw(GpuModel::Which::solid, programs_, {"FINAL_COLOUR", "NO_AIR", "LAYOUT_RGB"}, {},
                             [&](const Program& program) {
                               set_projection(program, projection_, range_);
                               set_appearance(program, scene_.appearance);
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
