// How blue clear sky is in each direction of one picture, and how blue its clouds are.
#pragma once

#include <array>

#include "estimator/cloud_cover/pixel_features.hpp"

namespace kasumi {

struct ClearBlue {
  bool found = false;             // false: too few elements are darker than white
  std::array<double, 5> clear{};  // of the terms in clear_terms()
  bool sun_known = false;
  double cloud = 0.0;     // blueness of cloud
  double contrast = 0.0;  // clear less cloud where the clear sky is bluer than in four fifths of the directions
  double share = 0.0;     // of clear sky among the samples
  // Blueness of clear sky there. `sun_deg` is not used where the sun is not known.
  double clear_at(double zenith_deg, double sun_deg) const;
};

struct ClearBluePrior {
  // What cameras have in common: grey clouds are nearly neutral, a clear zenith is bluer by so much.
  double cloud = 0.06, cloud_sigma = 0.04;
  double zenith_contrast = 0.47, zenith_sigma = 0.20;
  double independent = 150.0;  // samples of one sky are correlated: they count as so many
  int samples = 1500;
};

// A mixture of clear sky, a smooth function of zenith and sun distance, and of cloud of one colour, fitted by
// expectation maximisation from several starts to the elements of `region` that no channel clips, or, where
// these are too few, to those that are not white. Whiteness towards the
// horizon and the sun is thereby not taken for cloud. `sun_deg`: empty where the sun is not known.
ClearBlue fit_clear_blue(const PixelFeatures& sky, const cv::Mat1b& region, const cv::Mat1f& sun_deg,
                         const ClearBluePrior& options = {});

// 0 where as blue as clear sky, 1 where as white as cloud. Where the picture has too little contrast for two kinds of
// sky, all of it is cloud: above 1.
cv::Mat1f whiteness(const PixelFeatures& sky, const ClearBlue& blue, const cv::Mat1f& sun_deg);

}  // namespace kasumi
