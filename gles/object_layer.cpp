#include "gles/object_layer.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "gles/depth.hpp"
#include "gles/gl.hpp"

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
constexpr int kLatticeSize = 1024;  // of the buffer that holds a tile's samples
constexpr int kTile = 203;          // pixels at most: 5 * 203 + 2 margins of 2 fit
constexpr GLenum kRgba16f = 0x881A;

// Columns of a matrix that acts on (x, y, 1).
glm::dmat3 affine(const glm::dvec3& x_row, const glm::dvec3& y_row) {
  return {{x_row.x, y_row.x, 0.0}, {x_row.y, y_row.y, 0.0}, {x_row.z, y_row.z, 1.0}};
}

// One tile: pixels [left, right) x [top, bottom), and the lattice's numbers at the buffer's corner.
struct Tile {
  PixelBox box;
  int first_a;
  int first_b;

  explicit Tile(const PixelBox& pixels)
      : box(pixels), first_a(4 * pixels.left + pixels.top - 2), first_b(4 * pixels.top - (pixels.right - 1) - 2) {}

  // The part of the buffer that is used.
  int width() const { return 4 * (box.right - box.left) + (box.bottom - box.top) + 4; }
  int height() const { return 4 * (box.bottom - box.top) + (box.right - box.left) + 4; }

  // Homogeneous pixels to the buffer's clip coordinates.
  glm::dmat3 pixel_to_clip() const {
    constexpr double s = 2.0 / kLatticeSize;
    return affine({4.0 * s, s, (0.5 - first_a) * s - 1.0}, {-s, 4.0 * s, (0.5 - first_b) * s - 1.0});
  }
  // gl_FragCoord in the buffer to 0..1 across the tile, from its first to one past its last pixel.
  glm::dmat3 fragment_to_patch() const {
    const double a = first_a - 0.5, b = first_b - 0.5;
    const double w = box.right - box.left, h = box.bottom - box.top;
    return affine(glm::dvec3{4.0 / 17.0, -1.0 / 17.0, (4.0 * a - b) / 17.0 - box.left} / w,
                  glm::dvec3{1.0 / 17.0, 4.0 / 17.0, (a + 4.0 * b) / 17.0 - box.top} / h);
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
std::vector<int> tile_ends(int first, int last, double first_line, double last_line, int lines) {
  std::vector<int> ends;
  const auto go_to = [&](int end) {
    const int begin = ends.empty() ? first : ends.back();
    const int parts = (end - begin + kTile - 1) / kTile;
    for (int part = 1; part <= parts; ++part) ends.push_back(begin + (end - begin) * part / parts);
  };
  for (int line = 0; line < lines; ++line) {
    const double at = std::round(first_line + (last_line - first_line) * line / (lines - 1));
    if (at > (ends.empty() ? first : ends.back()) && at < last) go_to(static_cast<int>(at));
  }
  go_to(last);
  return ends;
}

std::vector<PixelBox> tiles_of(const PixelBox& box, const AirlightGrid& horizon) {
  std::vector<PixelBox> tiles;
  int top = box.top;
  for (const int bottom : tile_ends(box.top, box.bottom, horizon.first_px.y, horizon.last_px.y, AirlightGrid::kRows)) {
    int left = box.left;
    for (const int right :
         tile_ends(box.left, box.right, horizon.first_px.x, horizon.last_px.x, AirlightGrid::kColumns)) {
      tiles.push_back({left, top, right, bottom});
      left = right;
    }
    top = bottom;
  }
  return tiles;
}

GlTexture make_target_texture(int width, int height, bool in_8_bits, const GlInfo& info) {
  GlTexture texture = make_texture();
  glActiveTexture(GL_TEXTURE0 + kLayerUnit);
  glBindTexture(GL_TEXTURE_2D, texture.name());
  if (in_8_bits) {
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
  } else if (info.es_major >= 3) {
    constexpr GLenum kHalfFloat = 0x140B;
    glTexImage2D(GL_TEXTURE_2D, 0, kRgba16f, width, height, 0, GL_RGBA, kHalfFloat, nullptr);
  } else {
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA, width, height, 0, GL_RGBA, GL_HALF_FLOAT_OES, nullptr);
  }
  for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    glTexParameteri(GL_TEXTURE_2D, filter, GL_NEAREST);
  for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
    glTexParameteri(GL_TEXTURE_2D, wrap, GL_CLAMP_TO_EDGE);
  return texture;
}

GlFramebuffer make_target(const GlTexture& texture) {
  GlFramebuffer framebuffer = make_framebuffer();
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture.name(), 0);
  return framebuffer;
}

