// What a calibration did, as pictures for a person.
#pragma once

#include <span>
#include <string>

#include "base/image.hpp"
#include "base/picture.hpp"
#include "calib/lens_calibration.hpp"
#include "calib/scene_pose.hpp"
#include "calib/sky_orientation.hpp"
#include "estimator/sky_vignetting.hpp"

namespace kasumi {

// Left: every corner in the picture with its residual, fifty times as long; cells no corner was seen in are grey.
// Right: how many corners are how far off.
Image<Rgb8> plot_lens(const LensCalibration& calibration, int width, int height, const std::string& title);

// Left: the sun's places over the picture (green: used, red: not the sun) with residuals fifty times as long, and the
// way that was fitted. Right: how many are how far off.
Image<Rgb8> plot_sun_track(const Image<Rgb8>& picture, std::span<const SunSight> sights,
                           const SkyOrientation& orientation, const std::string& title);

// The landmarks over the picture: a cross where each was marked, a circle where its place is seen, green when used, red
// when left out, numbered as in the list below it; the horizon in blue. Under the list, how many are how far off.
Image<Rgb8> plot_scene(const Image<Rgb8>& picture, std::span<const LandmarkSight> landmarks,
                       std::span<const HorizonSight> horizon, const ScenePose& pose, const std::string& title);

// Left: how the picture darkens towards the rim: what each picture shows over the sky model (dots) and the curve.
// Right: how many samples are how far off.
Image<Rgb8> plot_vignetting(const SkyVignetting& found, const std::string& title);

}  // namespace kasumi
