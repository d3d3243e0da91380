#include "pipeline/lab/bench/gles_passes.hpp"

#include <GLES2/gl2.h>

#include <array>

#include <glm/gtc/type_ptr.hpp>

#include "calib/colour/spectral_sensitivity.hpp"
#include "estimator/air/scattering.hpp"
#include "gles/gl/program.hpp"

namespace kasumi {
namespace {

constexpr double kFarthest_km = 50.0;

constexpr auto kVertex = R"(#version 100
precision highp float;
attribute vec2 position;
uniform vec2 path_scale_km;  // density-weighted kilometres from the left edge to the right: Rayleigh, Mie
uniform vec3 rayleigh_per_km[2];
uniform vec3 mie_per_km[2];
varying vec2 v_place;
varying vec2 v_path_km;
varying vec3 v_thickness_0;
varying vec3 v_thickness_1;
void main() {
  v_place = 0.5 + 0.5 * position;
  v_path_km = path_scale_km * v_place.x;
  v_thickness_0 = rayleigh_per_km[0] * v_path_km.x + mie_per_km[0] * v_path_km.y;
  v_thickness_1 = rayleigh_per_km[1] * v_path_km.x + mie_per_km[1] * v_path_km.y;
  gl_Position = vec4(position, 0.0, 1.0);
}
)";

constexpr auto kPreamble = R"(#version 100
precision highp float;
varying vec2 v_place;
varying vec2 v_path_km;
)";

// Optical thickness is linear in the path, so that it may be interpolated: software GL spends longer on reading 18
// uniforms than on six exponentials.
constexpr auto kInterpolatedNodes = R"(
uniform vec3 weight;  // of node 0; both add up to 1
varying vec3 v_thickness_0;
varying vec3 v_thickness_1;
vec3 attenuation(vec2 path_km) { return mix(exp(-v_thickness_1), exp(-v_thickness_0), weight); }
)";

// Where the path is only known in the fragment.
constexpr auto kNodes = R"(
uniform vec3 weight;
uniform vec3 rayleigh_per_km[2];
uniform vec3 mie_per_km[2];
vec3 attenuation(vec2 path_km) {
  return mix(exp(-(rayleigh_per_km[1] * path_km.x + mie_per_km[1] * path_km.y)),
             exp(-(rayleigh_per_km[0] * path_km.x + mie_per_km[0] * path_km.y)), weight);
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

std::string attenuation_text(GammaBy gamma, const char* two_nodes) {
  if (gamma == GammaBy::two_nodes) return two_nodes;
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
    uniforms.set("weight", haze.weight[0]);
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

}  // namespace

Result<ScreenPass> ScreenPass::build(const std::string& name, const std::string& fragment,
                                     std::vector<unsigned> textures) {
  auto program = link_program(name, kVertex, kPreamble + fragment, {{kPosition, "position"}});
  if (!program) return fail(program.error());
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
  if (auto made = check_gl(name); !made) return fail(made.error());
  return pass;
}

Result<ScreenPass> ScreenPass::blit(unsigned picture) {
  return build("bench blit", kBlit, {picture});
}

Result<ScreenPass> ScreenPass::under_air(unsigned picture, const BenchScene& scene, GammaBy gamma) {
  auto pass = build("bench picture under air", attenuation_text(gamma, kInterpolatedNodes) + kUnderAir, {picture});
  if (!pass) return pass;
  const Uniforms uniforms(pass->program_);
  set_attenuation(uniforms, scene.appearance.haze, gamma);
  uniforms.set("airlight", scene.measured.light.front());
  uniforms.set("path_scale_km", kFarthest_km * density_at(scene.appearance.haze));
  return pass;
}

Result<ScreenPass> ScreenPass::compositing(unsigned object, unsigned depth, unsigned background,
                                           const DepthRange& range, const BenchScene& scene, GammaBy gamma) {
  auto pass = build("bench compositing", attenuation_text(gamma, kNodes) + kCompositing, {object, depth, background});
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

}  // namespace kasumi
