#include "gles/composite/camera_processing.hpp"

#include <algorithm>

#include "gles/composite/changed_blocks.hpp"
#include "gles/gl/gl.hpp"
#include "gles/gl/texture_units.hpp"
#include "gles/gpu_model/projection.hpp"

namespace kasumi {
namespace {

constexpr int kSteps = 8;                                      // of a block's coefficients, each way
constexpr std::string_view kWhat = "the camera's processing";  // in messages

// As jpeg.frag has them. Steps above 255 levels leave nothing, as 255 does.
GlTexture upload_steps(const JpegSteps& steps) {
  std::array<std::uint8_t, 2 * 2 * kSteps * kSteps> texels{};
  const auto level = [](std::uint16_t step) { return static_cast<std::uint8_t>(std::clamp<int>(step, 1, 255)); };
  for (std::size_t i = 0; i < steps.luma.size(); ++i) {
    const std::size_t row = i / kSteps * 4 * kSteps, column = i % kSteps;
    texels[row + column] = level(steps.luma[i]);
    texels[row + 2 * (kSteps + column)] = texels[row + 2 * (kSteps + column) + 1] = level(steps.chroma[i]);
  }
  GlTexture texture = make_texture();
  glActiveTexture(GL_TEXTURE0 + kDitherUnit);
  glBindTexture(GL_TEXTURE_2D, texture.name());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_LUMINANCE_ALPHA, 2 * kSteps, kSteps, 0, GL_LUMINANCE_ALPHA, GL_UNSIGNED_BYTE,
               texels.data());
  set_filter(TextureFilter::nearest);
  clamp_to_edge();
  return texture;
}

void bind_to(int unit, const GlTexture& texture, TextureFilter filter) {
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  glBindTexture(GL_TEXTURE_2D, texture.name());
  set_filter(filter);
}

}  // namespace

Result<CameraProcessing> CameraProcessing::create(const ObjectFootprint& object, ProcessingSteps options,
                                                  const GlInfo& info) {
  CameraProcessing made;
  made.info_ = &info;
  made.options_ = std::move(options);
  made.object_ = object;
  made.part_ = blocks_around(object.changed);
  const auto live = rectangles_of(live_blocks_of(made.part_, object.changed, object.covered));
  made.blocks_ = PictureMesh::upload({rectangles_of(blocks_of(made.part_, object.changed))});
  made.live_blocks_ = PictureMesh::upload({live});
  for (const PixelBox& box : live) made.live_pixels_.push_back(with_neighbours(box, made.part_, object.picture));
  const auto create_buffer = [&](LayerBuffer& buffer, glm::ivec2 of) -> Result<> {
    auto created = LayerBuffer::create(of.x, of.y, true, info, kWhat);
    if (!created) return fail(created.error());
    buffer = std::move(*created);
    return {};
  };
  const glm::ivec2 size = made.size();
  if (auto done = create_buffer(made.composite_, size); !done) return fail(done.error());
  if (made.options_.sharpening > 0.0)
    if (auto done = create_buffer(made.camera_, size); !done) return fail(done.error());
  if (!made.options_.jpeg) return made;
  if (made.options_.sharpening > 0.0)
    if (auto done = create_buffer(made.sharpened_, size); !done) return fail(done.error());
  for (std::size_t i = 0; i < 2; ++i) {
    if (auto done = create_buffer(made.luma_[i], made.luma_size()); !done) return fail(done.error());
    if (auto done = create_buffer(made.chroma_[i], size / made.options_.shared_pixels); !done)
      return fail(done.error());
  }
  made.steps_ = upload_steps(*made.options_.jpeg);
  return made;
}

bool CameraProcessing::is_for(const ObjectFootprint& object, const ProcessingSteps& options) const {
  const auto same_steps = [&] {
    return options.jpeg && options_.jpeg ? *options.jpeg == *options_.jpeg : options.jpeg == options_.jpeg;
  };
  return object == object_ && options.sharpening == options_.sharpening &&
         options.shared_pixels == options_.shared_pixels && same_steps();
}

void CameraProcessing::forget() {
  for (Done& done : done_) done.look.reset();
}

Result<> CameraProcessing::apply(const std::optional<ObjectLook>& look, Programs& programs, const Drawing& draw_camera,
                                 const Drawing& draw_composite) {
  newest_ = look && !look->noise.none() ? look->noise.pattern % kNoisePatterns : 0;
  Done& done = done_[newest_];
  only_live_ = look && done.look && look_alike(*look, *done.look);
  if (!only_live_) done.look.reset();
  if (done.picture.texture.name() == 0) {
    auto made = LayerBuffer::create(size().x, size().y, true, *info_, kWhat);
    if (!made) return fail(made.error());
    done.picture = std::move(*made);
  }
  const auto draw = [&](const LayerBuffer& buffer, const Drawing& drawing) {
    glBindFramebuffer(GL_FRAMEBUFFER, buffer.framebuffer.name());
    return drawing(only_live_ ? &live_pixels_ : nullptr);
  };
  if (auto drawn = draw(composite_, draw_composite); !drawn) return drawn;
  const bool sharpens = options_.sharpening > 0.0;
  if (sharpens) {
    if (auto drawn = draw(camera_, draw_camera); !drawn) return drawn;
    if (auto drawn = sharpen(programs, options_.jpeg ? sharpened_ : done.picture); !drawn) return drawn;
  }
  if (options_.jpeg)
    if (auto drawn = round_blocks(programs, sharpens ? sharpened_ : composite_, done.picture); !drawn) return drawn;
  if (!only_live_) done.look = look;
  return check_gl(kWhat);
}

