// Similarity of two pictures, as M Sect 7.2.3 measures it.
#pragma once

#include <cstdint>
#include <optional>

#include "base/image.hpp"
#include "base/picture.hpp"

namespace kasumi {

// Which pixels count: those that are not 0. Empty: all.
using CountedPixels = Image<std::uint8_t>;

// Mean structural similarity of the pictures' luma: Wang 2004 with its constants (Gaussian window of 11 x 11, sigma
// 1.5; K1 = .01, K2 = .03, L = 255), over the windows that lie inside the picture, at the pictures' own size. Pictures
// of one size, at least 11 x 11.
double ssim(const Image<Rgb8>& one, const Image<Rgb8>& other);

// The same of encoded values 0..1, over the windows all of whose pixels count; nothing where there is none.
std::optional<double> ssim(const Image<glm::vec3>& one, const Image<glm::vec3>& other, const CountedPixels& counted);

// Pearson correlation of histograms (M Eq 27, whose denominator lacks its sums). M says neither how many bins nor what
// "combined" is: here 30 bins of hue, 32 of saturation and of value, as in OpenCV's manual, and the mean of the three.
// A uniform histogram correlates with nothing but itself.
struct HsvCorrelation {
  double hue = 0.0, saturation = 0.0, value = 0.0;
  double combined() const { return (hue + saturation + value) / 3.0; }
};
HsvCorrelation hsv_correlation(const Image<Rgb8>& one, const Image<Rgb8>& other);
// Of encoded values 0..1, which are rounded to 8 bits first.
HsvCorrelation hsv_correlation(const Image<glm::vec3>& one, const Image<glm::vec3>& other,
                               const CountedPixels& counted);

}  // namespace kasumi
