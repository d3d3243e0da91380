#include "gles/object/object_layer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "gles/gl/depth.hpp"
#include "gles/gl/gl.hpp"
#include "gles/gl/texture_units.hpp"
#include "gles/light/airlight_grid.hpp"
#include "gles/object/coarse_spread.hpp"
#include "gles/object/layer_tiles.hpp"
#include "gles/object/pixel_means.hpp"
#include "gles/object/point_spread.hpp"

namespace kasumi {
namespace {

bool shares_chroma(const ObjectDetail& detail) {
  return detail.chroma_columns > 1 || detail.chroma_rows > 1;
}

double spread_in_samples(const ObjectDetail& detail) {
  return detail.point_spread_px * kSamplesPerPixel;
}

// How many samples beyond a pixel's own affect it, in each direction along the lattice's axes.
int spare_samples(const ObjectDetail& detail) {
  const int spread = detail.point_spread_px > 0.0 ? spread_radius(spread_in_samples(detail)) : 0;
  return spread + (shares_chroma(detail) ? 5 : 0);  // a neighbouring pixel's samples lie up to five away
}

}  // namespace

// A tile, and the box of its pixels that the model can reach. The others stay empty and cost no samples.
struct ReachedTile {
  LayerTile tile;
  PixelBox reached;
};

// The buffers into which the tiles are drawn one after the other.
struct LayerLattice {
  int size;  // samples along a side
  LayerBuffer samples;
  GlRenderbuffer depth;
  std::optional<PointSpread> spread;   // a narrow one; empty: none
  std::optional<CoarseSpread> coarse;  // a wide one; empty: none
  std::optional<PixelMeans> means;     // empty: each sample is spread along both axes

  static Result<LayerLattice> create(int size, const ObjectLayer::Options& options, const GlInfo& info,
                                     Programs& programs) {
    constexpr std::string_view kName = "the buffer for anti-aliasing";  // in messages
    auto samples = LayerBuffer::create(size, size, options.in_8_bits, info, kName);
    if (!samples) return fail(samples.error());
    LayerLattice made{size, std::move(*samples), make_renderbuffer(), std::nullopt, std::nullopt, std::nullopt};
    glBindRenderbuffer(GL_RENDERBUFFER, made.depth.name());
    glRenderbufferStorage(GL_RENDERBUFFER, depth_format(info), size, size);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, made.depth.name());
    if (auto complete = check_framebuffer(kName); !complete) return fail(complete.error());
    if (options.detail.point_spread_px <= 0.0) return made;
    const double sigma = spread_in_samples(options.detail);
    const SplitSpread split = split_spread(sigma);
    if (split.step > 1 && !options.in_8_bits) {
      auto coarse = CoarseSpread::create(split, size, info, programs);
      if (!coarse) return fail(coarse.error());
      made.coarse = std::move(*coarse);
      auto means = PixelMeans::create(*made.coarse, spare_samples(options.detail), info, programs);
      if (!means) return fail(means.error());
      made.means = std::move(*means);
      return made;
    }
    auto spread = PointSpread::create(sigma, size, options.in_8_bits, info, programs);
    if (!spread) return fail(spread.error());
    made.spread = std::move(*spread);
    if (options.in_8_bits) return made;  // bytes would be too coarse for means
    auto means = PixelMeans::create(*made.spread, size, spare_samples(options.detail), info, programs);
    if (!means) return fail(means.error());
    made.means = std::move(*means);
    return made;
  }

  // What is drawn in the buffer's first width x height samples is spread; the samples to be resolved.
  const LayerBuffer& spread_out(int width, int height) const {
    if (spread && means) return spread->along_rows(samples, width, height);
    if (spread) spread->apply(samples, width, height);
    return samples;
  }

  void clear() const {
    glBindFramebuffer(GL_FRAMEBUFFER, samples.framebuffer.name());
    glViewport(0, 0, size, size);
    glClearColor(0, 0, 0, 0);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  }
};

