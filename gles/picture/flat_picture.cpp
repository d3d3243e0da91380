#include "gles/picture/flat_picture.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>

#include "gles/gl/gl.hpp"
#include "gles/gl/program.hpp"
#include "gles/gl/surface_texture.hpp"

namespace kasumi {
namespace {

// Premultiplied, so that filtering does not bleed a transparent pixel's colour into its neighbours.
Image<Rgba8> premultiplied(Image<Rgba8> picture) {
  const auto part = [](int colour, int alpha) { return static_cast<std::uint8_t>((colour * alpha + 127) / 255); };
  for (Rgba8& p : picture.elements()) p = {part(p.r, p.a), part(p.g, p.a), part(p.b, p.a), p.a};
  return picture;
}

bool is_whole(double value) {
  return value == std::floor(value);
}

// One for all flat pictures of a context, as long as any of them is there.
Result<std::shared_ptr<const Program>> program_in(const GlContext& context) {
  thread_local std::map<const GlContext*, std::weak_ptr<const Program>> programs;
  std::erase_if(programs, [](const auto& known) { return known.second.expired(); });
  if (const auto known = programs.find(&context); known != programs.end()) return known->second.lock();
  auto built = Program::build({}, "flat.vert", "flat.frag");
  if (!built) return fail(built.error());
  auto program = std::make_shared<const Program>(std::move(*built));
  programs[&context] = program;
  return program;
}

}  // namespace

struct FlatPicture::State {
  int width = 0;
  int height = 0;
  std::shared_ptr<const Program> program;
  GlTexture texture;
  GlBuffer corners;
  bool has_mipmaps = false;

  // Exact at 1:1 scale; otherwise filtered.
  GLint minifying_filter(const FlatPlace& place) const {
    const double shrink = std::max(width / place.width, height / place.height);
    if (place.width == width && place.height == height && is_whole(place.left) && is_whole(place.top))
      return GL_NEAREST;
    return shrink > 1.5 && has_mipmaps ? GL_LINEAR_MIPMAP_LINEAR : GL_LINEAR;
  }
};

FlatPicture::FlatPicture(std::unique_ptr<State> state) : state_(std::move(state)) {}
FlatPicture::FlatPicture(FlatPicture&&) noexcept = default;
FlatPicture& FlatPicture::operator=(FlatPicture&&) noexcept = default;
FlatPicture::~FlatPicture() = default;

int FlatPicture::width() const {
  return state_->width;
}
int FlatPicture::height() const {
  return state_->height;
}

FlatTexels flat_texels(const Image<Rgba8>& picture, int largest) {
  Image<Rgba8> texels = picture;
  while (texels.width() > largest || texels.height() > largest) texels = halved(texels);
  return {premultiplied(std::move(texels)), picture.width(), picture.height()};
}

Result<FlatPicture> FlatPicture::create(GlContext& context, const Image<Rgba8>& picture) {
  return create(context, flat_texels(picture, context.info().max_texture_size));
}

Result<FlatPicture> FlatPicture::create(GlContext& context, const FlatTexels& given) {
  const Image<Rgba8>& texels = given.premultiplied;
  const GlInfo& info = context.info();
  if (texels.empty()) return fail(FaultKind::bad_input, "a flat picture has no pixels");
  if (texels.width() > info.max_texture_size || texels.height() > info.max_texture_size)
    return fail(FaultKind::bad_input, "a flat picture of {} x {} pixels: this driver supports at most {}",
                texels.width(), texels.height(), info.max_texture_size);
  auto texture = make_texture();
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, texture.name());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA, texels.width(), texels.height(), 0, GL_RGBA, GL_UNSIGNED_BYTE,
               texels.elements().data());
  clamp_to_edge();
  const auto is_power_of_two = [](int size) { return std::has_single_bit(static_cast<unsigned>(size)); };
  const bool has_mipmaps = info.es_major >= 3 || info.has("GL_OES_texture_npot") ||
                           (is_power_of_two(texels.width()) && is_power_of_two(texels.height()));
  if (has_mipmaps) glGenerateMipmap(GL_TEXTURE_2D);
  return of_texture(context, given.width, given.height, std::move(texture), has_mipmaps);
}

