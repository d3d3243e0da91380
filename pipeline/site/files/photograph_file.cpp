#include "pipeline/site/files/photograph_file.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <span>

#include <opencv2/imgproc.hpp>

#include "base/files.hpp"
#include "base/fits_header.hpp"
#include "base/picture_files/picture_file.hpp"
#include "base/picture_files/rare_files.hpp"
#include "base/picture_files/seen_picture.hpp"
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

Result<SeenPicture> decode_file(const std::filesystem::path& path, std::string* damage, TakenAt* taken) {
  const auto bytes = read_picture_bytes(path);
  if (!bytes) return fail(bytes.error());
  const auto header = picture_header(*bytes);
  if (header)
    if (auto bounded = check_size(*header, kPhotographLimits); !bounded)
      return fail(FaultKind::bad_input, "{}: {}", path.string(), bounded.error().message);
  SeenPicture image;
  if (header) {
    auto decoded = decode_seen_picture(*header, *bytes);
    if (!decoded) return fail(decoded.error().kind, "{}: {}", path.string(), decoded.error().message);
    image = std::move(*decoded);
  }
  if (image.picture.empty())
    return fail(FaultKind::bad_input, "{}: not a picture that can be read (expected PNG, JPEG, TIFF, PNM or FITS)",
                path.string());
  if (taken) *taken = is_fits(*bytes) ? taken_at(*bytes) : taken_by_exif(image.exif);
  // Decoders make grey of what is missing, without a word.
  if (damage) damage->clear();
  if (is_jpeg(*bytes))
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

// The TIFF with an ICC profile. OpenCV writes none: its directory of tags is written once more at the end, with one more.
std::vector<std::uint8_t> with_profile(std::vector<std::uint8_t> tiff, const std::vector<std::uint8_t>& profile) {
  constexpr std::size_t kEntry = 12;
  constexpr std::uint16_t kProfileTag = 34675, kUndefined = 7;
  const auto read = [&](std::size_t at, int bytes) {
    std::size_t value = 0;
    for (int i = 0; i < bytes; ++i) value |= std::size_t{tiff[at + static_cast<std::size_t>(i)]} << 8 * i;
    return value;
  };
  const bool plain = tiff.size() > 8 && read(0, 4) == 0x002a4949;  // "II", little-endian, not BigTIFF
  const std::size_t from = plain ? read(4, 4) : 0, count = plain && from + 2 <= tiff.size() ? read(from, 2) : 0;
  const std::size_t to = from + 2 + kEntry * count;
  if (profile.empty() || count == 0 || to + 4 > tiff.size() || read(to, 4) != 0) return tiff;
  std::size_t before = from + 2;  // the entries that come first: they are in the order of their tags
  while (before < to && read(before, 2) < kProfileTag) before += kEntry;
  std::vector<std::uint8_t> made(tiff);
  const auto put = [&](std::size_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) made.push_back(static_cast<std::uint8_t>(value >> 8 * i));
  };
  const auto copy = [&](std::size_t first, std::size_t last) {
    made.insert(made.end(), tiff.begin() + static_cast<std::ptrdiff_t>(first),
                tiff.begin() + static_cast<std::ptrdiff_t>(last));
  };
  const std::size_t place = made.size();
  made.insert(made.end(), profile.begin(), profile.end());
  if (made.size() % 2 != 0) made.push_back(0);
  const std::size_t directory = made.size();
  put(count + 1, 2);
  copy(from + 2, before);
  put(kProfileTag, 2);
  put(kUndefined, 2);
  put(profile.size(), 4);
  put(place, 4);
  copy(before, to + 4);
  for (std::size_t i = 0; i < 4; ++i) made[4 + i] = static_cast<std::uint8_t>(directory >> 8 * i);
  return made;
}

template <class T>
Result<std::vector<std::uint8_t>> encode_tiff(const Image<glm::vec<3, T>>& picture) {
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
  return with_profile(std::move(bytes), (*files)->srgb_profile());
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
  const PictureMarks marks{true, time_and_place(photograph.origin, jpeg)};
  const auto& encoded = photograph.encoded;
  if (encoded.empty()) return fail(FaultKind::bad_input, "{}: the picture is empty", path.string());
  constexpr int kJpegQuality = 95;
  const auto encode = [&]() -> Result<std::vector<std::uint8_t>> {
    const bool tiff = !jpeg && extension != ".png";
    if (fine) {
      const auto picture = rounded<std::uint16_t>(encoded, 65535.0F);
      return tiff ? encode_tiff(picture) : encode_png(picture, marks);
    }
    const auto picture = rounded<std::uint8_t>(encoded, 255.0F);
    if (jpeg) return with_exif(encode_jpeg(picture, kJpegQuality, ChromaSubsampling::s420), marks.exif);
    return tiff ? encode_tiff(picture) : encode_png(picture, marks);
  };
  const auto bytes = encode();
  if (!bytes) return fail(bytes.error().kind, "{}: cannot be encoded: {}", path.string(), bytes.error().message);
  return write_file(path, *bytes);
}

}  // namespace kasumi