void CameraProcessing::draw_into(const LayerBuffer& buffer, glm::ivec2 buffer_size, const Program& program) const {
  program.set("part", glm::dvec2(size()));
  glBindFramebuffer(GL_FRAMEBUFFER, buffer.framebuffer.name());
  glViewport(0, 0, buffer_size.x, buffer_size.y);
  (only_live_ ? live_blocks_ : blocks_)->draw(CutArea::plain);
}

// Of the picture's last pixel in the part, as a texture's coordinates.
glm::dvec2 CameraProcessing::last_place() const {
  return (glm::dvec2(object_.picture - glm::ivec2{part_.left, part_.top}) - 0.5) / glm::dvec2(size());
}

Result<> CameraProcessing::sharpen(Programs& programs, const LayerBuffer& sharpened) const {
  const auto program = programs.find(ProgramKind::sharpen, {});
  if (!program) return fail(program.error());
  (*program)->use();
  bind_to(kPlaneUnit, camera_.texture, TextureFilter::linear);
  bind_to(kLayerUnit, composite_.texture, TextureFilter::linear);
  (*program)->set("camera", kPlaneUnit);
  (*program)->set("composite", kLayerUnit);
  (*program)->set("texel", 1.0 / glm::dvec2(size()));
  (*program)->set("last_place", last_place());
  (*program)->set("amount", options_.sharpening);
  draw_into(sharpened, size(), **program);
  return {};
}

Result<> CameraProcessing::pass(Programs& programs, const Defines& defines, const LayerBuffer& from,
                                glm::ivec2 from_size, Along along, bool chroma, const LayerBuffer& to) const {
  const auto program = programs.find(ProgramKind::jpeg, defines);
  if (!program) return fail(program.error());
  const Program& p = **program;
  p.use();
  bind_to(kLayerUnit, from.texture,
          chroma && defines.contains("FROM_CHROMA") ? TextureFilter::linear : TextureFilter::nearest);
  p.set("values", kLayerUnit);
  p.set("texel", 1.0 / glm::dvec2(from_size));
  p.set("along", along == Along::rows ? glm::dvec2{1.0, 0.0} : glm::dvec2{0.0, 1.0});
  p.set("shared_pixels", glm::dvec2(options_.shared_pixels));
  p.set("last_place", last_place());
  bind_to(kDitherUnit, steps_, TextureFilter::nearest);
  p.set("steps", kDitherUnit);
  p.set("step_columns", chroma ? glm::dvec2(kSteps, kSteps) : glm::dvec2(0.0, 0.5 * kSteps));
  draw_into(to, chroma ? size() / options_.shared_pixels : luma_size(), p);
  return {};
}

Result<> CameraProcessing::round_blocks(Programs& programs, const LayerBuffer& picture,
                                        const LayerBuffer& rounded) const {
  const auto luma = [&](const Defines& defines, const LayerBuffer& from, glm::ivec2 from_size, Along along,
                        const LayerBuffer& to) { return pass(programs, defines, from, from_size, along, false, to); };
  const auto chroma = [&](const Defines& defines, const LayerBuffer& from, glm::ivec2 from_size, Along along,
                          const LayerBuffer& to) { return pass(programs, defines, from, from_size, along, true, to); };
  const glm::ivec2 lumas = luma_size(), chromas = size() / options_.shared_pixels;
  if (auto done = luma({"FORWARD", "FROM_LUMA"}, picture, size(), Along::rows, luma_[0]); !done) return done;
  if (auto done = luma({"FORWARD", "ROUNDED"}, luma_[0], lumas, Along::columns, luma_[1]); !done) return done;
  if (auto done = luma({"INVERSE"}, luma_[1], lumas, Along::columns, luma_[0]); !done) return done;
  if (auto done = chroma({"FORWARD", "FROM_CHROMA"}, picture, size(), Along::rows, chroma_[0]); !done) return done;
  if (auto done = chroma({"FORWARD", "ROUNDED"}, chroma_[0], chromas, Along::columns, chroma_[1]); !done) return done;
  if (auto done = chroma({"INVERSE"}, chroma_[1], chromas, Along::columns, chroma_[0]); !done) return done;
  if (auto done = chroma({"INVERSE"}, chroma_[0], chromas, Along::rows, chroma_[1]); !done) return done;
  const auto program = programs.find(ProgramKind::jpeg, {});
  if (!program) return fail(program.error());
  const Program& p = **program;
  p.use();
  bind_to(kLayerUnit, luma_[0].texture, TextureFilter::nearest);
  bind_to(kPlaneUnit, chroma_[1].texture, TextureFilter::nearest);
  p.set("values", kLayerUnit);
  p.set("chroma", kPlaneUnit);
  p.set("texel", 1.0 / glm::dvec2(lumas));
  p.set("chroma_texel", 1.0 / glm::dvec2(chromas));
  p.set("shared_pixels", glm::dvec2(options_.shared_pixels));
  bind_to(kNoiseUnit, picture.texture, TextureFilter::nearest);
  p.set("picture", kNoiseUnit);
  p.set("picture_texel", 1.0 / glm::dvec2(size()));
  draw_into(rounded, size(), p);
  return {};
}

void CameraProcessing::bind(const Program& program, bool smooth) const {
  bind_to(kNoiseUnit, done_[newest_].picture.texture, smooth ? TextureFilter::linear : TextureFilter::nearest);
  program.set("processed", kNoiseUnit);
  program.set("processed_place",
              glm::dvec4(part_.left, part_.top, 1.0 / (part_.right - part_.left), 1.0 / (part_.bottom - part_.top)));
}

}  // namespace kasumi