namespace {

Defines object_defines(const ObjectLayer::Options& options, const Projection& projection) {
  Defines defines{"HAZE_PER_FRAGMENT"};
  if (!options.aerial_perspective) defines = {"NO_AIR"};
  if (options.aerial_perspective && options.fog) defines.insert("FOG_LIGHT");
  if (projection.distorted) defines.insert("DISTORTED");
  if (options.in_8_bits) defines.insert("LAYER_IN_8_BITS");
  if (options.scene_depth) defines.insert("SCENE_DEPTH");
  if (!options.shadow) return defines;
  defines.merge(options.shadow->defines());
  defines.insert("ONE_MAP_EACH");
  return defines;
}

Defines resolve_defines(const ObjectLayer::Options& options, const LayerLattice& lattice) {
  Defines defines;
  if (lattice.means) defines.insert("MEANS");
  if (options.in_8_bits) defines.insert("LAYER_IN_8_BITS");
  if (options.foreground) defines.insert("FOREGROUND");
  if (shares_chroma(options.detail))
    defines.merge(Defines{fmt::format("CHROMA_COLUMNS {}", options.detail.chroma_columns),
                          fmt::format("CHROMA_ROWS {}", options.detail.chroma_rows)});
  return defines;
}

// The ground shows only the shadow on it.
std::vector<GpuModel::Which> drawn_parts(const ObjectLayer::Options& options) {
  if (options.shadow || (options.ground_light && options.ground_light->shades()))
    return {GpuModel::Which::solid, GpuModel::Which::ground, GpuModel::Which::blended};
  return {GpuModel::Which::solid, GpuModel::Which::blended};
}

std::vector<ReachedTile> tiles_reached(const GpuModel& model, const PixelBox& box, const AirlightGrid& horizon,
                                       const ObjectLayer::Options& options) {
  std::vector<ReachedTile> tiles;
  for (const LayerTile& tile : tiles_of(box, spare_samples(options.detail), horizon)) {
    PixelBox reached;
    for (const auto part : drawn_parts(options))
      reached = united(reached, model.box_within(part, tile.box(), pixels_of(tile.samples_around())));
    if (!reached.empty()) tiles.push_back({tile, reached});
  }
  return tiles;
}

// Of a buffer in which each tile has room.
int lattice_size(const std::vector<ReachedTile>& tiles) {
  constexpr int kStep = 64;  // as software GL lays it out
  int most = kStep;
  for (const auto& [tile, reached] : tiles) most = std::max({most, tile.width(), tile.height()});
  return (most + kStep - 1) / kStep * kStep;
}

// Limits drawing to a rectangle of the target.
class Scissor {
 public:
  Scissor(const glm::ivec2& first, const glm::ivec2& size) {
    glEnable(GL_SCISSOR_TEST);
    glScissor(first.x, first.y, size.x, size.y);
  }
  Scissor(const Scissor&) = delete;
  Scissor& operator=(const Scissor&) = delete;
  ~Scissor() { glDisable(GL_SCISSOR_TEST); }
};

void set_tile(const Program& program, const LayerTile& tile, const LayerLattice& lattice, const AirlightGrid& horizon,
              const ObjectLayer::Options& options) {
  program.set("pixel_to_clip", tile.pixel_to_clip(lattice.size));
  program.set("fragment_to_patch", tile.fragment_to_patch());
  program.set("horizon_patch", tile.horizon_patch(horizon));
  if (options.scene_depth) {
    options.scene_depth->bind(program, options.scene_depth_unit);
    program.set("fragment_to_pixel", tile.fragment_to_pixel());
  }
  if (options.shadow) {
    options.shadow->bind(program, kShadowUnit);
    program.set("lattice_first", glm::dvec2(tile.first_sample()));
  }
}

// Resolves a tile's samples, or its pixels' means, to the layer's pixels.
void resolve(const Program& program, const LayerBuffer& samples, const LayerLattice& lattice, const LayerTile& tile,
             const LayerBuffer& layer, const PixelBox& box, const SceneView& view) {
  std::array<glm::dvec2, kLatticeOffsets.size()> offsets;
  std::ranges::transform(kLatticeOffsets, offsets.begin(), [](const auto& o) { return glm::dvec2{o[0], o[1]}; });
  const PixelBox& pixels = tile.box();
  glBindFramebuffer(GL_FRAMEBUFFER, layer.framebuffer.name());
  const glm::ivec2 first{pixels.left - box.left, pixels.top - box.top};
  const glm::ivec2 size{pixels.right - pixels.left, pixels.bottom - pixels.top};
  glViewport(first.x, first.y, size.x, size.y);
  program.use();
  program.set("viewport", glm::dvec4(first, 0.5 * glm::dvec2(size)));
  glActiveTexture(GL_TEXTURE0 + kLayerUnit);
  glBindTexture(GL_TEXTURE_2D, samples.texture.name());
  program.set("samples", kLayerUnit);
  if (lattice.means) lattice.means->bind(program, tile, box);
  program.set("fragment_to_sample", tile.layer_fragment_to_sample(box, lattice.size));
  program.set("sample_step", glm::dvec2{1.0 / lattice.size});
  program.set("offsets", offsets);
  program.set("first_pixel", glm::dvec2{box.left, box.top});
  program.set("foreground", kForegroundUnit);
  program.set("dither_pattern", kDitherUnit);
  const double w = view.width, h = view.height;
  program.set("fragment_to_picture", affine({1.0 / w, 0.0, box.left / w}, {0.0, 1.0 / h, box.top / h}));
  draw_square();
}

}  // namespace

