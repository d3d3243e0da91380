#include "gles/composite/mixed_edges.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

#include "gles/gl/patterns.hpp"
#include "gles/light/airlight_grid.hpp"
#include "gles/picture/encoded_eight.hpp"
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

// As much of GLSL as the text uses, for eight pixels at a time: a `lanes` is its float, a `flags` its bool.
struct flags {
  Integers set;
};
struct lanes {
  Floats of;
  lanes() = default;
  constexpr lanes(Floats all) : of(all) {}
  constexpr lanes(double all) : lanes(static_cast<float>(all), 0) {}

 private:
  constexpr lanes(float all, int) : of{all, all, all, all, all, all, all, all} {}
};
struct vec2 {
  lanes x, y;
  vec2() = default;
  constexpr vec2(lanes both) : x(both), y(both) {}
  constexpr vec2(double both) : vec2(lanes(both)) {}
  constexpr vec2(lanes a, lanes b) : x(a), y(b) {}
};
struct vec3 {
  lanes r, g, b;
  vec3() = default;
  constexpr explicit vec3(lanes all) : r(all), g(all), b(all) {}
  constexpr vec3(lanes x, lanes y, lanes z) : r(x), g(y), b(z) {}
};
struct vec4 {
  union {
    lanes x, r;
  };
  union {
    lanes y, g;
  };
  union {
    lanes z, b;
  };
  union {
    lanes w, a;
  };
  vec2 first_two() const { return {x, y}; }
  vec2 last_two() const { return {z, w}; }
  vec3 first_three() const { return {x, y, z}; }
  vec4() = default;
  constexpr explicit vec4(lanes all) : x(all), y(all), z(all), w(all) {}
  constexpr vec4(lanes a, lanes b, lanes c, lanes d) : x(a), y(b), z(c), w(d) {}
  constexpr vec4(const vec3& v, lanes d) : x(v.r), y(v.g), z(v.b), w(d) {}
};

