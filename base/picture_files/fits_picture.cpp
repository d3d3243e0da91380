#include "base/picture_files/fits_picture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <fitsio.h>
#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "base/c_ptr.hpp"
#include "base/picture_header.hpp"

namespace kasumi {
namespace {

constexpr double kFull = 65535.0;

[[noreturn]] void refuse(const std::string& why) {
  throw cv::Exception(cv::Error::StsError, why, "", "", 0);
}

void close_fits(fitsfile* file) {
  int status = 0;
  fits_close_file(file, &status);
}

class FitsImage {
 public:
  explicit FitsImage(std::span<const std::uint8_t> bytes)
      : memory_(const_cast<std::uint8_t*>(bytes.data())), size_(bytes.size()) {  // cfitsio only reads from it
    fitsfile* file = nullptr;
    int status = 0;
    fits_open_memfile(&file, "sky.fits", READONLY, &memory_, &size_, 0, nullptr, &status);
    check(status);
    file_.reset(file);
    int axes = 0;
    std::array<long, 3> sides{0, 0, 1};
    fits_get_img_param(file, static_cast<int>(sides.size()), &bits_, &axes, sides.data(), &status);
    check(status);
    if (axes < 2 || axes > 3 || (axes == 3 && sides[2] != 1 && sides[2] != 3))
      refuse(
          fmt::format("a FITS of NAXIS = {}, NAXIS3 = {}, expected one picture, or three planes in the first "
                      "header (of a compressed one, what funpack makes of it)",
                      axes, axes > 2 ? sides[2] : 0));
    const auto& most = kPhotographLimits;
    if (std::min(sides[0], sides[1]) < 1 || std::max(sides[0], sides[1]) > most.side_px ||
        sides[0] * sides[1] > most.pixels)
      refuse(
          fmt::format("a FITS of NAXIS1 = {}, NAXIS2 = {}, expected 1 .. {} each", sides[0], sides[1], most.side_px));
    width_ = static_cast<int>(sides[0]), height_ = static_cast<int>(sides[1]), planes_ = static_cast<int>(sides[2]);
    // cfitsio reads zeros where a file ends early.
    LONGLONG begin = 0;
    fits_get_hduaddrll(file, nullptr, &begin, nullptr, &status);
    check(status);
    const auto end = begin + std::int64_t{std::abs(bits_)} / 8 * width_ * height_ * planes_;
    if (end > static_cast<std::int64_t>(bytes.size()))
      refuse(
          fmt::format("a FITS of NAXIS1 = {}, NAXIS2 = {}, BITPIX = {} that ends after {} bytes, expected {} at least",
                      width_, height_, bits_, bytes.size(), end));
  }

  int planes() const { return planes_; }

  // Of light, 1 at the brightest.
  std::vector<cv::Mat> read() const {
    std::vector<cv::Mat> all;
    const long long count = std::int64_t{width_} * height_;
    for (int plane = 0; plane < planes_; ++plane) {
      cv::Mat picture(height_, width_, CV_32F);
      int status = 0, any_missing = 0;
      float missing = 0.0F;
      fits_read_img(file_.get(), TFLOAT, 1 + plane * count, count, &missing, picture.data, &any_missing, &status);
      check(status);
      cv::patchNaNs(picture, 0.0);
      all.push_back(picture);
    }
    const auto given = white();
    double largest = given.value_or(0.0);
    for (const auto& picture : all) {
      double most = 0.0;
      if (!given) cv::minMaxLoc(picture, nullptr, &most);
      largest = std::max(largest, most);
    }
    if (!std::isfinite(largest) || largest <= 0.0) refuse("a FITS without any light");
    for (auto& picture : all) picture *= 1.0 / largest;
    return all;
  }