int ObjectLayer::margin_px(const ObjectDetail& detail) {
  return pixels_of(spare_samples(detail));
}

Result<ObjectLayer> ObjectLayer::create(const PixelBox& box, bool in_8_bits, const GlInfo& info) {
  ObjectLayer layer;
  layer.box_ = box;
  layer.in_8_bits_ = in_8_bits;
  layer.filters_ = in_8_bits || info.es_major >= 3 || info.has("GL_OES_texture_half_float_linear");
  auto buffer = LayerBuffer::create(box.right - box.left, box.bottom - box.top, in_8_bits, info, "the object's layer");
  if (!buffer) return fail(buffer.error());
  layer.buffer_ = std::move(*buffer);
  return layer;
}

Result<ObjectLayer> ObjectLayer::restore(const PixelBox& box, const Image<glm::u16vec4>& halves, const GlInfo& info) {
  auto layer = create(box, false, info);
  if (!layer) return layer;
  if (auto filled = layer->buffer_.fill(halves, info); !filled) return fail(filled.error());
  return layer;
}

Result<ObjectLayer> ObjectLayer::draw(const GpuModel& model, const Projection& projection, const PixelBox& box,
                                      const AirlightGrid& horizon, const Options& options, const GlInfo& info,
                                      Programs& programs, const std::function<void(const Program&)>& set_appearance) {
  auto drawing = LayerDrawing::begin(model, projection, box, horizon, options, info, programs, set_appearance);
  if (!drawing) return fail(drawing.error());
  for (;;) {
    const auto whole = drawing->step();
    if (!whole) return fail(whole.error());
    if (*whole) return drawing->take();
  }
}

struct LayerDrawing::State {
  bool software;  // GL, which keeps all that was ever in flight together: buffers, textures, triangles
  const GpuModel& model;
  const Projection& projection;
  AirlightGrid horizon;
  ObjectLayer::Options options;
  Programs& programs;
  std::function<void(const Program&)> set_appearance;
  ObjectLayer layer;
  LayerLattice lattice;
  const Program* resolving;
  Defines defines;
  DepthRange depth;
  std::vector<ReachedTile> tiles;
  std::size_t drawn = 0;

  void wait_if_software() const {
    if (software) glFinish();
  }

  // To the samples that the reached pixels need.
  Scissor scissor_of(const ReachedTile& part) const {
    const LayerTile needed(part.reached, spare_samples(options.detail));
    return {needed.first_sample() - part.tile.first_sample(), {needed.width(), needed.height()}};
  }

  Result<> draw_samples(const ReachedTile& part) const {
    const LayerTile& tile = part.tile;
    lattice.clear();
    // The picture's rows run downwards and the buffer's upwards: this mirroring reverses front and back faces.
    glFrontFace(projection.mirrored ? GL_CCW : GL_CW);
    const auto set_uniforms = [&](const Program& program) {
      set_projection(program, projection, depth);
      set_tile(program, tile, lattice, horizon, options);
      program.set("layer_unit", layer.unit_);
      program.set("dither_pattern", kDitherUnit);
      set_appearance(program);
      if (options.ground_light) options.ground_light->bind(program, tile.fragment_to_pixel());
    };
    const PixelBox sampled = grown(part.reached, pixels_of(tile.samples_around()));
    for (const auto which : drawn_parts(options)) {
      Defines variant = defines;
      if (which == GpuModel::Which::ground && options.ground_light) variant.merge(options.ground_light->defines());
      if (auto done = model.draw(which, programs, variant, units_for_layer(), sampled, set_uniforms); !done)
        return done;
    }
    return {};
  }

