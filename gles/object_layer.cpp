#include "gles/object_layer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "gles/airlight_grid.hpp"
#include "gles/depth.hpp"
#include "gles/gl.hpp"
#include "gles/point_spread.hpp"
#include "gles/texture_units.hpp"

namespace kasumi {
namespace {

// Samples lie on a square lattice turned by atan(1/4): sample (a, b) is at pixel ((4a - b) / 17, (a + 4b) / 17), so
// each pixel holds 17 of them, no two at the same height or the same width. Upright and level edges, which buildings
// are made of, get 17 steps instead of the 4 of an upright 4 x 4 grid. The lattice is drawn as an ordinary picture, by
// turning what is projected, and resolved by a sum over these offsets.
constexpr std::array<std::array<int, 2>, 17> kOffsets{{{0, 0},
                                                       {1, 0},
                                                       {-1, 0},
                                                       {0, 1},
                                                       {0, -1},
                                                       {1, 1},
                                                       {1, -1},
                                                       {-1, 1},
                                                       {-1, -1},
                                                       {2, 0},
                                                       {-2, 0},
                                                       {0, 2},
                                                       {0, -2},
                                                       {2, 1},
                                                       {-2, -1},
                                                       {-1, 2},
                                                       {1, -2}}};
constexpr int kLatticeSize = 1024;                // of the buffer that holds a tile's samples
constexpr int kReach = 2;                         // of the offsets
const double kSamplesPerPixel = std::sqrt(17.0);  // along the lattice's axes

// Columns of a matrix that acts on (x, y, 1).
glm::dmat3 affine(const glm::dvec3& x_row, const glm::dvec3& y_row) {
  return {{x_row.x, y_row.x, 0.0}, {x_row.y, y_row.y, 0.0}, {x_row.z, y_row.z, 1.0}};
}

// One tile: pixels [left, right) x [top, bottom), and the lattice's numbers at the buffer's corner. `spare`: samples
// drawn around those that its pixels are made of.
struct Tile {
  PixelBox box;
  int around;
  int first_a;
  int first_b;

  Tile(const PixelBox& pixels, int spare)
      : box(pixels),
        around(kReach + spare),
        first_a(4 * pixels.left + pixels.top - around),
        first_b(4 * pixels.top - (pixels.right - 1) - around) {}
  static int most_pixels(int spare) { return (kLatticeSize - 2 * (kReach + spare)) / 5; }

  // The part of the buffer that is used.
  int width() const { return 4 * (box.right - box.left) + (box.bottom - box.top) + 2 * around; }
  int height() const { return 4 * (box.bottom - box.top) + (box.right - box.left) + 2 * around; }