Result<FlatPicture> FlatPicture::create(GlContext& context, Offscreen drawn) {
  const auto target = drawn.target();
  glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_TRUE);
  glClearColor(0.0F, 0.0F, 0.0F, 1.0F);
  glClear(GL_COLOR_BUFFER_BIT);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  return of_texture(context, target.width, target.height, std::move(drawn).take_colour(), false);
}

Result<FlatPicture> FlatPicture::of_texture(const GlContext& context, int width, int height, GlTexture texture,
                                            bool has_mipmaps) {
  auto program = program_in(context);
  if (!program) return fail(program.error());
  auto state = std::make_unique<State>(
      State{width, height, std::move(*program), std::move(texture), make_buffer(), has_mipmaps});
  constexpr std::array<float, 8> kCorners{0, 0, 1, 0, 0, 1, 1, 1};
  glBindBuffer(GL_ARRAY_BUFFER, state->corners.name());
  glBufferData(GL_ARRAY_BUFFER, sizeof kCorners, kCorners.data(), GL_STATIC_DRAW);
  glBindBuffer(GL_ARRAY_BUFFER, 0);
  if (auto made = check_gl("uploading a flat picture"); !made) return fail(made.error());
  return FlatPicture(std::move(state));
}

Result<> FlatPicture::draw(const DrawTarget& target, const FlatPlace& place, double opacity) const {
  if (target.width < 1 || target.height < 1)
    return fail(FaultKind::bad_input, "a target of {} x {} pixels: expected at least 1 x 1", target.width,
                target.height);
  if (!(std::isfinite(place.left) && std::isfinite(place.top) && place.width > 0 && place.height > 0 &&
        std::isfinite(place.width) && std::isfinite(place.height)))
    return fail(FaultKind::bad_input, "a flat picture at {}, {} of {} x {} pixels: expected numbers and a size above 0",
                place.left, place.top, place.width, place.height);
  if (!(opacity > 0)) return {};

  const State& s = *state_;
  glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
  glViewport(0, 0, target.width, target.height);
  const Program& program = *s.program;
  program.use();
  const double across = 2.0 / target.width, down = (target.top_row_first ? 2.0 : -2.0) / target.height;
  program.set("place", glm::dvec4{place.left * across - 1.0, place.top * down + (target.top_row_first ? -1.0 : 1.0),
                                  place.width * across, place.height * down});
  program.set("opacity", std::min(opacity, 1.0));
  program.set("picture", 0);
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, s.texture.name());
  const GLint filter = s.minifying_filter(place);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, filter);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter == GL_NEAREST ? GL_NEAREST : GL_LINEAR);

  glEnable(GL_BLEND);
  glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  glBindBuffer(GL_ARRAY_BUFFER, s.corners.name());
  glEnableVertexAttribArray(kPosition);
  glVertexAttribPointer(kPosition, 2, GL_FLOAT, GL_FALSE, 0, nullptr);
  glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
  glDisableVertexAttribArray(kPosition);
  glBindBuffer(GL_ARRAY_BUFFER, 0);
  glDisable(GL_BLEND);
  return check_gl("drawing a flat picture");
}

FlatPlace fitted(const DrawTarget& target, int width, int height) {
  const Letterbox box = letterbox(target, width, height);
  const int top = target.top_row_first ? box.y : target.height - box.y - box.height;
  return {static_cast<double>(box.x), static_cast<double>(top), static_cast<double>(box.width),
          static_cast<double>(box.height)};
}

FlatPlace everywhere(const DrawTarget& target) {
  return {0.0, 0.0, static_cast<double>(target.width), static_cast<double>(target.height)};
}

void clear_to(const DrawTarget& target, const glm::vec3& encoded) {
  glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
  glClearColor(encoded.r, encoded.g, encoded.b, 1.0f);
  glClear(GL_COLOR_BUFFER_BIT);
}

}  // namespace kasumi
