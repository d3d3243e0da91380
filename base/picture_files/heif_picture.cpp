#include "base/picture_files/heif_picture.hpp"

#include <libheif/heif.h>
#include <opencv2/imgproc.hpp>

#include "base/c_ptr.hpp"
#include "base/picture_files/colour_profile.hpp"

namespace kasumi {

namespace {

using HeifFile = CPtr<heif_context, heif_context_free>;
using HeifItem = CPtr<heif_image_handle, heif_image_handle_release>;
using HeifImage = CPtr<heif_image, heif_image_release>;
using HeifColours = CPtr<heif_color_profile_nclx, heif_nclx_color_profile_free>;

void check_heif(const heif_error& error) {
  if (error.code != heif_error_Ok) CV_Error(cv::Error::StsError, error.message);
}

struct OpenHeif {
  HeifFile file;  // the item's
  HeifItem item;
};

OpenHeif open_heif(std::span<const std::uint8_t> bytes) {
  OpenHeif opened{HeifFile(heif_context_alloc()), nullptr};
  heif_context_set_maximum_image_size_limit(opened.file.get(), static_cast<int>(kPhotographLimits.side_px));
  check_heif(heif_context_read_from_memory_without_copy(opened.file.get(), bytes.data(), bytes.size(), nullptr));
  heif_image_handle* item = nullptr;
  check_heif(heif_context_get_primary_image_handle(opened.file.get(), &item));
  opened.item.reset(item);
  return opened;
}

// Null: the file names none.
HeifColours colours_of(const heif_image_handle* item) {
  heif_color_profile_nclx* colours = nullptr;
  const auto error = heif_image_handle_get_nclx_color_profile(item, &colours);
  return HeifColours(error.code == heif_error_Ok ? colours : nullptr);
}

std::vector<std::uint8_t> profile_of(const heif_image_handle* item) {
  std::vector<std::uint8_t> profile(heif_image_handle_get_raw_color_profile_size(item));
  if (!profile.empty() && heif_image_handle_get_raw_color_profile(item, profile.data()).code == heif_error_Ok)
    return profile;
  const auto colours = colours_of(item);
  if (!colours) return {};
  const glm::vec2 red{colours->color_primary_red_x, colours->color_primary_red_y},
      green{colours->color_primary_green_x, colours->color_primary_green_y},
      blue{colours->color_primary_blue_x, colours->color_primary_blue_y};
  const bool named = colours->color_primaries == heif_color_primaries_SMPTE_EG_432_1 ||  // Display P3
                     colours->color_primaries == heif_color_primaries_ITU_R_BT_2020_2_and_2100_0;
  return named ? profile_of_primaries(red, green, blue) : std::vector<std::uint8_t>();
}

std::vector<std::uint8_t> exif_of(const heif_image_handle* item) {
  constexpr std::size_t kOffset = 4;  // the block begins with where its TIFF does, behind these four
  heif_item_id id = 0;
  if (heif_image_handle_get_list_of_metadata_block_IDs(item, "Exif", &id, 1) != 1) return {};
  std::vector<std::uint8_t> block(heif_image_handle_get_metadata_size(item, id));
  if (block.size() <= kOffset || heif_image_handle_get_metadata(item, id, block.data()).code != heif_error_Ok)
    return {};
  std::size_t skipped = 0;
  for (std::size_t i = 0; i < kOffset; ++i) skipped = skipped << 8 | block[i];
  if (skipped >= block.size() - kOffset) return {};
  return {block.begin() + static_cast<std::ptrdiff_t>(kOffset + skipped), block.end()};
}

}  // namespace

cv::Mat read_heif(std::span<const std::uint8_t> file) {
  const auto opened = open_heif(file);
  const auto* item = opened.item.get();
  const std::int64_t width = heif_image_handle_get_width(item), height = heif_image_handle_get_height(item);
  if (width * height > kPhotographLimits.pixels) CV_Error(cv::Error::StsError, "larger than its header says");
  if (const auto colours = colours_of(item);
      colours && (colours->transfer_characteristics == heif_transfer_characteristic_ITU_R_BT_2100_0_PQ ||
                  colours->transfer_characteristics == heif_transfer_characteristic_ITU_R_BT_2100_0_HLG))
    CV_Error(cv::Error::StsError, "its light is that of HDR displays (PQ or HLG): expected a picture in sRGB");
  const bool fine = heif_image_handle_get_luma_bits_per_pixel(item) > 8;
  const bool clear = heif_image_handle_has_alpha_channel(item) != 0;
  heif_image* decoded = nullptr;
  check_heif(heif_decode_image(item, &decoded, heif_colorspace_RGB,
                               fine ? (clear ? heif_chroma_interleaved_RRGGBBAA_LE : heif_chroma_interleaved_RRGGBB_LE)
                                    : (clear ? heif_chroma_interleaved_RGBA : heif_chroma_interleaved_RGB),
                               nullptr));
  const HeifImage image(decoded);
  int stride = 0;
  auto* samples = heif_image_get_plane(image.get(), heif_channel_interleaved, &stride);
  if (!samples) CV_Error(cv::Error::StsError, "no colours");
  const cv::Mat rgb(heif_image_get_primary_height(image.get()), heif_image_get_primary_width(image.get()),
                    CV_MAKETYPE(fine ? CV_16U : CV_8U, clear ? 4 : 3), samples, static_cast<std::size_t>(stride));
  cv::Mat bgr;
  cv::cvtColor(rgb, bgr, clear ? cv::COLOR_RGBA2BGRA : cv::COLOR_RGB2BGR);
  if (!fine) return bgr;
  const int bits = heif_image_get_bits_per_pixel_range(image.get(), heif_channel_interleaved);
  bgr.convertTo(bgr, CV_16U, 65535.0 / ((1 << bits) - 1));
  return bgr;
}

EmbeddedTags read_heif_tags(std::span<const std::uint8_t> file) {
  EmbeddedTags tags;
  try {
    const auto opened = open_heif(file);
    tags.profile = profile_of(opened.item.get());
    tags.exif = exif_of(opened.item.get());
  } catch (const cv::Exception&) {  // its decoder says so
  }
  return tags;
}

}  // namespace kasumi
