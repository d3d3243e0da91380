#include "gles/object/camera_processing.hpp"

#include <algorithm>

#include "gles/gl/gl.hpp"
#include "gles/gl/texture_units.hpp"
#include "gles/gpu_model/projection.hpp"

namespace kasumi {
namespace {

constexpr int kBlock = 16;  // pixels of a colour difference's 8 x 8 block, at most
constexpr int kSteps = 8;   // of a block's coefficients, each way

PixelBox around(const std::vector<PixelBox>& boxes) {
  PixelBox whole;
  for (const PixelBox& box : boxes) whole = united(whole, box);
  return whole;
}

// Whole blocks around the changed pixels and their neighbours.
PixelBox blocks_around(const PixelBox& changed) {
  const auto down = [](int pixel) { return std::max(pixel - 1, 0) / kBlock * kBlock; };
  const auto up = [](int pixel) { return (pixel + kBlock) / kBlock * kBlock; };
  return {down(changed.left), down(changed.top), up(changed.right), up(changed.bottom)};
}

// The blocks of `part` that hold a changed pixel or its neighbour, row by row, in pixels from the part's corner.
std::vector<PixelBox> blocks_of(const PixelBox& part, const std::vector<PixelBox>& changed) {
  const int columns = (part.right - part.left) / kBlock, rows = (part.bottom - part.top) / kBlock;
  Image<std::uint8_t> taken(columns, rows, 0);
  for (const PixelBox& box : changed) {
    const PixelBox blocks = blocks_around(box);
    for (int y = (blocks.top - part.top) / kBlock; y < std::min((blocks.bottom - part.top) / kBlock, rows); ++y)
      for (int x = (blocks.left - part.left) / kBlock; x < std::min((blocks.right - part.left) / kBlock, columns); ++x)
        taken.at(x, y) = 1;
  }
  std::vector<PixelBox> found;
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns;) {
      const int first = x;
      while (x < columns && taken.at(x, y) == taken.at(first, y)) ++x;
      if (taken.at(first, y)) found.push_back({first * kBlock, y * kBlock, x * kBlock, (y + 1) * kBlock});
    }
  return found;
}

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

Result<CameraProcessing> CameraProcessing::create(const std::vector<PixelBox>& changed, glm::ivec2 picture,
                                                  ProcessingOptions options, const GlInfo& info) {
  CameraProcessing made;
  made.options_ = std::move(options);
  made.changed_ = changed;
  made.part_ = blocks_around(around(changed));
  made.picture_ = picture;
  made.blocks_ = PictureMesh::upload({blocks_of(made.part_, changed)});
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
    if (auto done = create_buffer(made.luma_[i], made.luma_size()); !done) return fail(done.error());
    if (auto done = create_buffer(made.chroma_[i], size / made.options_.shared_pixels); !done)
      return fail(done.error());
  }
  made.steps_ = upload_steps(*made.options_.jpeg);
  return made;
}

bool CameraProcessing::is_for(const std::vector<PixelBox>& changed, glm::ivec2 picture,
                              const ProcessingOptions& options) const {
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

void CameraProcessing::draw_into(const LayerBuffer& buffer, glm::ivec2 buffer_size, const Program& program) const {
  program.set("part", glm::dvec2(size()));
  glBindFramebuffer(GL_FRAMEBUFFER, buffer.framebuffer.name());
  glViewport(0, 0, buffer_size.x, buffer_size.y);
  blocks_->draw(PictureArea::plain);
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
  draw_into(sharpened_, size(), **program);
  std::swap(result_, sharpened_);
  return {};
}

Result<> CameraProcessing::pass(Programs& programs, const Defines& defines, const LayerBuffer& from,
                                glm::ivec2 from_size, Along along, bool chroma, const LayerBuffer& to) const {
  const auto program = programs.find(ProgramKind::jpeg, defines);
  if (!program) return fail(program.error());
  const Program& p = **program;
  p.use();
  bind_to(kLayerUnit, from.texture, chroma && &from == &result_ ? TextureFilter::linear : TextureFilter::nearest);
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

Result<> CameraProcessing::round_blocks(Programs& programs) {
  const auto luma = [&](const Defines& defines, const LayerBuffer& from, glm::ivec2 from_size, Along along,
                        const LayerBuffer& to) { return pass(programs, defines, from, from_size, along, false, to); };
  const auto chroma = [&](const Defines& defines, const LayerBuffer& from, glm::ivec2 from_size, Along along,
                          const LayerBuffer& to) { return pass(programs, defines, from, from_size, along, true, to); };
  const glm::ivec2 lumas = luma_size(), chromas = size() / options_.shared_pixels;
  if (auto done = luma({"FORWARD", "FROM_LUMA"}, result_, size(), Along::rows, luma_[0]); !done) return done;
  if (auto done = luma({"FORWARD", "ROUNDED"}, luma_[0], lumas, Along::columns, luma_[1]); !done) return done;
  if (auto done = luma({"INVERSE"}, luma_[1], lumas, Along::columns, luma_[0]); !done) return done;
  if (auto done = chroma({"FORWARD", "FROM_CHROMA"}, result_, size(), Along::rows, chroma_[0]); !done) return done;
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
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_FALSE);  // alpha still tells which pixels the object changes
  draw_into(result_, size(), p);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  return {};
}

void CameraProcessing::bind(const Program& program, bool smooth) const {
  bind_to(kNoiseUnit, result_.texture, smooth ? TextureFilter::linear : TextureFilter::nearest);
  program.set("processed", kNoiseUnit);
  program.set("processed_place",
              glm::dvec4(part_.left, part_.top, 1.0 / (part_.right - part_.left), 1.0 / (part_.bottom - part_.top)));
}

}  // namespace kasumi
