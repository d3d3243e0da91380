#include "pipeline/site/files/small_photograph.hpp"

#include "base/picture_files/embedded_tags.hpp"
#include "base/picture_files/small_jpeg.hpp"
#include "base/picture_header.hpp"
#include "pipeline/site/files/archive_members.hpp"

namespace kasumi {

static_assert(kSmallPhotographShrink == kSmallJpegShrink);

std::optional<SmallPhotograph> read_small_photograph(const std::filesystem::path& path) {
  const auto bytes = read_picture_bytes(path);
  if (!bytes) return std::nullopt;
  const auto header = picture_header(*bytes);
  if (!header || header->format != "JPEG" || !check_size(*header, kPhotographLimits)) return std::nullopt;
  const auto tags = embedded_tags(*header, *bytes);
  if (!tags || tags->orientation != 1 || !tags->profile.empty()) return std::nullopt;
  const auto small = decode_small_jpeg(*bytes);
  if (!small) return std::nullopt;
  SmallPhotograph photograph{Image<glm::vec3>(small->width, small->height), static_cast<int>(header->width),
                             static_cast<int>(header->height), taken_by_exif(tags->exif)};
  const std::uint8_t* sample = small->samples.data();
  for (glm::vec3& pixel : photograph.encoded.elements()) {
    pixel = glm::vec3{sample[0], sample[1], sample[2]} / 255.0f;
    sample += 3;
  }
  return photograph;
}

}  // namespace kasumi