  std::string word(const char* keyword) const {
    std::array<char, FLEN_VALUE> text{};
    int status = 0;
    return fits_read_key(file_.get(), TSTRING, keyword, text.data(), nullptr, &status) == 0 ? text.data() : "";
  }
  std::optional<double> number(const char* keyword) const {
    double value = 0.0;
    int status = 0;
    if (fits_read_key(file_.get(), TDOUBLE, keyword, &value, nullptr, &status) != 0) return std::nullopt;
    return std::isfinite(value) ? std::optional(value) : std::nullopt;
  }

 private:
  static void check(int status) {
    if (status == 0) return;
    std::array<char, FLEN_STATUS> words{};
    fits_get_errstatus(status, words.data());
    fits_clear_errmsg();
    refuse(fmt::format("a FITS that cannot be read: {}", words.data()));
  }
  // Empty: the type does not say.
  std::optional<double> white() const {
    for (const char* keyword : {"DATAMAX", "SATURATE"})
      if (const auto value = number(keyword); value && *value > 0.0) return value;
    const double zero = number("BZERO").value_or(0.0), scale = number("BSCALE").value_or(1.0);
    if (bits_ == BYTE_IMG) return zero + 255.0 * scale;
    if (bits_ == SHORT_IMG) return zero + 32767.0 * scale;
    return std::nullopt;
  }

  void* memory_;
  std::size_t size_;
  CPtr<fitsfile, close_fits> file_;
  int bits_ = 0, width_ = 0, height_ = 0, planes_ = 1;
};

// In the order in which rows are stored; cameras with an offset (XBAYROFF, YBAYROFF) begin elsewhere in it.
cv::Mat without_pattern(const cv::Mat& mosaic, const FitsImage& file) {
  auto pattern = file.word("BAYERPAT");
  if (mosaic.rows < 4 || mosaic.cols < 4) refuse("a FITS of Bayer's pattern of less than 4 x 4 pixels");
  const auto odd = [&](const char* keyword) {
    return std::abs(std::fmod(std::round(file.number(keyword).value_or(0.0)), 2.0)) > 0.5;
  };
  if (pattern.size() == 4 && odd("XBAYROFF")) std::swap(pattern[0], pattern[1]), std::swap(pattern[2], pattern[3]);
  if (pattern.size() == 4 && odd("YBAYROFF")) std::swap(pattern[0], pattern[2]), std::swap(pattern[1], pattern[3]);
  int code = 0;
  if (pattern == "RGGB") code = cv::COLOR_BayerRGGB2BGR;
  if (pattern == "BGGR") code = cv::COLOR_BayerBGGR2BGR;
  if (pattern == "GRBG") code = cv::COLOR_BayerGRBG2BGR;
  if (pattern == "GBRG") code = cv::COLOR_BayerGBRG2BGR;
  if (code == 0) refuse(fmt::format("a FITS of BAYERPAT '{}', expected RGGB, BGGR, GRBG or GBRG", pattern));
  cv::Mat colours;
  cv::cvtColor(mosaic, colours, code);
  return colours;
}

void to_srgb_code(cv::Mat& light) {
  static const auto kCodes = [] {
    std::vector<std::uint16_t> codes(65536);
    for (std::size_t i = 0; i < codes.size(); ++i) {
      const double v = static_cast<double>(i) / kFull;
      const double code = v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1.0 / 2.4) - 0.055;
      codes[i] = static_cast<std::uint16_t>(std::lround(kFull * code));
    }
    return codes;
  }();
  light.reshape(1).forEach<std::uint16_t>([](std::uint16_t& value, const int*) { value = kCodes[value]; });
}

}  // namespace

cv::Mat read_fits(std::span<const std::uint8_t> bytes) {
  const FitsImage file(bytes);
  auto planes = file.read();
  cv::Mat light;
  if (planes.size() == 3) std::swap(planes[0], planes[2]);  // B G R
  cv::merge(planes, light);
  light.convertTo(light, CV_16U, kFull);
  if (planes.size() == 1 && !file.word("BAYERPAT").empty()) light = without_pattern(light, file);
  if (file.word("ROWORDER") != "TOP-DOWN") cv::flip(light, light, 0);
  to_srgb_code(light);
  return light;
}

}  // namespace kasumi