  // Homogeneous pixels to the buffer's clip coordinates.
  glm::dmat3 pixel_to_clip() const {
    constexpr double s = 2.0 / kLatticeSize;
    return affine({4.0 * s, s, (0.5 - first_a) * s - 1.0}, {-s, 4.0 * s, (0.5 - first_b) * s - 1.0});
  }
  // gl_FragCoord in the buffer to the picture's pixels.
  glm::dmat3 fragment_to_pixel() const {
    const double a = first_a - 0.5, b = first_b - 0.5;
    return affine({4.0 / 17.0, -1.0 / 17.0, (4.0 * a - b) / 17.0}, {1.0 / 17.0, 4.0 / 17.0, (a + 4.0 * b) / 17.0});
  }
  // The same to 0..1 across the tile, from its first to one past its last pixel.
  glm::dmat3 fragment_to_patch() const {
    const double w = box.right - box.left, h = box.bottom - box.top;
    return affine({1.0 / w, 0.0, -box.left / w}, {0.0, 1.0 / h, -box.top / h}) * fragment_to_pixel();
  }
  // The horizon's light across the tile, which lies within one cell of its grid.
  std::array<glm::dvec3, 4> horizon_patch(const AirlightGrid& horizon) const {
    const auto at = [&](int x, int y) { return airlight_at(horizon, {x, y}); };
    const glm::dvec3 first = at(box.left, box.top), along = at(box.right, box.top) - first;
    const glm::dvec3 down = at(box.left, box.bottom) - first;
    return {first, along, down, at(box.right, box.bottom) - first - along - down};
  }
  // gl_FragCoord in the layer to texture coordinates of the buffer.
  glm::dmat3 layer_fragment_to_sample(const PixelBox& layer) const {
    const double x = layer.left - 0.5, y = layer.top - 0.5;
    constexpr double s = 1.0 / kLatticeSize;
    return affine({4.0 * s, s, (4.0 * x + y - first_a + 0.5) * s}, {-s, 4.0 * s, (4.0 * y - x - first_b + 0.5) * s});
  }
};

// Pixels where tiles end between first and last: at the lines of the horizon's grid, and before they are too large.
std::vector<int> tile_ends(int first, int last, int most, double first_line, double last_line, int lines) {
  std::vector<int> ends;
  const auto go_to = [&](int end) {
    const int begin = ends.empty() ? first : ends.back();
    const int parts = (end - begin + most - 1) / most;
    for (int part = 1; part <= parts; ++part) ends.push_back(begin + (end - begin) * part / parts);
  };
  for (int line = 0; line < lines; ++line) {
    const double at = std::round(first_line + (last_line - first_line) * line / (lines - 1));
    if (at > (ends.empty() ? first : ends.back()) && at < last) go_to(static_cast<int>(at));
  }
  go_to(last);
  return ends;
}

std::vector<PixelBox> tiles_of(const PixelBox& box, int most, const AirlightGrid& horizon) {
  const glm::dvec2 first = horizon.first_px, last = horizon.last_px;
  const auto rows = tile_ends(box.top, box.bottom, most, first.y, last.y, AirlightGrid::kRows);
  const auto columns = tile_ends(box.left, box.right, most, first.x, last.x, AirlightGrid::kColumns);
  std::vector<PixelBox> tiles;
  int top = box.top;
  for (const int bottom : rows) {
    int left = box.left;
    for (const int right : columns) {
      tiles.push_back({left, top, right, bottom});
      left = right;
    }
    top = bottom;
  }
  return tiles;
}

// The buffer that one tile after the other is drawn into.
struct Lattice {
  LayerBuffer samples;
  GlRenderbuffer depth;

  static Result<Lattice> create(bool in_8_bits, const GlInfo& info) {
    constexpr std::string_view kName = "the buffer for anti-aliasing";
    auto samples = LayerBuffer::create(kLatticeSize, kLatticeSize, in_8_bits, info, kName);
    if (!samples) return tl::unexpected(samples.error());
    Lattice made{std::move(*samples), make_renderbuffer()};
    glBindRenderbuffer(GL_RENDERBUFFER, made.depth.name());
    glRenderbufferStorage(GL_RENDERBUFFER, depth_format(info), kLatticeSize, kLatticeSize);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, made.depth.name());
    if (auto complete = check_framebuffer(kName); !complete) return tl::unexpected(complete.error());
    return made;
  }
};

bool shares_chroma(const ObjectDetail& detail) {
  return detail.chroma_columns > 1 || detail.chroma_rows > 1;
}

double spread_in_samples(const ObjectDetail& detail) {
  return detail.point_spread_px * kSamplesPerPixel;
}

// How many around a pixel's own samples matter to it, each way along the lattice's axes.
int spare_samples(const ObjectDetail& detail) {
  const int spread = detail.point_spread_px > 0.0 ? spread_radius(spread_in_samples(detail)) : 0;
  return spread + (shares_chroma(detail) ? 5 : 0);  // a neighbouring pixel's samples lie up to five away
}

// The corner of a square of so many samples lies so many pixels off, at most.
int pixels_of(int samples) {
  return (5 * samples + 16) / 17;
}

}  // namespace

int ObjectLayer::margin_px(const ObjectDetail& detail) {
  return pixels_of(spare_samples(detail));
}

