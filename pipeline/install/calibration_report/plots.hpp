// Plots of a calibration's results.
#pragma once

#include <span>
#include <string>

#include "base/image.hpp"
#include "base/picture.hpp"
#include "calib/colour/sensitivity_fit.hpp"
#include "calib/lens/lens_calibration.hpp"
#include "calib/light/response_fit.hpp"
#include "calib/mask/scene_mask.hpp"
#include "calib/pose/orientation_fit.hpp"
#include "calib/pose/scene_pose.hpp"
#include "estimator/sky_camera/sky_vignetting.hpp"

namespace kasumi {

// Left: every corner in the picture with its residual, fifty times as long; cells no corner was seen in are grey.
// Right: how many corners are how far off.
Image<Rgb8> plot_lens(const LensCalibration& calibration, int width, int height, const std::string& title);

// Left: the sun's places over the picture (green: used, red: not the sun) with residuals fifty times as long, and the
// way that was fitted. Right: how many are how far off.
Image<Rgb8> plot_sun_track(const Image<Rgb8>& picture, std::span<const SunSight> sights,
                           const OrientationFit& orientation, const std::string& title);

// The landmarks over the picture: a cross where each was marked, a circle where its place is seen, green when used, red
// when left out, numbered as in the list below it; the horizon in blue. Under the list, how many are how far off.
Image<Rgb8> plot_scene(const Image<Rgb8>& picture, std::span<const LandmarkSight> landmarks,
                       std::span<const HorizonSight> horizon, const ScenePose& pose, const std::string& title);

// Left: how the picture darkens towards the rim: what each picture shows over the sky model (dots) and the curve.
// Right: how many samples are how far off.
Image<Rgb8> plot_vignetting(const FoundVignetting& found, const std::string& title);

// Left: light over value, both in stops, the three channels' curves and the pixels of the stack. Right: the same
// linear.
Image<Rgb8> plot_response(const ResponseFit& fit, const StackSamples& samples, const std::string& title);

// Left: the sensitivity that was taken, each channel's largest 1, over those of the measured cameras (faint).
// Right: residuals of the log ratios of every part of the sky, green where used, red where rejected.
Image<Rgb8> plot_colour(const SpectralSensitivity& taken, std::span<const SpectralSensitivity> cameras,
                        const ColourResiduals& residuals, const std::string& title);

// The picture with what is hidden in red, by how much, its edge in yellow; strokes, where there are any, as they were
// drawn. Scaled to at most 1280 pixels across.
Image<Rgb8> plot_mask(const Image<Rgb8>& picture, const Image<std::uint8_t>& mask, const Image<Stroke>& strokes,
                      const std::string& title);

}  // namespace kasumi
