#include "gles/object/camera_processing.hpp"

#include <algorithm>

#include "gles/gl/gl.hpp"
#include "gles/gl/texture_units.hpp"

namespace kasumi {
namespace {

constexpr int kBlock = 16;  // pixels of a colour difference's 8 x 8 block, at most
constexpr int kSteps = 8;   // of a block's coefficients, each way

// Whole blocks around the changed pixels and their neighbours.
PixelBox blocks_around(const PixelBox& changed) {
  const auto down = [](int pixel) { return std::max(pixel - 1, 0) / kBlock * kBlock; };
  const auto up = [](int pixel) { return (pixel + kBlock) / kBlock * kBlock; };
  return {down(changed.left), down(changed.top), up(changed.right), up(changed.bottom)};
}

// Steps above 255 levels leave nothing, as 255 does.
GlTexture upload_steps(const JpegSteps& steps) {
  std::array<std::uint8_t, 2 * kSteps * kSteps> texels{};
  for (std::size_t i = 0; i < steps.luma.size(); ++i) {
    const std::size_t at = i / kSteps * 2 * kSteps + i % kSteps;
    texels[at] = static_cast<std::uint8_t>(std::clamp<int>(steps.luma[i], 1, 255));
    texels[at + kSteps] = static_cast<std::uint8_t>(std::clamp<int>(steps.chroma[i], 1, 255));
  }
  GlTexture texture = make_texture();
  glActiveTexture(GL_TEXTURE0 + kDitherUnit);
  glBindTexture(GL_TEXTURE_2D, texture.name());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_LUMINANCE, 2 * kSteps, kSteps, 0, GL_LUMINANCE, GL_UNSIGNED_BYTE, texels.data());
  set_filter(TextureFilter::nearest);
  clamp_to_edge();
  return texture;
}

void bind_to(int unit, const GlTexture& texture, TextureFilter filter) {
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  glBindTexture(GL_TEXTURE_2D, texture.name());
  set_filter(filter);
}

void draw_into(const LayerBuffer& buffer, glm::ivec2 size) {
  glBindFramebuffer(GL_FRAMEBUFFER, buffer.framebuffer.name());
  glViewport(0, 0, size.x, size.y);
  draw_square();
}

}  // namespace

Result<CameraProcessing> CameraProcessing::create(const PixelBox& changed, glm::ivec2 picture,
                                                  ProcessingOptions options, const GlInfo& info) {
  CameraProcessing made;
  made.options_ = std::move(options);
  made.changed_ = changed;
  made.part_ = blocks_around(changed);
  made.picture_ = picture;
  const auto create_buffer = [&](LayerBuffer& buffer, glm::ivec2 of) -> Result<> {
    auto created = LayerBuffer::create(of.x, of.y, true, info, "the camera's processing");
    if (!created) return fail(created.error());
    buffer = std::move(*created);
    return {};
  };
  const glm::ivec2 size = made.size();
  if (auto done = create_buffer(made.result_, size); !done) return fail(done.error());
  if (made.options_.sharpening > 0.0)
    for (LayerBuffer* each : {&made.camera_, &made.sharpened_})
      if (auto done = create_buffer(*each, size); !done) return fail(done.error());
  if (!made.options_.jpeg) return made;
  for (std::size_t i = 0; i < 2; ++i) {
    if (auto done = create_buffer(made.luma_[i], size); !done) return fail(done.error());
    if (auto done = create_buffer(made.chroma_[i], size / made.options_.shared_pixels); !done)
      return fail(done.error());
  }
  made.steps_ = upload_steps(*made.options_.jpeg);
  return made;
}

bool CameraProcessing::is_for(const PixelBox& changed, glm::ivec2 picture, const ProcessingOptions& options) const {
  const auto same_steps = [&] {
    return options.jpeg && options_.jpeg ? *options.jpeg == *options_.jpeg : options.jpeg == options_.jpeg;
  };
  return changed == changed_ && picture == picture_ && options.sharpening == options_.sharpening &&
         options.shared_pixels == options_.shared_pixels && same_steps();
}

Result<> CameraProcessing::apply(Programs& programs, const std::function<Result<>()>& draw_camera,
                                 const std::function<Result<>()>& draw_composite) {
  const auto draw = [&](const LayerBuffer& buffer, const std::function<Result<>()>& drawing) {
    glBindFramebuffer(GL_FRAMEBUFFER, buffer.framebuffer.name());
    return drawing();
  };
  if (auto drawn = draw(result_, draw_composite); !drawn) return drawn;
  if (options_.sharpening > 0.0) {
    if (auto drawn = draw(camera_, draw_camera); !drawn) return drawn;
    if (auto done = sharpen(programs); !done) return done;
  }
  if (options_.jpeg)
    if (auto done = round_blocks(programs); !done) return done;
  return check_gl("the camera's processing");
}