Result<ObjectLayer> ObjectLayer::draw(const GpuModel& model, const Projection& projection, const PixelBox& box,
                                      const AirlightGrid& horizon, const Options& options, const GlInfo& info,
                                      Programs& programs, const std::function<void(const Program&)>& set_appearance) {
  ObjectLayer layer;
  layer.box_ = box;
  layer.in_8_bits_ = options.in_8_bits;
  layer.unit_ = options.in_8_bits ? options.unit : 1.0;
  layer.filters_ = options.in_8_bits || info.es_major >= 3 || info.has("GL_OES_texture_half_float_linear");
  auto buffer =
      LayerBuffer::create(box.right - box.left, box.bottom - box.top, options.in_8_bits, info, "the object's layer");
  if (!buffer) return tl::unexpected(buffer.error());
  layer.buffer_ = std::move(*buffer);
  const auto lattice = Lattice::create(options.in_8_bits, info);
  if (!lattice) return tl::unexpected(lattice.error());
  std::optional<PointSpread> spread;
  if (options.detail.point_spread_px > 0.0) {
    auto made = PointSpread::create(spread_in_samples(options.detail), kLatticeSize, options.in_8_bits, info, programs);
    if (!made) return tl::unexpected(made.error());
    spread = std::move(*made);
  }
  const int spare = spare_samples(options.detail);

  Defines object_defines{"HAZE_PER_FRAGMENT"};
  if (!options.aerial_perspective) object_defines = {"NO_AIR"};
  if (projection.distorted) object_defines.insert("DISTORTED");
  if (options.in_8_bits) object_defines.insert("LAYER_IN_8_BITS");
  if (options.scene_depth) object_defines.insert("SCENE_DEPTH");
  std::vector<GpuModel::Which> drawn_parts{GpuModel::Which::solid, GpuModel::Which::blended};
  if (options.shadow) {
    object_defines.merge(options.shadow->defines());
    object_defines.insert("ONE_MAP_EACH");
    drawn_parts = {GpuModel::Which::solid, GpuModel::Which::ground, GpuModel::Which::blended};
  }
  Defines resolve_defines;
  if (options.in_8_bits) resolve_defines.insert("LAYER_IN_8_BITS");
  if (options.foreground) resolve_defines.insert("FOREGROUND");
  if (shares_chroma(options.detail))
    resolve_defines.merge(Defines{fmt::format("CHROMA_COLUMNS {}", options.detail.chroma_columns),
                                  fmt::format("CHROMA_ROWS {}", options.detail.chroma_rows)});
  const auto resolve = programs.find(ProgramKind::resolve, resolve_defines);
  if (!resolve) return tl::unexpected(resolve.error());

  const DepthRange depth = depth_range(projection, model.bounds_with_ground());
  std::array<glm::dvec2, kOffsets.size()> offsets;
  std::ranges::transform(kOffsets, offsets.begin(), [](const auto& o) { return glm::dvec2{o[0], o[1]}; });

  for (const PixelBox& pixels : tiles_of(box, Tile::most_pixels(spare), horizon)) {
    const Tile tile(pixels, spare);
    glBindFramebuffer(GL_FRAMEBUFFER, lattice->samples.framebuffer.name());
    glViewport(0, 0, kLatticeSize, kLatticeSize);
    glEnable(GL_SCISSOR_TEST);
    glScissor(0, 0, tile.width(), tile.height());
    glClearColor(0, 0, 0, 0);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    glDisable(GL_SCISSOR_TEST);
    // The picture's rows grow downwards, the buffer's upwards: a mirror, which turns fronts into backs.
    glFrontFace(projection.mirrored ? GL_CCW : GL_CW);
    const auto set_uniforms = [&](const Program& program) {
      set_projection(program, projection, depth);
      program.set("pixel_to_clip", tile.pixel_to_clip());
      program.set("fragment_to_patch", tile.fragment_to_patch());
      program.set("horizon_patch", tile.horizon_patch(horizon));
      program.set("layer_unit", layer.unit_);
      program.set("dither_pattern", kDitherUnit);
      if (options.scene_depth) {
        options.scene_depth->bind(program, options.scene_depth_unit);
        program.set("fragment_to_pixel", tile.fragment_to_pixel());
      }
      if (options.shadow) {
        options.shadow->bind(program, kShadowUnit);
        program.set("lattice_first", glm::dvec2{tile.first_a, tile.first_b});
      }
      set_appearance(program);
    };
    const PixelBox seen = grown(tile.box, pixels_of(tile.around));
    for (const auto which : drawn_parts)
      if (auto drawn = model.draw(which, programs, object_defines, units_for_layer(), seen, set_uniforms); !drawn)
        return tl::unexpected(drawn.error());

    if (spread) spread->apply(lattice->samples, tile.width(), tile.height());

    glBindFramebuffer(GL_FRAMEBUFFER, layer.buffer_.framebuffer.name());
    glViewport(tile.box.left - box.left, tile.box.top - box.top, tile.box.right - tile.box.left,
               tile.box.bottom - tile.box.top);
    const Program& program = **resolve;
    program.use();
    glActiveTexture(GL_TEXTURE0 + kLayerUnit);
    glBindTexture(GL_TEXTURE_2D, lattice->samples.texture.name());
    program.set("samples", kLayerUnit);
    program.set("fragment_to_sample", tile.layer_fragment_to_sample(box));
    program.set("sample_step", glm::dvec2{1.0 / kLatticeSize});
    program.set("offsets", offsets);
    program.set("first_pixel", glm::dvec2{box.left, box.top});
    program.set("foreground", kForegroundUnit);
    program.set("dither_pattern", kDitherUnit);
    const double w = projection.view.width, h = projection.view.height;
    program.set("fragment_to_picture", affine({1.0 / w, 0.0, box.left / w}, {0.0, 1.0 / h, box.top / h}));
    draw_square();
  }
  if (auto drawn = check_gl("drawing the object's layer"); !drawn) return tl::unexpected(drawn.error());
  return layer;
}

