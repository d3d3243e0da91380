#include "gles/object/mixed_edges.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "gles/gl/patterns.hpp"
#include "gles/light/airlight_grid.hpp"
#include "gles/picture/camera_pixels.hpp"
#include "gles/picture/response_table.hpp"

// GLSL ES writes its constants without a type.
#pragma GCC diagnostic ignored "-Wpedantic"
#pragma GCC diagnostic ignored "-Wconversion"
#if defined(__clang__)
#pragma GCC diagnostic ignored "-Wimplicit-float-conversion"
#else
#pragma GCC diagnostic ignored "-Wdouble-promotion"
#endif
#pragma GCC diagnostic ignored "-Wfloat-conversion"
#pragma GCC diagnostic ignored "-Wshadow"

namespace kasumi {
namespace {

// As much of GLSL as the text uses.
struct vec2 {
  float x, y;
  vec2() = default;
  constexpr vec2(float both) : x(both), y(both) {}
  constexpr vec2(float a, float b) : x(a), y(b) {}
};
struct vec3 {
  float r, g, b;
  vec3() = default;
  constexpr explicit vec3(float all) : r(all), g(all), b(all) {}
  constexpr vec3(float x, float y, float z) : r(x), g(y), b(z) {}
};
struct LastTwo {
  float others[2], z, w;
  operator vec2() const { return {z, w}; }
};
struct vec4 {
  union {
    struct {
      float x, y, z, w;
    };
    struct {
      float r, g, b, a;
    };
    vec2 xy;
    LastTwo zw;
    vec3 rgb;
  };
  vec4() = default;
  constexpr explicit vec4(float all) : x(all), y(all), z(all), w(all) {}
  constexpr vec4(float a, float b, float c, float d) : x(a), y(b), z(c), w(d) {}
  constexpr vec4(const vec3& v, float d) : x(v.r), y(v.g), z(v.b), w(d) {}
};

#define KASUMI_EACH(op)                                      \
  inline vec2 operator op(vec2 p, vec2 q) {                  \
    return {p.x op q.x, p.y op q.y};                         \
  }                                                          \
  inline vec3 operator op(vec3 p, vec3 q) {                  \
    return {p.r op q.r, p.g op q.g, p.b op q.b};             \
  }                                                          \
  inline vec3 operator op(vec3 p, float q) {                 \
    return {p.r op q, p.g op q, p.b op q};                   \
  }                                                          \
  inline vec3 operator op(float p, vec3 q) {                 \
    return {p op q.r, p op q.g, p op q.b};                   \
  }                                                          \
  inline vec4 operator op(vec4 p, vec4 q) {                  \
    return {p.x op q.x, p.y op q.y, p.z op q.z, p.w op q.w}; \
  }
KASUMI_EACH(+)
KASUMI_EACH(-)
KASUMI_EACH(*)
KASUMI_EACH(/)
#undef KASUMI_EACH
inline vec3& operator*=(vec3& p, vec3 q) {
  return p = p * q;
}
inline vec3& operator*=(vec3& p, float q) {
  return p = p * q;
}
inline vec4& operator+=(vec4& p, vec4 q) {
  return p = p + q;
}

inline float min(float p, float q) {
  return p < q ? p : q;
}
inline float max(float p, float q) {
  return p > q ? p : q;
}
inline float clamp(float p, float low, float high) {
  return min(max(p, low), high);
}
inline float mix(float p, float q, float share) {
  return p * (1.0F - share) + q * share;
}
inline vec2 clamp(vec2 p, vec2 low, vec2 high) {
  return {clamp(p.x, low.x, high.x), clamp(p.y, low.y, high.y)};
}
inline vec3 max(vec3 p, float q) {
  return {max(p.r, q), max(p.g, q), max(p.b, q)};
}
inline vec3 clamp(vec3 p, float low, float high) {
  return {clamp(p.r, low, high), clamp(p.g, low, high), clamp(p.b, low, high)};
}
inline vec3 mix(vec3 p, vec3 q, float share) {
  return {mix(p.r, q.r, share), mix(p.g, q.g, share), mix(p.b, q.b, share)};
}
inline vec3 sqrt(vec3 p) {
  return {std::sqrt(p.r), std::sqrt(p.g), std::sqrt(p.b)};
}
inline float dot(vec3 p, vec3 q) {
  return p.r * q.r + p.g * q.g + p.b * q.b;
}

// Texels in memory, nearest or (`smooth`) filtered, clamped to the edges.
struct sampler2D {
  enum class Texel { luminance, luminance_alpha, rgba } kind = Texel::rgba;
  const void* texels = nullptr;
  int width = 0, height = 0;
  bool smooth = false;
  const vec4* here = nullptr;  // the texel of the pixel that is mixed: no other will be asked for