// Of the picture's last pixel in the part, as a texture's coordinates.
glm::dvec2 CameraProcessing::last_place() const {
  return (glm::dvec2(picture_ - glm::ivec2{part_.left, part_.top}) - 0.5) / glm::dvec2(size());
}

Result<> CameraProcessing::sharpen(Programs& programs) {
  const auto program = programs.find(ProgramKind::sharpen, {});
  if (!program) return fail(program.error());
  (*program)->use();
  bind_to(kPlaneUnit, camera_.texture, TextureFilter::linear);
  bind_to(kLayerUnit, result_.texture, TextureFilter::linear);
  (*program)->set("camera", kPlaneUnit);
  (*program)->set("composite", kLayerUnit);
  (*program)->set("texel", 1.0 / glm::dvec2(size()));
  (*program)->set("last_place", last_place());
  (*program)->set("amount", options_.sharpening);
  draw_into(sharpened_, size());
  std::swap(result_, sharpened_);
  return {};
}

// From the picture in result_ to the values in luma_[1] or chroma_[1].
Result<> CameraProcessing::transform(Programs& programs, std::string_view source, bool chroma) const {
  const auto& buffers = chroma ? chroma_ : luma_;
  const glm::ivec2 shared = chroma ? options_.shared_pixels : glm::ivec2{1, 1};
  const glm::ivec2 values = size() / shared;
  const glm::dvec2 across{1.0, 0.0}, down{0.0, 1.0};
  const auto pass = [&](const Defines& defines, const LayerBuffer& from, glm::ivec2 from_size, const glm::dvec2& along,
                        const LayerBuffer& to) -> Result<> {
    const auto program = programs.find(ProgramKind::jpeg, defines);
    if (!program) return fail(program.error());
    (*program)->use();
    bind_to(kLayerUnit, from.texture, chroma && &from == &result_ ? TextureFilter::linear : TextureFilter::nearest);
    (*program)->set("values", kLayerUnit);
    (*program)->set("texel", 1.0 / glm::dvec2(from_size));
    (*program)->set("along", along);
    (*program)->set("shared_pixels", glm::dvec2(shared));
    (*program)->set("last_place", last_place());
    bind_to(kDitherUnit, steps_, TextureFilter::nearest);
    (*program)->set("steps", kDitherUnit);
    (*program)->set("first_step", chroma ? double(kSteps) : 0.0);
    draw_into(to, values);
    return {};
  };
  if (auto done = pass({"FORWARD", std::string(source)}, result_, size(), across, buffers[0]); !done) return done;
  if (auto done = pass({"FORWARD", "ROUNDED"}, buffers[0], values, down, buffers[1]); !done) return done;
  if (auto done = pass({"INVERSE"}, buffers[1], values, down, buffers[0]); !done) return done;
  return pass({"INVERSE"}, buffers[0], values, across, buffers[1]);
}

Result<> CameraProcessing::round_blocks(Programs& programs) {
  if (auto done = transform(programs, "FROM_LUMA", false); !done) return done;
  if (auto done = transform(programs, "FROM_CHROMA", true); !done) return done;
  const auto program = programs.find(ProgramKind::jpeg, {});
  if (!program) return fail(program.error());
  (*program)->use();
  bind_to(kLayerUnit, luma_[1].texture, TextureFilter::nearest);
  bind_to(kPlaneUnit, chroma_[1].texture, TextureFilter::nearest);
  (*program)->set("values", kLayerUnit);
  (*program)->set("chroma", kPlaneUnit);
  (*program)->set("texel", 1.0 / glm::dvec2(size()));
  draw_into(result_, size());
  return {};
}

void CameraProcessing::bind(const Program& program, bool smooth) const {
  bind_to(kNoiseUnit, result_.texture, smooth ? TextureFilter::linear : TextureFilter::nearest);
  program.set("processed", kNoiseUnit);
  program.set("processed_place",
              glm::dvec4(part_.left, part_.top, 1.0 / (part_.right - part_.left), 1.0 / (part_.bottom - part_.top)));
}

}  // namespace kasumi
