#include "gles/gl/surface_texture.hpp"

#include <algorithm>
#include <bit>

#include "gles/gl/gl.hpp"

namespace kasumi {
namespace {

constexpr GLenum kSrgb8Alpha8 = 0x8C43;                                    // GLES 3 and EXT_sRGB
constexpr GLenum kMaxAnisotropy = 0x84FF, kTextureMaxAnisotropy = 0x84FE;  // EXT_texture_filter_anisotropic
constexpr std::size_t kSliceBytes = std::size_t{4} << 20;                  // some milliseconds on the slowest machines
// Software GL allocates a texture and its smaller levels at once: more than a tenth of a second for 4096 x 4096 texels,
// in which the picture stands still. On the screens that it can fill so many texels would hardly be visible.
constexpr int kLargestInSoftware = 2048;

GLint wrap_mode(TextureWrap wrap) {
  switch (wrap) {
    case TextureWrap::clamp: return GL_CLAMP_TO_EDGE;
    case TextureWrap::mirrored_repeat: return GL_MIRRORED_REPEAT;
    case TextureWrap::repeat: break;
  }
  return GL_REPEAT;
}

int power_of_two_within(int size) {
  return static_cast<int>(std::bit_floor(static_cast<unsigned>(size)));
}

bool fits(const Image<glm::u8vec4>& picture, const GlInfo& info) {
  const int most = info.software ? std::min(info.max_texture_size, kLargestInSoftware) : info.max_texture_size;
  return picture.width() <= most && picture.height() <= most;
}

}  // namespace

SurfaceTextureUpload::SurfaceTextureUpload(const ModelTexture& texture, std::optional<double> cutoff,
                                           const GlInfo& info, bool force_encoded, std::vector<std::string>& notes)
    : texture_(texture),
      // Software drivers blur and are slow at it.
      anisotropic_(!info.software && info.has("GL_EXT_texture_filter_anisotropic")) {
  gather_levels(cutoff, info);
  const auto& given = texture.pixels;
  if (level().width() != given.width() || level().height() != given.height()) {
    const bool for_software = info.software && std::max(given.width(), given.height()) > kLargestInSoftware;
    notes.push_back(fmt::format(
        "texture of {} x {} reduced to {} x {}, {}", given.width(), given.height(), level().width(), level().height(),
        for_software ? "the largest that is used without a GPU" : "a size that the driver supports"));
  }
  // EXT_sRGB on GLES 2 does not support mipmaps, so only version 3's sRGB textures are used.
  made_.decodes = !force_encoded && info.es_major >= 3 && !texture.data;
  made_.data = texture.data;
  format_ = made_.decodes ? kSrgb8Alpha8 : static_cast<unsigned>(GL_RGBA);
}

void SurfaceTextureUpload::gather_levels(std::optional<double> cutoff, const GlInfo& info) {
  levels_.push_back(&texture_.pixels);
  const auto largest = [&]() -> const Image<glm::u8vec4>& { return *levels_.front(); };
  for (const auto& smaller : texture_.smaller) levels_.push_back(&smaller);
  while (levels_.size() > 1 && !fits(largest(), info)) levels_.erase(levels_.begin());
  const auto use_own = [&](Image<glm::u8vec4> picture) {
    own_.clear();
    own_.push_back(std::move(picture));
    levels_ = {&own_.front()};
  };
  while (!fits(largest(), info)) use_own(halved(largest(), texture_.data));
  if (info.es_major < 3 && !info.has("GL_OES_texture_npot")) {
    const int width = power_of_two_within(largest().width()), height = power_of_two_within(largest().height());
    if (width != largest().width() || height != largest().height())
      use_own(shrunk(largest(), width, height, texture_.data));
  }
  if (levels_.size() > 1 || (largest().width() == 1 && largest().height() == 1)) return;
  auto smaller = smaller_levels(largest(), texture_.data, cutoff);
  const bool own_largest = !own_.empty();
  for (auto& made : smaller) own_.push_back(std::move(made));
  levels_.resize(1);
  if (own_largest) levels_.clear();
  for (const auto& made : own_) levels_.push_back(&made);
}

Result<bool> SurfaceTextureUpload::step() {
  glActiveTexture(GL_TEXTURE0);
  if (!made_.texture) {
    made_.texture = make_texture();
    glBindTexture(GL_TEXTURE_2D, made_.texture.name());
    set_filters();  // first: a driver that knows of the smaller levels takes the memory for all of them once
  }
  glBindTexture(GL_TEXTURE_2D, made_.texture.name());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  for (std::size_t left = kSliceBytes; level_ < levels_.size() && left > 0;) {
    const auto& picture = level();
    const auto number = static_cast<GLint>(level_);
    if (row_ == 0)
      glTexImage2D(GL_TEXTURE_2D, number, static_cast<GLint>(format_), picture.width(), picture.height(), 0, GL_RGBA,
                   GL_UNSIGNED_BYTE, nullptr);
    const std::size_t row_bytes = static_cast<std::size_t>(picture.width()) * sizeof(glm::u8vec4);
    const int rows = std::min(picture.height() - row_, std::max(1, static_cast<int>(left / row_bytes)));
    glTexSubImage2D(GL_TEXTURE_2D, number, 0, row_, picture.width(), rows, GL_RGBA, GL_UNSIGNED_BYTE,
                    picture.row(row_));
    const std::size_t bytes = row_bytes * static_cast<std::size_t>(rows);
    made_.bytes += bytes;
    left -= std::min(left, bytes);
    row_ += rows;
    if (row_ == picture.height()) {
      ++level_;
      row_ = 0;
    }
  }
  if (auto uploaded = check_gl("uploading a texture of the model"); !uploaded) return fail(uploaded.error());
  return level_ == levels_.size();
}

void SurfaceTextureUpload::set_filters() const {
  if (anisotropic_) {
    constexpr GLfloat kMaxUsefulAnisotropy =
        8.0f;  // enough for roofs and courtyards seen at a few degrees; the layer adds 17 samples per pixel
    GLfloat most = 1.0f;
    glGetFloatv(kMaxAnisotropy, &most);
    glTexParameterf(GL_TEXTURE_2D, kTextureMaxAnisotropy, std::min(most, kMaxUsefulAnisotropy));
  }
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, texture_.nearest ? GL_NEAREST : GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, wrap_mode(texture_.wrap_s));
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, wrap_mode(texture_.wrap_t));
}

}  // namespace kasumi