  vec4 at(int x, int y) const {
    const auto i = static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
    constexpr float kByte = 1.0F / 255.0F;  // as GL reads 8-bit texels
    const auto* bytes = static_cast<const std::uint8_t*>(texels);
    switch (kind) {
      case Texel::luminance: return {vec3(bytes[i] * kByte), 1.0F};
      case Texel::luminance_alpha: return {vec3(bytes[2 * i] * kByte), bytes[2 * i + 1] * kByte};
      case Texel::rgba:
        return {vec3(bytes[4 * i], bytes[4 * i + 1], bytes[4 * i + 2]) * kByte, bytes[4 * i + 3] * kByte};
    }
    return vec4(0.0F);
  }
};
template <class Texel>
sampler2D sampler(sampler2D::Texel kind, const Image<Texel>& image) {
  return {kind, image.elements().data(), image.width(), image.height()};
}

inline vec4 texture2D(const sampler2D& s, vec2 place) {
  if (s.here) return *s.here;
  const float u = place.x * static_cast<float>(s.width), v = place.y * static_cast<float>(s.height);
  const auto held = [](int at, int size) { return std::clamp(at, 0, size - 1); };
  if (s.smooth) {
    const float left = std::floor(u - 0.5F), top = std::floor(v - 0.5F), right = u - 0.5F - left, down = v - 0.5F - top;
    const int x = static_cast<int>(left), y = static_cast<int>(top);
    const auto row = [&](int of) {
      const vec4 a = s.at(held(x, s.width), held(of, s.height)), b = s.at(held(x + 1, s.width), held(of, s.height));
      return a * vec4(1.0F - right) + b * vec4(right);
    };
    return row(y) * vec4(1.0F - down) + row(y + 1) * vec4(down);
  }
  const int x = static_cast<int>(std::floor(u)), y = static_cast<int>(std::floor(v));
  return s.at(held(x, s.width), held(y, s.height));
}

// The light of the camera's pixels in a box, each found when it is first asked for: around a mixed pixel thirteen are.
class LightSeen {
 public:
  explicit LightSeen(const PixelBox& box)
      : box_(box), light_(std::make_unique_for_overwrite<vec3[]>(count())), known_(count(), 0) {}
  template <class Find>
  vec3 at(int x, int y, Find find) {
    if (x < box_.left || x >= box_.right || y < box_.top || y >= box_.bottom) return find();
    const auto i = static_cast<std::size_t>(y - box_.top) * columns() + static_cast<std::size_t>(x - box_.left);
    if (known_[i] == 0) {
      light_[i] = find();
      known_[i] = 1;
    }
    return light_[i];
  }

 private:
  std::size_t columns() const { return static_cast<std::size_t>(box_.right - box_.left); }
  std::size_t count() const { return columns() * static_cast<std::size_t>(box_.bottom - box_.top); }
  PixelBox box_;
  std::unique_ptr<vec3[]> light_;
  std::vector<std::uint8_t> known_;
};

// What the text takes from elsewhere.
struct TextInputs {
  const PictureView* camera_planes = nullptr;
  YuvToRgb camera_matrix;
  const ResponseTables* response_of_camera = nullptr;
  vec4 steps, numbers, object;  // texels of the pixel: of dither, noise and layer
  vec4 gl_FragColor;

  glm::ivec2 pixel_at(vec2 place) const {
    const PictureView& p = *camera_planes;
    const int x = static_cast<int>(place.x * static_cast<float>(p.width));
    const int y = static_cast<int>(place.y * static_cast<float>(p.height));
    return {std::clamp(x, 0, p.width - 1), std::clamp(y, 0, p.height - 1)};
  }
  vec3 camera_at(vec2 place) const {
    const glm::ivec2 pixel = pixel_at(place);
    const glm::vec3 seen = encoded_at(*camera_planes, camera_matrix, pixel.x, pixel.y);
    return {seen.x, seen.y, seen.z};
  }
  float in_table(float at, float row) const {  // as in response.glsl
    const int first = static_cast<int>(row);
    const auto& table =
        response_of_camera->values[static_cast<std::size_t>(first / 4)][static_cast<std::size_t>(first % 4)];
    const float place = clamp(at, 0.0F, 1.0F) * static_cast<float>(kResponseEntries - 1);
    const auto entry = static_cast<std::size_t>(min(place, static_cast<float>(kResponseEntries - 2)));
    return mix(table[entry], table[entry + 1], place - static_cast<float>(entry));
  }
};

// The text twice; what is not there is neutral: no noise, a saturation of 1, a mask that is free.
#define uniform
#define varying
#define const static constexpr
#define main mix_pixel
#define EDGE
#define COVERAGE
#define NOISE
#define SATURATED
#define RESPONSE_TABLE
struct FreeText : TextInputs {  // nothing is in front of the object
#include "picture.frag"
#undef shown
};
#define MATTE
#define MATTE_NODES
#define IN_FRONT
struct OpenText : TextInputs {
  LightSeen* kept_light = nullptr;
  vec3 light_seen(vec2 place) {
    glm::ivec2 pixel = pixel_at(place);  // `const` is the text's
    return kept_light->at(pixel.x, pixel.y, [&] { return light_of(clamp(camera_at(place), 0.0F, 1.0F)); });
  }
#include "picture.frag"
#undef shown
};
#undef uniform
#undef varying
#undef const
#undef main

vec2 two(const glm::dvec2& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y)};
}
vec3 three(const glm::dvec3& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}
vec4 four(const glm::dvec4& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z), static_cast<float>(v.w)};
}

