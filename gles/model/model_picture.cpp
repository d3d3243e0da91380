#include "gles/model/model_picture.hpp"

#include <algorithm>
#include <array>
#include <cstring>

#include "base/picture_files/picture_file.hpp"
#include "gles/model/rare_models.hpp"

namespace kasumi {

namespace {

std::uint8_t in_8_bits(const DecodedFile& file, std::size_t sample) {
  if (file.bits == 8) return file.samples[sample];
  std::uint16_t value = 0;
  std::memcpy(&value, file.samples.data() + 2 * sample, sizeof value);
  return static_cast<std::uint8_t>((value + 128) / 257);
}

// Basis Universal's textures: no photograph comes in one, so that base/picture_header.hpp does not know it.
std::optional<PictureHeader> ktx2_header(std::span<const std::uint8_t> file) {
  constexpr std::string_view kBegins = "\xabKTX 20\xbb\r\n\x1a\n";
  if (file.size() < 28 || std::memcmp(file.data(), kBegins.data(), kBegins.size()) != 0) return std::nullopt;
  const auto at = [&](std::size_t place) {
    std::int64_t value = 0;
    for (std::size_t i = 4; i-- > 0;) value = value << 8 | file[place + i];
    return value;
  };
  return PictureHeader{"KTX2", at(20), at(24)};
}

}  // namespace

Result<PictureHeader> model_picture_size(std::span<const std::uint8_t> file, int largest) {
  auto header = picture_header(file);
  if (!header) header = ktx2_header(file);
  constexpr std::array<std::string_view, 4> kRead{"PNG", "JPEG", "WebP", "KTX2"};
  if (!header || std::ranges::find(kRead, header->format) == kRead.end())
    return fail(FaultKind::bad_input, "neither a PNG nor a JPEG nor a WebP nor a KTX2");
  if (auto bounded = check_size(*header, {largest, kPhotographLimits.pixels}); !bounded) return fail(bounded.error());
  return *header;
}

Result<Image<glm::u8vec4>> decode_picture(std::span<const std::uint8_t> file, int largest) {
  const auto header = model_picture_size(file, largest);
  if (!header) return fail(header.error());
  if (header->format == "WebP" || header->format == "KTX2") {
    const auto models = rare_models();
    if (!models) return fail(models.error());
    const int width = static_cast<int>(header->width), height = static_cast<int>(header->height);
    return header->format == "WebP" ? (*models)->webp_picture(file, width, height)
                                    : (*models)->ktx2_picture(file, width, height);
  }
  const auto decoded = header->format == "PNG" ? decode_png(file) : decode_jpeg_file(file);
  if (!decoded)  // four colours are the file's fault
    return fail(decoded.error().kind == FaultKind::unsupported ? FaultKind::bad_input : decoded.error().kind, "{}",
                decoded.error().message);
  const bool grey = decoded->channels == 1;
  Image<glm::u8vec4> image(decoded->width, decoded->height);
  std::size_t at = 0;
  for (glm::u8vec4& texel : image.elements()) {
    for (const int c : {0, 1, 2}) texel[c] = in_8_bits(*decoded, at + static_cast<std::size_t>(grey ? 0 : c));
    texel.a = decoded->channels == 4 ? in_8_bits(*decoded, at + 3) : 255;
    at += static_cast<std::size_t>(decoded->channels);
  }
  return image;
}

}  // namespace kasumi