#define KASUMI_EACH(op)                                      \
  inline lanes operator op(lanes p, lanes q) {               \
    return p.of op q.of;                                     \
  }                                                          \
  inline vec2 operator op(vec2 p, vec2 q) {                  \
    return {p.x op q.x, p.y op q.y};                         \
  }                                                          \
  inline vec3 operator op(vec3 p, vec3 q) {                  \
    return {p.r op q.r, p.g op q.g, p.b op q.b};             \
  }                                                          \
  inline vec3 operator op(vec3 p, lanes q) {                 \
    return {p.r op q, p.g op q, p.b op q};                   \
  }                                                          \
  inline vec3 operator op(lanes p, vec3 q) {                 \
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
inline vec3& operator*=(vec3& p, lanes q) {
  return p = p * q;
}
inline lanes& operator*=(lanes& p, lanes q) {
  return p = p * q;
}
inline vec4& operator+=(vec4& p, vec4 q) {
  return p = p + q;
}

inline flags operator<(lanes p, lanes q) {
  return {p.of < q.of};
}
inline flags operator>(lanes p, lanes q) {
  return {p.of > q.of};
}
inline flags operator&&(flags p, flags q) {
  return {p.set & q.set};
}
inline bool any(flags f) {
  Integers all = f.set;
  std::int32_t sum = 0;
  for (std::size_t i = 0; i < kLanes; ++i) sum |= all[i];
  return sum != 0;
}
inline lanes either(flags f, lanes yes, lanes no) {
  return f.set ? yes.of : no.of;
}
inline vec3 either(flags f, vec3 yes, vec3 no) {
  return {either(f, yes.r, no.r), either(f, yes.g, no.g), either(f, yes.b, no.b)};
}

inline lanes min(lanes p, lanes q) {
  return either(p < q, p, q);
}
inline lanes max(lanes p, lanes q) {
  return either(p > q, p, q);
}
inline lanes clamp(lanes p, lanes low, lanes high) {
  return min(max(p, low), high);
}
inline lanes mix(lanes p, lanes q, lanes share) {
  return p * (1.0 - share) + q * share;
}
inline vec3 max(vec3 p, lanes q) {
  return {max(p.r, q), max(p.g, q), max(p.b, q)};
}
inline vec3 clamp(vec3 p, lanes low, lanes high) {
  return {clamp(p.r, low, high), clamp(p.g, low, high), clamp(p.b, low, high)};
}
inline vec3 mix(vec3 p, vec3 q, lanes share) {
  return {mix(p.r, q.r, share), mix(p.g, q.g, share), mix(p.b, q.b, share)};
}
inline lanes sqrt(lanes p) {
  float values[kLanes];
  std::memcpy(values, &p, sizeof p);
  for (float& value : values) value = std::sqrt(value);
  return loaded<Floats>(values);
}
inline vec3 sqrt(vec3 p) {
  return {sqrt(p.r), sqrt(p.g), sqrt(p.b)};
}
inline lanes dot(vec3 p, vec3 q) {
  return p.r * q.r + p.g * q.g + p.b * q.b;
}

// The texel of each of the pixels that are mixed: no other will be asked for.
struct sampler2D {
  const vec4* here = nullptr;
};
inline const vec4& texture2D(const sampler2D& s, vec2) {
  return *s.here;
}

// What the text takes from elsewhere.
struct TextInputs {
  const ResponseTables* response_of_camera = nullptr;
  vec4 steps, numbers, object;  // texels of dither, noise and layer
  vec3 seen_by_camera;
  vec4 gl_FragColor;

  const vec3& camera_at(vec2) const { return seen_by_camera; }
  lanes in_table(lanes at, double row) const {  // as in response.glsl
    const int first = static_cast<int>(row);
    const float* table =
        response_of_camera->values[static_cast<std::size_t>(first / 4)][static_cast<std::size_t>(first % 4)].data();
    const lanes place = clamp(at, 0.0, 1.0) * double(kResponseEntries - 1);
    const Integers entry = __builtin_convertvector(min(place, double(kResponseEntries - 2)).of, Integers);
    const auto found = [&](const float* from) {
      return Floats{from[entry[0]], from[entry[1]], from[entry[2]], from[entry[3]],
                    from[entry[4]], from[entry[5]], from[entry[6]], from[entry[7]]};
    };
    return mix(found(table), found(table + 1), place - lanes(__builtin_convertvector(entry, Floats)));
  }
};

// ... where something is in front of the object.
struct OpenInputs : TextInputs {
  const float* light_here = nullptr;  // red of the first of the pixels
  std::ptrdiff_t light_row = 0, light_plane = 0;
  vec3 light_seen(vec2, vec2 pixels_away) const {
    const float* there =
        light_here + static_cast<int>(pixels_away.y.of[0]) * light_row + static_cast<int>(pixels_away.x.of[0]);
    return {loaded<Floats>(there), loaded<Floats>(there + light_plane), loaded<Floats>(there + 2 * light_plane)};
  }

  const float* node_lines = nullptr;  // of both kinds, four channels each, in the row that is mixed; null: no nodes
  std::ptrdiff_t columns = 0;
  std::array<std::ptrdiff_t, 2> nodes_before{};  // of the first four pixels and of the others
  lanes from_before;                             // how far from it to the next
  vec4 nodes_at(vec2, double kind) const {
    if (!node_lines) return vec4(0.0);
    const float* line = node_lines + static_cast<std::ptrdiff_t>(4.0 * kind) * columns;
    const auto channel = [&](std::ptrdiff_t c) {
      const float *a = line + c * columns + nodes_before[0], *b = line + c * columns + nodes_before[1];
      return mix(Floats{a[0], a[0], a[0], a[0], b[0], b[0], b[0], b[0]},
                 Floats{a[1], a[1], a[1], a[1], b[1], b[1], b[1], b[1]}, from_before);
    };
    return {channel(0), channel(1), channel(2), channel(3)};
  }
};

// The text twice; what is not there is neutral: no noise, a saturation of 1, a mask that is free.
#define uniform
#define varying
#define const static constexpr
#define float lanes
#define bool flags
#define xy first_two()
#define zw last_two()
#define rgb first_three()
#define ANY any
#define EITHER either
#define main mix_pixels
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
struct OpenText : OpenInputs {
#include "picture.frag"
#undef shown
};
#undef uniform
#undef varying
#undef const
#undef float
#undef bool
#undef xy
#undef zw
#undef rgb
#undef ANY
#undef EITHER
#undef main

constexpr float kByte = 1.0F / 255.0F;  // as GL reads 8-bit texels
// Of the eight pixels.
constexpr Floats kOrder{0, 1, 2, 3, 4, 5, 6, 7};

vec3 three(const glm::dvec3& v) {
  return {v.x, v.y, v.z};
}
vec3 three(const std::array<Floats, 3>& of) {
  return {of[0], of[1], of[2]};
}
Integers bytes_of(lanes value) {
  return __builtin_convertvector((255.0 * clamp(value, 0.0, 1.0) + 0.5).of, Integers);
}
template <class Find>
lanes each(Find find) {
  return Floats{find(0), find(1), find(2), find(3), find(4), find(5), find(6), find(7)};
}
lanes shares_of(const std::array<std::uint8_t, kLanes>& bytes) {
  return each([&](int i) { return static_cast<float>(bytes[static_cast<std::size_t>(i)]) * kByte; });
}

// A texel of a pattern that is repeated over the picture; its sides are powers of 2.
template <class Texel>
const Texel& repeated(const Image<Texel>& pattern, int x, int y) {
  return pattern.at(x & (pattern.width() - 1), y & (pattern.height() - 1));
}

// The light around mixed pixels, and the nodes as matte.frag finds them.
void follow_matte(OpenText& text, const EdgeInputs& in, const MatteBand& band, MatteLight& kept) {
  const EncodedEight camera(in.camera);
  const std::size_t columns = static_cast<std::size_t>(band.box.right - band.box.left);
  const std::size_t plane = columns * static_cast<std::size_t>(band.box.bottom - band.box.top);
  kept.light.resize(3 * plane + 2 * kLanes);
  float* first = kept.light.data() + kLanes;
  for (const MatteBand::Run& run : band.runs) {
    float* to = first + static_cast<std::size_t>(run.y - band.box.top) * columns - band.box.left;
    for (int x = run.left; x < run.right; x += kEight) {
      const vec3 light = text.light_of(clamp(three(camera.at(x, run.y)), 0.0, 1.0));
      std::memcpy(to + x, &light.r, sizeof light.r);
      std::memcpy(to + x + plane, &light.g, sizeof light.g);
      std::memcpy(to + x + 2 * plane, &light.b, sizeof light.b);
    }
  }
  const std::size_t nodes = static_cast<std::size_t>(band.columns) * static_cast<std::size_t>(band.rows);
  kept.nodes.assign(8 * nodes, 0.0F);
  for (const MatteBand::Node& node : band.nodes) {
    float sum[3]{}, weight = 0.0F;
    for (std::uint32_t i = node.first_tap; i < node.last_tap; ++i) {
      const MatteBand::Tap& tap = band.taps[i];
      for (std::size_t c = 0; c < 3; ++c) sum[c] += tap.weight * first[c * plane + tap.at];
      weight += tap.weight;
    }
    const bool front = node.at.x >= band.columns;
    const auto at = static_cast<std::size_t>(node.at.y * band.columns + node.at.x - (front ? band.columns : 0));
    const float step = (static_cast<float>(repeated(in.patterns.dither, node.at.x, node.at.y)) / 256.0F - 0.5F) * kByte;
    float* to = kept.nodes.data() + (front ? 4 * nodes : 0) + at;
    for (std::size_t c = 0; c < 3; ++c)
      to[c * nodes] = kByte * std::floor(255.0F * std::clamp(std::sqrt(sum[c] / weight) + step, 0.0F, 1.0F) + 0.5F);
    to[3 * nodes] = 1.0F;
  }
  kept.lines.resize(8 * static_cast<std::size_t>(band.columns));
}

// The nodes' values in the middle of a row of pixels.
void find_lines(const MatteBand& band, int y, MatteLight& kept) {
  const float down = (static_cast<float>(y - band.corner_px.y) + 0.5F) / static_cast<float>(band.cell_px) - 0.5F;
  const int above = std::clamp(static_cast<int>(std::floor(down)), 0, band.rows - 2);
  const float below = std::clamp(down - static_cast<float>(above), 0.0F, 1.0F);
  const std::size_t columns = static_cast<std::size_t>(band.columns);
  const std::size_t nodes = columns * static_cast<std::size_t>(band.rows);
  for (std::size_t channel = 0; channel < 8; ++channel) {
    const float* from = kept.nodes.data() + channel * nodes + static_cast<std::size_t>(above) * columns;
    float* to = kept.lines.data() + channel * columns;
    for (std::size_t i = 0; i < columns; ++i) to[i] = from[i] * (1.0F - below) + from[columns + i] * below;
  }
}

// Between which nodes the eight pixels lie.
void find_nodes(const MatteBand& band, int left, OpenText& text) {
  const lanes along = (lanes(kOrder) + (left - band.corner_px.x + 0.5)) * (1.0 / band.cell_px) - 0.5;
  const auto before = [&](int of) {
    return std::clamp(static_cast<int>(std::floor(along.of[of])), 0, band.columns - 2);
  };
  const int first = before(0), second = before(kEight / 2);
  const auto a = static_cast<float>(first), b = static_cast<float>(second);
  text.nodes_before = {first, second};
  text.from_before = along - lanes(Floats{a, a, a, a, b, b, b, b});
}

// `prepare`: before the first of a row's eights, and before each.
template <class Text, class BeginRow, class Begin>
void mix_all(Text& text, const EdgeInputs& in, glm::ivec2 first, Image<glm::u8vec4>& mixed, BeginRow begin_row,
             Begin begin) {
  const EncodedEight camera(in.camera);
  text.saturation = in.measured.saturation;
  text.noise_shot = three(in.noise.shot);
  text.noise_read2 = three(in.noise.read * in.noise.read);
  const glm::ivec2 noise_first = noise_start(in.noise.pattern % kNoisePatterns);
  text.dither_pattern.here = &text.steps;
  text.noise_pattern.here = &text.numbers;
  text.layer.here = &text.object;
  text.numbers = vec4(0.5);
  std::optional<AirlightRow> airlight;
  int row = 0;
  for (const EightPixels& eight : in.pixels.eights(in.passers != nullptr)) {
    const std::uint32_t which = in.passers ? eight.whole : eight.edge;
    const int left = eight.left, y = eight.top;
    if (!airlight || row != y) {
      row = y;
      airlight.emplace(in.measured, y);
      begin_row(y);
    }
    begin(eight);
    text.seen_by_camera = three(camera.at(left, y));
    text.object = {loaded<Floats>(eight.texel[0].data()), loaded<Floats>(eight.texel[1].data()),
                   loaded<Floats>(eight.texel[2].data()), loaded<Floats>(eight.texel[3].data())};
    text.steps.r = each([&](int i) { return static_cast<float>(repeated(in.patterns.dither, left + i, y)) * kByte; });
    if (!in.noise.none()) {
      std::array<float, kLanes> numbers[3];
      for (int i = 0; i < kEight; ++i) {
        const glm::u8vec3& of = repeated(*in.patterns.noise, left + i + noise_first.x, y + noise_first.y);
        for (std::size_t c = 0; c < 3; ++c) numbers[c][static_cast<std::size_t>(i)] = of[static_cast<int>(c)];
      }
      text.numbers = {vec3(loaded<Floats>(numbers[0].data()), loaded<Floats>(numbers[1].data()),
                           loaded<Floats>(numbers[2].data())) *
                          kByte,
                      1.0};
    }
    // Of the grid's light, which is linear but for its lines, far apart.
    const glm::dvec3 light = airlight->at(left) * in.pixels.unit();
    const glm::dvec3 change = (airlight->at(left + kEight - 1) * in.pixels.unit() - light) / (kEight - 1.0);
    text.v_airlight_root = sqrt(three(light) + lanes(kOrder) * three(change));
    text.mix_pixels();

    const vec4& seen = text.gl_FragColor;
    const Integers changed = Integers{1, 2, 4, 8, 16, 32, 64, 128} & static_cast<std::int32_t>(which);
    const Integers written = (changed != 0) & (seen.a > 0.0).set;
    const Integers share = bytes_of(seen.a);
    const Integers pixels =
        bytes_of(seen.r) | bytes_of(seen.g) << 8 | bytes_of(seen.b) << 16 | (share < 1 ? 1 : share) << 24;
    glm::u8vec4* to = mixed.row(y - first.y) + (left - first.x);
    if (left >= first.x && left + kEight <= first.x + mixed.width()) {
      const Integers before = loaded<Integers>(to), after = written ? pixels : before;
      std::memcpy(to, &after, sizeof after);
    } else {
      for (int i = 0; i < kEight; ++i)
        if (const std::int32_t pixel = pixels[i]; written[i]) std::memcpy(to + i, &pixel, sizeof *to);
    }
  }
}

void mix_open(const EdgeInputs& in, glm::ivec2 first, Image<glm::u8vec4>& mixed, MatteLight& kept) {
  OpenText text;
  text.response_of_camera = &in.response;
  vec4 mask(1.0), passer(1.0);
  text.foreground.here = &mask;
  text.in_front.here = &passer;
  const MatteBand* band = in.pixels.band();
  if (band) {
    follow_matte(text, in, *band, kept);
    text.node_lines = kept.lines.data();
    text.columns = band->columns;
    text.light_row = band->box.right - band->box.left;
    text.light_plane = text.light_row * (band->box.bottom - band->box.top);
  }
  const auto begin_row = [&](int y) {
    if (band) find_lines(*band, y, kept);
  };
  const auto begin = [&](const EightPixels& eight) {
    if (in.pixels.is_left_open()) {
      mask.r = shares_of(eight.free_share);
      mask.a = shares_of(eight.confidence);
    }
    if (band) {
      // Of eights without a mixed pixel it is not asked for, and may lie elsewhere.
      text.light_here =
          kept.light.data() + kLanes + (eight.top - band->box.top) * text.light_row + eight.left - band->box.left;
      find_nodes(*band, eight.left, text);
    }
    if (!in.passers) return;
    const InFront& passers = *in.passers;
    const int y = eight.top - passers.top;
    float values[4][kLanes];
    for (int i = 0; i < kEight; ++i) {
      const int x = eight.left + i - passers.left;
      const glm::u8vec4 of = passers.pixels.contains(x, y) ? passers.pixels.at(x, y) : glm::u8vec4{0, 0, 0, 255};
      for (int c = 0; c < 4; ++c) values[c][i] = static_cast<float>(of[c]) * kByte;
    }
    passer = {loaded<Floats>(values[0]), loaded<Floats>(values[1]), loaded<Floats>(values[2]),
              loaded<Floats>(values[3])};
  };
  mix_all(text, in, first, mixed, begin_row, begin);
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

void mix_edges(const EdgeInputs& in, glm::ivec2 first, Image<glm::u8vec4>& mixed, MatteLight& kept) {
  run_by_widest([&] {
    if (in.pixels.is_left_open() || in.passers) return mix_open(in, first, mixed, kept);
    FreeText text;
    text.response_of_camera = &in.response;
    mix_all(
        text, in, first, mixed, [](int) {}, [](const EightPixels&) {});
  });
}

}  // namespace kasumi