// A texel of a pattern that is repeated over the picture; its sides are powers of 2.
template <class Texel>
const Texel& repeated(const Image<Texel>& pattern, int x, int y) {
  return pattern.at(x & (pattern.width() - 1), y & (pattern.height() - 1));
}
vec4 dither_at(const Image<std::uint8_t>& pattern, int x, int y) {
  return {vec3(static_cast<float>(repeated(pattern, x, y)) * (1.0F / 255.0F)), 1.0F};
}

// The nodes of the matte as matte.frag finds them, behind in the left half, in front in the right one.
Image<glm::u8vec4> nodes_of(const MatteNodes& matte, const OpenText& text, const Image<std::uint8_t>& dither) {
  Image<glm::u8vec4> nodes(2 * matte.columns, matte.rows, glm::u8vec4{0});
  const vec2 size(static_cast<float>(text.camera_planes->width), static_cast<float>(text.camera_planes->height));
  OpenText own = text;
  for (const MatteNode& node : matte.nodes) {
    const glm::dvec2 middle = glm::dvec2(matte.corner_px) + (glm::dvec2(node.at) + 0.5) * double(matte.cell_px) - 0.5;
    for (const bool front : {false, true}) {
      vec3 sum(0.0F);
      float weight = 0.0F;
      for (const auto& tap : front ? node.front : node.clear) {
        if (!tap) continue;
        const double across = tap->x - middle.x, down = tap->y - middle.y;
        const double far = std::sqrt(across * across + down * down) + 1.0;
        const auto share = static_cast<float>(1.0 / (front ? far : far * far));  // the falloffs of matte.cpp
        const vec2 place(static_cast<float>(tap->x) + 0.5F, static_cast<float>(tap->y) + 0.5F);
        sum = sum + share * own.light_of(clamp(own.camera_at(place / size), 0.0F, 1.0F));
        weight += share;
      }
      if (weight <= 0.0F) continue;
      const glm::ivec2 at{node.at.x + (front ? matte.columns : 0), node.at.y};
      const vec4 steps = dither_at(dither, at.x, at.y);
      own.dither_pattern.here = &steps;
      const float step = own.dither({}) / 255.0F;
      const vec3 root = sqrt(sum / weight);
      const auto byte = [&](float value) {
        return static_cast<std::uint8_t>(static_cast<int>(255.0F * clamp(value + step, 0.0F, 1.0F) + 0.5F));
      };
      nodes.at(at.x, at.y) = {byte(root.r), byte(root.g), byte(root.b), 255};
    }
  }
  return nodes;
}

}  // namespace

ResponseTables::ResponseTables(const ResponseCurve& given) {
  ResponseCurve response = given;
  if (given.kind != ResponseCurve::Kind::table) {
    constexpr int kEntries = 4 * (kResponseEntries - 1) + 1;  // 4 between two entries of the texture
    for (auto& table : response.light) {
      table.clear();
      for (int i = 0; i < kEntries; ++i) {
        const double code = static_cast<double>(i) / (kEntries - 1);
        const bool linear = given.kind == ResponseCurve::Kind::linear;
        const double srgb = code <= 0.04045 ? code / 12.92 : std::pow((code + 0.055) / 1.055, 2.4);
        table.push_back(linear ? code : srgb);
      }
    }
  }
  const auto texels = response_texels(response);
  for (std::size_t way = 0; way < 2; ++way)
    for (std::size_t c = 0; c < 3; ++c) {
      auto& table = values[way][c];
      table.resize(kResponseEntries);
      const glm::u8vec4* row = texels.row(static_cast<int>(4 * way + c));
      for (std::size_t i = 0; i < table.size(); ++i) {
        const bool last = i + 1 == table.size();  // it is only there as the one before's successor
        const glm::u8vec4 t = row[last ? i - 1 : i];
        table[i] = static_cast<float>(last ? 256 * t.z + t.w : 256 * t.x + t.y) / 65535.0F;
      }
    }
}