void ObjectLayer::bind(const Program& program, bool smooth) const {
  glActiveTexture(GL_TEXTURE0 + kLayerUnit);
  glBindTexture(GL_TEXTURE_2D, buffer_.texture.name());
  for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    glTexParameteri(GL_TEXTURE_2D, filter, smooth && filters_ ? GL_LINEAR : GL_NEAREST);
  program.set("layer", kLayerUnit);
  program.set("layer_unit", unit_);
  program.set("layer_place",
              glm::dvec4(box_.left, box_.top, 1.0 / (box_.right - box_.left), 1.0 / (box_.bottom - box_.top)));
}

Result<Image<glm::vec4>> ObjectLayer::read() const {
  Image<glm::vec4> image(box_.right - box_.left, box_.bottom - box_.top);
  glBindFramebuffer(GL_FRAMEBUFFER, buffer_.framebuffer.name());
  glPixelStorei(GL_PACK_ALIGNMENT, 4);
  if (in_8_bits_) {
    Image<glm::u8vec4> bytes(image.width(), image.height());
    glReadPixels(0, 0, image.width(), image.height(), GL_RGBA, GL_UNSIGNED_BYTE, bytes.elements().data());
    std::ranges::transform(bytes.elements(), image.elements().begin(),
                           [](glm::u8vec4 texel) { return glm::vec4(texel) / 255.0f; });
  } else {
    glReadPixels(0, 0, image.width(), image.height(), GL_RGBA, GL_FLOAT, image.elements().data());
  }
  for (glm::vec4& texel : image.elements()) {  // as layer.glsl
    const glm::vec3 root(texel);
    texel = glm::vec4(root * root * static_cast<float>(unit_), std::min(2.0f * texel.a, 1.0f));
  }
  if (auto read = check_gl("reading the object's layer"); !read) return tl::unexpected(read.error());
  return image;
}

}  // namespace kasumi
