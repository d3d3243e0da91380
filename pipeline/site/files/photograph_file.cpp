#include "pipeline/site/files/photograph_file.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <iterator>
#include <span>

#include <opencv2/imgproc.hpp>

#include "base/files.hpp"
#include "base/fits_header.hpp"
#include "base/picture_files/embedded_tags.hpp"
#include "base/picture_files/other_kinds.hpp"
#include "base/picture_files/picture_file.hpp"
#include "base/picture_files/rare_files.hpp"
#include "base/picture_files/tiff_directory.hpp"
#include "base/picture_files/upright_picture.hpp"
#include "base/picture_header.hpp"
#include "capture/codec/encode.hpp"
#include "capture/codec/jpeg.hpp"
#include "pipeline/site/files/archive_members.hpp"
#include "pipeline/site/files/picture_origin.hpp"

namespace kasumi {

namespace {

bool is_jpeg(std::span<const std::uint8_t> bytes) {
  return bytes.size() > 2 && bytes[0] == 0xFF && bytes[1] == 0xD8;
}

Result<UprightPicture> decode_file(const std::filesystem::path& path, std::string* damage, TakenAt* taken) {
  const auto bytes = read_picture_bytes(path);
  if (!bytes) return fail(bytes.error());
  if (const auto other = other_kind(*bytes); !other.empty())
    return fail(FaultKind::bad_input, "{}: {}", path.string(), other);
  const auto header = picture_header(*bytes);
  if (header)
    if (auto bounded = check_size(*header, kPhotographLimits); !bounded)
      return fail(FaultKind::bad_input, "{}: {}", path.string(), bounded.error().message);
  UprightPicture image;
  if (header) {
    auto decoded = decode_upright_picture(*header, *bytes);
    if (!decoded) return fail(decoded.error().kind, "{}: {}", path.string(), decoded.error().message);
    image = std::move(*decoded);
  }
  if (image.picture.empty())
    return fail(FaultKind::bad_input,
                "{}: not a picture that can be read: expected PNG, JPEG, TIFF, WebP, HEIC, PNM or FITS", path.string());
  if (taken) *taken = is_fits(*bytes) ? taken_at(*bytes) : taken_by_exif(image.exif);
  // Decoders make grey of what is missing, without a word.
  if (damage) damage->clear();
  if (is_jpeg(*bytes) && !image.whole)
    if (const auto whole = check_jpeg(*bytes); !whole) {
      if (!damage) return fail(FaultKind::bad_input, "{}: {}", path.string(), whole.error().message);
      *damage = whole.error().message;
    }
  return image;
}

template <class T>
Image<glm::vec<3, T>> rounded(const Image<glm::vec3>& encoded, float largest) {
  Image<glm::vec<3, T>> picture(encoded.width(), encoded.height());
  for (std::size_t i = 0; i < encoded.elements().size(); ++i)
    for (const int c : {0, 1, 2})
      picture.elements()[i][c] =
          static_cast<T>(std::lround(largest * std::clamp(encoded.elements()[i][c], 0.0F, 1.0F)));
  return picture;
}

// The TIFF with an ICC profile and EXIF's directories, of which OpenCV writes none: its own directory is written once
// more at the end. `exif`: little-endian, as OpenCV's TIFFs are.
std::vector<std::uint8_t> with_tags(std::vector<std::uint8_t> tiff, std::vector<std::uint8_t> profile,
                                    const std::vector<std::uint8_t>& exif) {
  const auto start = tiff_start(tiff);
  if (!start || start->is_big_endian) return tiff;
  auto entries = read_tiff_directory(tiff, start->directory, false);
  constexpr std::uint16_t kUndefined = 7;
  const auto profile_size = static_cast<std::uint32_t>(profile.size());
  if (profile_size > 0) entries.push_back({kTiffProfile, kUndefined, profile_size, std::move(profile)});
  if (const auto origin = tiff_start(exif); origin && !origin->is_big_endian)
    std::ranges::move(copy_exif(exif, read_tiff_directory(exif, origin->directory, false), tiff, false),
                      std::back_inserter(entries));
  set_first_directory(tiff, append_tiff_directory(tiff, std::move(entries), false), false);
  return tiff;
}

template <class T>
Result<std::vector<std::uint8_t>> encode_tiff(const Image<glm::vec<3, T>>& picture, const PngChunks& marks) {
  const auto files = rare_files();
  if (!files) return fail(files.error());
  const cv::Mat rgb(picture.height(), picture.width(), CV_MAKETYPE(cv::DataType<T>::depth, 3),
                    const_cast<glm::vec<3, T>*>(picture.elements().data()));
  cv::Mat bgr;
  std::vector<std::uint8_t> bytes;
  try {
    cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
    if (!(*files)->encode(".tiff", bgr, bytes)) return fail(FaultKind::io, "not by this machine's OpenCV");
  } catch (const cv::Exception& error) {
    return fail(FaultKind::io, "{}", error.err);
  }
  return with_tags(std::move(bytes), (*files)->srgb_profile(), marks.exif);
}

// Behind JFIF's own segment, or first.
Result<std::vector<std::uint8_t>> with_exif(Result<std::vector<std::uint8_t>> jpeg,
                                            const std::vector<std::uint8_t>& exif) {
  constexpr std::size_t kMostInSegment = 65535 - 8;
  if (!jpeg || jpeg->size() < 6 || exif.empty() || exif.size() > kMostInSegment) return jpeg;
  const bool jfif = (*jpeg)[3] == 0xe0;
  const std::size_t at = jfif ? 4 + std::size_t{(*jpeg)[4]} * 256 + (*jpeg)[5] : 2, length = exif.size() + 8;
  std::vector<std::uint8_t> segment{
      0xff, 0xe1, static_cast<std::uint8_t>(length >> 8), static_cast<std::uint8_t>(length), 'E', 'x', 'i', 'f', 0, 0};
  segment.insert(segment.end(), exif.begin(), exif.end());
  jpeg->insert(jpeg->begin() + static_cast<std::ptrdiff_t>(std::min(at, jpeg->size())), segment.begin(), segment.end());
  return jpeg;
}

}  // namespace

Result<Photograph> read_photograph(const std::filesystem::path& path, std::string* damage, TakenAt* taken) {
  const auto seen = decode_file(path, damage, taken);
  if (!seen) return fail(seen.error());
  const cv::Mat* image = &seen->picture;
  cv::Mat rgb;
  switch (image->channels()) {
    case 1: cv::cvtColor(*image, rgb, cv::COLOR_GRAY2RGB); break;
    case 3: rgb = *image; break;
    case 4: cv::cvtColor(*image, rgb, cv::COLOR_RGBA2RGB); break;
    default: return fail(FaultKind::bad_input, "{}: {} channels, expected 1, 3 or 4", path.string(), image->channels());
  }

  Photograph photograph;
  photograph.quantum = seen->quantum;
  photograph.origin = time_and_place(seen->exif);
  double scale = 1.0;
  switch (rgb.depth()) {
    case CV_8U: scale = 1.0 / 255.0; break;
    case CV_16U: scale = 1.0 / 65535.0; break;
    case CV_32F:
    case CV_64F: {
      if (seen->is_converted) break;
      double largest = 0.0;
      cv::patchNaNs(rgb, 0.0);
      cv::minMaxLoc(rgb.reshape(1), nullptr, &largest);
      scale = largest > 0.0 && std::isfinite(largest) ? 1.0 / largest : 1.0;
      break;
    }
    default: return fail(FaultKind::bad_input, "{}: expected 8 or 16 bits or floating point", path.string());
  }
  photograph.encoded = Image<glm::vec3>(rgb.cols, rgb.rows);
  cv::Mat target(rgb.rows, rgb.cols, CV_32FC3, photograph.encoded.elements().data());
  rgb.convertTo(target, CV_32FC3, scale);
  if (image->channels() == 4 && photograph.quantum > 0.0) {
    photograph.opacity = Image<float>(rgb.cols, rgb.rows);
    cv::Mat alpha, opacity(rgb.rows, rgb.cols, CV_32FC1, photograph.opacity.elements().data());
    cv::extractChannel(*image, alpha, 3);
    alpha.convertTo(opacity, CV_32FC1, scale);
  }
  return photograph;
}

Result<> write_photograph(const std::filesystem::path& path, const Photograph& photograph) {
  auto extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const bool jpeg = extension == ".jpg" || extension == ".jpeg";
  if (!jpeg && extension != ".png" && extension != ".tif" && extension != ".tiff")
    return fail(FaultKind::bad_input, "{}: expected a name that ends in .png, .jpg or .tiff", path.string());
  const bool fine = !jpeg && photograph.quantum < 1.0 / 255.0;
  const PngChunks marks{true, time_and_place(photograph.origin, jpeg)};
  const auto& encoded = photograph.encoded;
  if (encoded.empty()) return fail(FaultKind::bad_input, "{}: the picture is empty", path.string());
  constexpr int kJpegQuality = 95;
  const auto encode = [&]() -> Result<std::vector<std::uint8_t>> {
    const bool tiff = !jpeg && extension != ".png";
    if (fine) {
      const auto picture = rounded<std::uint16_t>(encoded, 65535.0F);
      return tiff ? encode_tiff(picture, marks) : encode_png(picture, marks);
    }
    const auto picture = rounded<std::uint8_t>(encoded, 255.0F);
    if (jpeg) return with_exif(encode_jpeg(picture, kJpegQuality, ChromaSubsampling::s420), marks.exif);
    return tiff ? encode_tiff(picture, marks) : encode_png(picture, marks);
  };
  const auto bytes = encode();
  if (!bytes) return fail(bytes.error().kind, "{}: cannot be encoded: {}", path.string(), bytes.error().message);
  return write_file(path, *bytes);
}

}  // namespace kasumi