namespace {

template <class Text>
void mix_all(Text& text, const EdgeInputs& in, const std::vector<PixelBox>& rectangles, glm::ivec2 first,
             Image<glm::u8vec4>& mixed) {
  const int width = in.camera.width, height = in.camera.height;
  text.camera_planes = &in.camera;
  text.camera_matrix = yuv_to_rgb(in.camera.encoding);
  text.response_of_camera = &in.response;
  text.saturation = static_cast<float>(in.measured.saturation);
  text.noise_shot = three(in.noise.shot);
  text.noise_read2 = three(in.noise.read * in.noise.read);
  const glm::ivec2 noise_first = noise_start(in.noise.pattern % kNoisePatterns);
  text.dither_pattern.here = &text.steps;
  text.noise_pattern.here = &text.numbers;
  text.layer.here = &text.object;
  const PixelBox& box = in.layer.box;
  for (const PixelBox& part : rectangles)
    for (int y = part.top; y < part.bottom; ++y) {
      const AirlightRow airlight(in.measured, y);
      for (int x = part.left; x < part.right; ++x) {
        const glm::vec4& texel = in.layer.texels.at(x - box.left, y - box.top);
        if (texel.a <= 0.0F) continue;
        text.object = {texel.r, texel.g, texel.b, texel.a};
        text.steps = dither_at(in.patterns.dither, x, y);
        const glm::vec3 noise =
            glm::vec3(repeated(*in.patterns.noise, x + noise_first.x, y + noise_first.y)) * (1.0F / 255.0F);
        text.numbers = {vec3(noise.x, noise.y, noise.z), 1.0F};
        text.v_picture = {(static_cast<float>(x) + 0.5F) / static_cast<float>(width),
                          (static_cast<float>(y) + 0.5F) / static_cast<float>(height)};
        text.v_airlight_root = sqrt(three(airlight.at(x) * in.layer.unit));
        text.mix_pixel();
        const vec4& seen = text.gl_FragColor;
        if (seen.a <= 0.0F) continue;
        const auto byte = [](float value) {
          return static_cast<std::uint8_t>(static_cast<int>(255.0F * clamp(value, 0.0F, 1.0F) + 0.5F));
        };
        mixed.at(x - first.x, y - first.y) = {byte(seen.r), byte(seen.g), byte(seen.b),
                                              std::max<std::uint8_t>(byte(seen.a), 1)};
      }
    }
}

}  // namespace

void mix_edges(const EdgeInputs& in, const std::vector<PixelBox>& rectangles, glm::ivec2 first,
               Image<glm::u8vec4>& mixed) {
  if (!in.foreground && !in.passers) {
    FreeText text;
    return mix_all(text, in, rectangles, first, mixed);
  }
  OpenText text;
  constexpr std::uint8_t kAll = 255;  // of a mask
  const Image<std::uint8_t> free(1, 1, kAll);
  text.foreground = in.foreground ? sampler(sampler2D::Texel::luminance_alpha, *in.foreground)
                                  : sampler(sampler2D::Texel::luminance, free);
  const Image<glm::u8vec4> nobody(1, 1, glm::u8vec4{0, 0, 0, kAll});
  text.in_front = sampler(sampler2D::Texel::rgba, in.passers ? in.passers->pixels : nobody);
  const glm::dvec2 size(in.camera.width, in.camera.height);
  const glm::dvec2 passers_size(text.in_front.width, text.in_front.height);
  const glm::dvec2 passers_first = in.passers ? glm::dvec2(in.passers->left, in.passers->top) : glm::dvec2(0.0);
  text.in_front_place = four({size / passers_size, -passers_first / passers_size});
  Image<glm::u8vec4> nodes(1, 1, glm::u8vec4{0});
  text.pixel_step = two(1.0 / size);
  text.matte_place = vec4(0.0F);
  text.matte_last = text.matte_half = vec2(0.5F);
  if (in.matte) {
    text.camera_planes = &in.camera;
    text.camera_matrix = yuv_to_rgb(in.camera.encoding);
    text.response_of_camera = &in.response;
    nodes = nodes_of(*in.matte, text, in.patterns.dither);
    const glm::dvec2 count{in.matte->columns, in.matte->rows}, cells = count * double(in.matte->cell_px);
    text.matte_place = four({size / cells, -glm::dvec2(in.matte->corner_px) / cells});
    text.matte_half = two(0.5 / count);
    text.matte_last = two(1.0 - 0.5 / count);
  }
  text.matte_nodes = sampler(sampler2D::Texel::rgba, nodes);
  text.matte_nodes.smooth = true;
  LightSeen kept_light(in.layer.box);
  text.kept_light = &kept_light;
  mix_all(text, in, rectangles, first, mixed);
}

}  // namespace kasumi