void draw_square() {
  constexpr std::array<float, 8> kCorners{-1, -1, 1, -1, -1, 1, 1, 1};
  glBindBuffer(GL_ARRAY_BUFFER, 0);
  glEnableVertexAttribArray(kPosition);
  glVertexAttribPointer(kPosition, 2, GL_FLOAT, GL_FALSE, 0, kCorners.data());
  glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
  glDisableVertexAttribArray(kPosition);
}

// The buffer that one tile after the other is drawn into.
struct Lattice {
  GlTexture texture;
  GlFramebuffer framebuffer;
  GlRenderbuffer depth;

  static Result<Lattice> create(bool in_8_bits, const GlInfo& info) {
    Lattice made;
    made.texture = make_target_texture(kLatticeSize, kLatticeSize, in_8_bits, info);
    made.framebuffer = make_target(made.texture);
    made.depth = make_renderbuffer();
    glBindRenderbuffer(GL_RENDERBUFFER, made.depth.name());
    glRenderbufferStorage(GL_RENDERBUFFER, depth_format(info), kLatticeSize, kLatticeSize);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, made.depth.name());
    if (auto complete = check_framebuffer("the buffer for anti-aliasing"); !complete)
      return tl::unexpected(complete.error());
    return made;
  }
};

}  // namespace

Result<ObjectLayer> ObjectLayer::draw(const GpuModel& model, const Projection& projection, const PixelBox& box,
                                      const AirlightGrid& horizon, const Options& options, const GlInfo& info,
                                      Programs& programs, const std::function<void(const Program&)>& set_appearance) {
  ObjectLayer layer;
  layer.box_ = box;
  layer.in_8_bits_ = options.in_8_bits;
  layer.unit_ = options.in_8_bits ? options.unit : 1.0;
  layer.filters_ = options.in_8_bits || info.es_major >= 3 || info.has("GL_OES_texture_half_float_linear");
  layer.texture_ = make_target_texture(box.right - box.left, box.bottom - box.top, options.in_8_bits, info);
  layer.framebuffer_ = make_target(layer.texture_);
  if (auto complete = check_framebuffer("the object's layer"); !complete) return tl::unexpected(complete.error());
  const auto lattice = Lattice::create(options.in_8_bits, info);
  if (!lattice) return tl::unexpected(lattice.error());

  Defines object_defines{"HAZE_PER_FRAGMENT"};
  if (!options.aerial_perspective) object_defines = {"NO_AIR"};
  if (projection.distorted) object_defines.insert("DISTORTED");
  if (options.in_8_bits) object_defines.insert("LAYER_IN_8_BITS");
  Defines resolve_defines;
  if (options.in_8_bits) resolve_defines.insert("LAYER_IN_8_BITS");
  if (options.foreground) resolve_defines.insert("FOREGROUND");
  const auto resolve = programs.find(ProgramKind::resolve, resolve_defines);
  if (!resolve) return tl::unexpected(resolve.error());

  const DepthRange depth = depth_range(projection, model.bounds());
  std::array<glm::dvec2, kOffsets.size()> offsets;
  std::ranges::transform(kOffsets, offsets.begin(), [](const auto& o) { return glm::dvec2{o[0], o[1]}; });

  for (const PixelBox& pixels : tiles_of(box, horizon)) {
    const Tile tile(pixels);
    glBindFramebuffer(GL_FRAMEBUFFER, lattice->framebuffer.name());
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
      set_appearance(program);
    };
    for (const auto which : {GpuModel::Which::solid, GpuModel::Which::blended})
      if (auto drawn = model.draw(which, programs, object_defines, units_for_layer(), tile.box, set_uniforms); !drawn)
        return tl::unexpected(drawn.error());

    glBindFramebuffer(GL_FRAMEBUFFER, layer.framebuffer_.name());
    glViewport(tile.box.left - box.left, tile.box.top - box.top, tile.box.right - tile.box.left,
               tile.box.bottom - tile.box.top);
    const Program& program = **resolve;
    program.use();
    glActiveTexture(GL_TEXTURE0 + kLayerUnit);
    glBindTexture(GL_TEXTURE_2D, lattice->texture.name());
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
  glBindTexture(GL_TEXTURE_2D, texture_.name());
  for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    glTexParameteri(GL_TEXTURE_2D, filter, smooth && filters_ ? GL_LINEAR : GL_NEAREST);
  program.set("layer", kLayerUnit);
  program.set("layer_unit", unit_);
  program.set("layer_place",
              glm::dvec4(box_.left, box_.top, 1.0 / (box_.right - box_.left), 1.0 / (box_.bottom - box_.top)));
}

Result<Image<glm::vec4>> ObjectLayer::read() const {
  Image<glm::vec4> image(box_.right - box_.left, box_.bottom - box_.top);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.name());
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