  Result<> draw(const ReachedTile& part) const {
    const LayerBuffer* samples = nullptr;
    {
      const Scissor scissor = scissor_of(part);
      if (auto done = draw_samples(part); !done) return done;
      wait_if_software();
      samples = &lattice.spread_out(part.tile.width(), part.tile.height());
      wait_if_software();
    }
    if (lattice.coarse) {
      const PixelBox needed = grown(part.reached, kMeansAround_px);
      lattice.coarse->along_rows(*samples, part.tile, needed);
      wait_if_software();
      samples = &lattice.coarse->along_columns(part.tile, needed);
      wait_if_software();
    }
    if (lattice.means) {
      lattice.means->draw(*samples, part.tile, part.reached);
      wait_if_software();
    }
    const PixelBox &reached = part.reached, &box = layer.box_;
    const Scissor scissor({reached.left - box.left, reached.top - box.top},
                          {reached.right - reached.left, reached.bottom - reached.top});
    resolve(*resolving, *samples, lattice, part.tile, layer.buffer_, box, projection.view);
    return check_gl("drawing the object's layer");
  }
};

LayerDrawing::LayerDrawing(std::unique_ptr<State> state) : state_(std::move(state)) {}
LayerDrawing::LayerDrawing(LayerDrawing&&) noexcept = default;
LayerDrawing& LayerDrawing::operator=(LayerDrawing&&) noexcept = default;
LayerDrawing::~LayerDrawing() = default;

Result<LayerDrawing> LayerDrawing::begin(const GpuModel& model, const Projection& projection, const PixelBox& box,
                                         const AirlightGrid& horizon, const ObjectLayer::Options& options,
                                         const GlInfo& info, Programs& programs,
                                         std::function<void(const Program&)> set_appearance) {
  auto layer = ObjectLayer::create(box, options.in_8_bits, info);
  if (!layer) return fail(layer.error());
  if (options.in_8_bits) layer->unit_ = options.unit;
  glClearColor(0, 0, 0, 0);
  glClear(GL_COLOR_BUFFER_BIT);  // into the buffer just created
  auto tiles = tiles_reached(model, box, horizon, options);
  auto lattice = LayerLattice::create(lattice_size(tiles), options, info, programs);
  if (!lattice) return fail(lattice.error());
  const auto resolving = programs.find(ProgramKind::resolve, resolve_defines(options, *lattice));
  if (!resolving) return fail(resolving.error());
  return LayerDrawing(std::make_unique<State>(
      State{info.software, model, projection, horizon, options, programs, std::move(set_appearance), std::move(*layer),
            std::move(*lattice), *resolving, object_defines(options, projection),
            depth_range(projection, model.bounds_with_ground()), std::move(tiles)}));
}

Result<bool> LayerDrawing::step() {
  State& s = *state_;
  if (s.drawn < s.tiles.size())
    if (auto drawn = s.draw(s.tiles[s.drawn++]); !drawn) return fail(drawn.error());
  return s.drawn == s.tiles.size();
}

ObjectLayer LayerDrawing::take() {
  return std::move(state_->layer);
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

Result<Image<glm::vec4>> ObjectLayer::read_texels() const {
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
  if (auto read = check_gl("reading the object's layer"); !read) return fail(read.error());
  return image;
}

Result<Image<glm::vec4>> ObjectLayer::read() const {
  auto image = read_texels();
  if (!image) return image;
  for (glm::vec4& texel : image->elements()) {  // as in layer.glsl
    const glm::vec3 root(texel);
    texel = glm::vec4(root * root * static_cast<float>(unit_), std::min(2.0f * texel.a, 1.0f));
  }
  return image;
}

}  // namespace kasumi
