#include "base/picture_files/colour_profile.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <lcms2.h>
#include <opencv2/imgproc.hpp>

#include "base/c_ptr.hpp"

namespace kasumi {

namespace {

using ProfilePtr = CPtr<void, cmsCloseProfile>;
using TransformPtr = CPtr<void, cmsDeleteTransform>;
using CurvePtr = CPtr<cmsToneCurve, cmsFreeToneCurve>;

// Whether it leaves all colours within half a step of 255 of where they are.
bool changes_nothing(cmsHTRANSFORM transform) {
  constexpr int kSteps = 9;
  for (int r = 0; r < kSteps; ++r)
    for (int g = 0; g < kSteps; ++g)
      for (int b = 0; b < kSteps; ++b) {
        const cv::Vec3f from(static_cast<float>(r) / (kSteps - 1), static_cast<float>(g) / (kSteps - 1),
                             static_cast<float>(b) / (kSteps - 1));
        cv::Vec3f to;
        cmsDoTransform(transform, from.val, to.val, 1);
        for (int c = 0; c < 3; ++c)
          if (!(std::abs(std::clamp(to[c], 0.0F, 1.0F) - from[c]) < 0.5F / 255.0F)) return false;
      }
  return true;
}

std::string text_of_space(cmsColorSpaceSignature space) {
  return space == cmsSigCmykData   ? "four inks, as for print"
         : space == cmsSigGrayData ? "grey"
                                   : "other colours than R, G, B";
}

// Empty: there is no profile, or none that can be saved.
std::vector<std::uint8_t> bytes_of(const ProfilePtr& profile) {
  cmsUInt32Number size = 0;
  if (!profile || !cmsSaveProfileToMem(profile.get(), nullptr, &size)) return {};
  std::vector<std::uint8_t> bytes(size);
  if (!cmsSaveProfileToMem(profile.get(), bytes.data(), &size)) return {};
  return bytes;
}

}  // namespace

std::string profile_to_srgb(cv::Mat& picture, std::span<const std::uint8_t> bytes) {
  if (picture.depth() != CV_8U && picture.depth() != CV_16U) return {};
  const ProfilePtr profile(cmsOpenProfileFromMem(bytes.data(), static_cast<cmsUInt32Number>(bytes.size())));
  if (!profile) return "its colour profile is damaged";
  const auto space = cmsGetColorSpace(profile.get());
  const bool grey = picture.channels() == 1;
  if (space != (grey ? cmsSigGrayData : cmsSigRgbData)) {
    // Grey samples below an RGB profile are its neutral colours.
    if (!(grey && space == cmsSigRgbData)) return "its colour profile is of " + text_of_space(space);
    cv::cvtColor(picture, picture, cv::COLOR_GRAY2RGB);
  }
  const ProfilePtr srgb(cmsCreate_sRGBProfile());
  const bool is_grey_profile = space == cmsSigGrayData;
  const TransformPtr transform(cmsCreateTransform(profile.get(), is_grey_profile ? TYPE_GRAY_FLT : TYPE_RGB_FLT,
                                                  srgb.get(), TYPE_RGB_FLT, INTENT_RELATIVE_COLORIMETRIC,
                                                  cmsFLAGS_BLACKPOINTCOMPENSATION | cmsFLAGS_NOCACHE));
  if (!transform) return "its colour profile cannot be used";
  if (!is_grey_profile && changes_nothing(transform.get())) return {};

  cv::Mat floats, alpha;
  picture.convertTo(floats, CV_32F, picture.depth() == CV_8U ? 1.0 / 255.0 : 1.0 / 65535.0);
  if (floats.channels() == 4) {
    cv::extractChannel(floats, alpha, 3);
    cv::cvtColor(floats, floats, cv::COLOR_RGBA2RGB);
  }
  cv::Mat made(floats.size(), CV_32FC3);
  for (int y = 0; y < floats.rows; ++y)
    cmsDoTransform(transform.get(), floats.ptr(y), made.ptr(y), static_cast<cmsUInt32Number>(floats.cols));
  cv::Mat clamped = cv::min(cv::max(made, 0.0), 1.0);
  cv::patchNaNs(clamped, 0.0);
  if (!alpha.empty()) {
    std::vector<cv::Mat> channels;
    cv::split(clamped, channels);
    channels.push_back(alpha);
    cv::merge(channels, clamped);
  }
  picture = clamped;
  return {};
}

std::vector<std::uint8_t> profile_of_primaries(glm::vec2 red, glm::vec2 green, glm::vec2 blue) {
  const cmsCIExyY d65{0.3127, 0.3290, 1.0};
  const cmsCIExyYTRIPLE primaries{{red.x, red.y, 1.0}, {green.x, green.y, 1.0}, {blue.x, blue.y, 1.0}};
  const std::array<double, 5> kSrgb{2.4, 1.0 / 1.055, 0.055 / 1.055, 1.0 / 12.92, 0.04045};  // IEC 61966-2-1
  const CurvePtr curve(cmsBuildParametricToneCurve(nullptr, 4, kSrgb.data()));
  if (!curve) return {};
  cmsToneCurve* curves[] = {curve.get(), curve.get(), curve.get()};
  return bytes_of(ProfilePtr(cmsCreateRGBProfile(&d65, &primaries, curves)));
}

std::vector<std::uint8_t> profile_of_srgb() {
  auto bytes = bytes_of(ProfilePtr(cmsCreate_sRGBProfile()));
  // The same bytes every time: lcms2 notes when it was made (ICC.1, 7.2.8).
  constexpr std::array<std::uint8_t, 12> kWhen{0x07, 0xd0, 0, 1, 0, 1};
  if (bytes.size() > 36) std::ranges::copy(kWhen, bytes.begin() + 24);
  return bytes;
}

}  // namespace kasumi
