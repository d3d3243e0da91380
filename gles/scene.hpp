// The renderer's inputs and results as plain numbers, independent of cameras and solvers. Light is linear, in any unit
// common to all fields of one struct.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include <glm/gtc/type_precision.hpp>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "base/image.hpp"
#include "base/result.hpp"
#include "base/sky/light_around.hpp"

namespace kasumi {

class ImageDevice;
struct GlInfo;

// Who mixes the camera's picture and the object's layer into what is shown.
enum class Mixing {
  automatic,  // the processor where GL is software, else the GPU
  gpu,
  processor,
};

struct RendererOptions {
  Mixing mixing = Mixing::gpu;
  bool force_rgba8 = false;             // keep the layer in 8 bits (square roots) even if the driver has half floats
  bool force_encoded_textures = false;  // decode sRGB after filtering even if the driver has sRGB textures
  bool force_packed_shadows = false;    // shadow map depth in bytes even if the driver has depth textures
  bool force_smooth_shadows = false;    // shadow slopes from normals even if the driver has face derivatives
  bool force_promised_units = false;    // no more texture units than GLES 2 promises while the picture is drawn
  bool import_on_software = false;      // also import with software GL, which may crash on mapping the memory
  std::function<Result<std::unique_ptr<ImageDevice>>(const GlInfo&)> image_device{};  // instead of EGL's, for tests
};

// The scene camera's position and lens. Pixel coordinates: the centre of the top left pixel is (0, 0).
struct SceneView {
  int width = 0;
  int height = 0;
  glm::dvec2 focal_px{};
  glm::dvec2 centre_px{};
  std::array<double, 5> distortion{};  // Brown: k1 k2 p1 p2 k3
  glm::dmat4 world_to_camera{
      1.0};  // world: metres east, north, up of the camera's site; camera: x right, y down, z forward
  double near_m = 100.0;
  double far_m = 100e3;
};

// Attenuation by two Gauss nodes per channel (physics 4):
//   Gamma_c = sum over k of weight[k][c] exp(-rayleigh_per_m[k][c] s_R - mie_per_m[k][c] s_M)
// where s_R and s_M are the path's lengths weighted by density (scale heights below, altitudes above sea level), exact
// for slanted paths.
// Fog adds its own optical depth to every node: fog_per_m times the length weighted by exp(-(altitude - base) / scale
// height).
constexpr int kHazeNodes = 2;
struct Haze {
  std::array<glm::dvec3, kHazeNodes> weight{};
  std::array<glm::dvec3, kHazeNodes> rayleigh_per_m{};  // at sea level
  std::array<glm::dvec3, kHazeNodes> mie_per_m{};       // at sea level
  double rayleigh_scale_height_m = 7994.0;
  double mie_scale_height_m = 1200.0;
  double observer_altitude_m = 0.0;
  double fog_per_m = 0.0;  // at the fog's base, grey; 0: none
  double fog_base_altitude_m = 0.0;
  double fog_scale_height_m = 30.0;
};

// The light on the object, in the scene camera's channels.
struct ObjectLight {
  glm::dvec3 sun_direction{0, 0, 1};   // towards the sun, world frame
  glm::dvec3 sun_irradiance{0};        // on a surface facing the sun
  glm::dmat3 albedo_to_channels{1.0};  // linear sRGB reflectance of the model to reflectance in these channels; what
                                       // leaves 0..1 is clamped
  LightAround around;                  // radiance of sky and ground, without the sun's disc
};

// Light from infinity over the object's part of the picture, on a grid; bilinear between its points and clamped beyond
// its edges.
struct AirlightGrid {
  static constexpr int kColumns = 8;
  static constexpr int kRows = 3;
  glm::dvec2 first_px{};  // pixel of point (0, 0)
  glm::dvec2 last_px{};   // pixel of point (kColumns - 1, kRows - 1)
  std::array<glm::dvec3, kColumns * kRows> light{};
  // Of measured light: it is given without the camera's saturation (calib/colour/camera_saturation), and what is drawn in it
  // gets that. 1: the camera leaves colours as they are.
  double saturation = 1.0;
  bool saturates() const { return saturation != 1.0; }
};

// The share of the sun's light that reaches the real ground, as it lies in the camera's picture, 0..1: bilinear between
// points, clamped beyond its edges.
struct GroundSunlight {
  glm::dvec2 first_px{};  // pixel of point (0, 0)
  double step_px = 1.0;   // between points
  Image<float> share;     // not empty
};

// The share of the sky's light that the object leaves to the ground around it, 0..1, over the world's east and north:
// bilinear between points, clamped beyond its edges, which hold 1.
struct FootShade {
  glm::dvec2 first_m{};  // of point (0, 0)
  glm::dvec2 step_m{1.0};
  Image<float> sky_seen;  // not empty
};

// The object's appearance before the camera's exposure.
struct ObjectAppearance {
  Haze haze;
  ObjectLight light;
  AirlightGrid horizon;            // the sky model's light from infinity, in the unit of `light`; > 0
  bool aerial_perspective = true;  // false: without air in between, for the "before" picture
  bool shadows = false;            // the object's sun shadow on itself and on the model's ground
  std::shared_ptr<const GroundSunlight> ground_sunlight{};  // null: the sun reaches all of the ground
  std::shared_ptr<const FootShade> foot_shade{};            // null: the object hides no sky from the ground
};

// How the camera's optics and pixel format limit detail; applied to the object too.
struct ObjectDetail {
  double point_spread_px = 0.0;  // standard deviation of a Gaussian, pixels of the camera's picture; 0: none
  int chroma_columns = 1;        // pixels per chroma sample, from the picture's corner: 2 x 2 for
  int chroma_rows = 1;           // 4:2:0, 2 x 1 for 4:2:2
  double sharpening = 0.0;       // 0 .. kStrongestSharpening; see CameraProcessing
  bool jpeg_blocks = false;      // round the object's pixels as the camera's JPEG rounds its own
  friend bool operator==(const ObjectDetail&, const ObjectDetail&) = default;
};
constexpr double kWidestPointSpread_px = 3.0;
constexpr double kStrongestSharpening = 3.0;

// The camera's noise: the variance of linear light L (full scale = 1) is shot L + read^2, per channel.
constexpr std::uint32_t kNoisePatterns = 4;  // in turn; their repetition is not visible
struct SensorNoise {
  glm::dvec3 shot{0.0};
  glm::dvec3 read{0.0};
  std::uint32_t pattern = 0;  // selects a frame's noise: the same number modulo kNoisePatterns gives the same noise
  bool none() const { return shot == glm::dvec3{0.0} && read == glm::dvec3{0.0}; }
};

// Encoded value (0..1) to linear light (0..1), strictly increasing, evenly spaced, per channel; at least 2 entries. The
// display shows the camera's own encoding, so pixels without the object pass unchanged.
struct ResponseCurve {
  enum class Kind { linear, srgb, table } kind = Kind::srgb;
  std::array<std::vector<double>, 3> light;
};

// Pixels [left, right) x [top, bottom) of the camera's picture.
struct PixelBox {
  int left = 0;
  int top = 0;
  int right = 0;
  int bottom = 0;
  bool empty() const { return right <= left || bottom <= top; }
  friend bool operator==(const PixelBox&, const PixelBox&) = default;
};

// What passes before the object in one picture of the camera: pixels from `left`, `top` on; around them nothing does.
struct InFront {
  int left = 0;
  int top = 0;
  // r, g, b: what is behind, as the camera encodes it; a: the share of the pixel that stays free, 255: all. The
  // outermost pixels are free.
  Image<glm::u8vec4> pixels;
};

enum class HazeDetail { per_vertex, per_fragment };  // where attenuation is computed

// How many camera pictures reached the GPU in which way.
struct FrameCounts {
  std::uint64_t uploaded = 0;  // copied, once each
  std::uint64_t imported = 0;  // not copied
};

}  // namespace kasumi
