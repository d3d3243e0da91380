#include "pipeline/install/calibrate/orientation_series.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "base/statistics.hpp"
#include "base/utc_text.hpp"
#include "calib/calibration_file.hpp"
#include "calib/mask/sky_mask.hpp"
#include "calib/mask/square_pixels.hpp"
#include "calib/pose/fisheye_fit.hpp"
#include "estimator/cloud_cover/cloud_cover.hpp"
#include "estimator/sky/sun.hpp"
#include "estimator/sky_camera/sun_by_aureole.hpp"
#include "estimator/sky_camera/sun_by_shape.hpp"
#include "estimator/sky_camera/sun_in_image.hpp"
#include "estimator/sky_fit/camera_belief.hpp"
#include "estimator/sky_fit/tone_curve.hpp"
#include "estimator/turbidity/turbidity.hpp"
#include "pipeline/install/calibrate/save_calibration.hpp"
#include "pipeline/install/calibrate/series_pictures.hpp"
#include "pipeline/install/calibration_report/plots.hpp"
#include "pipeline/site/files/picture_sink.hpp"

namespace kasumi {
namespace {

constexpr Radians kLowestSun = from_degrees(3.0);  // elevation; lower, refraction is uncertain and the sun no disc
constexpr std::size_t kMostSuns = 400, kMostTones = 48, kMostForMask = 60;
constexpr double kMaskMargin_px = 2.0;

Camera camera_of(const SeriesPictures& series, LensDescription lens, const glm::dmat3& to_world) {
  Camera camera;
  camera.name = "sky";
  camera.width = series.brightest.width();
  camera.height = series.brightest.height();
  camera.lens = make_lens(lens);
  camera.to_world = to_world;
  return camera;
}

// As the picture looks before anything is fitted: the circle at the horizon, its top to the north.
Camera unfitted(const SeriesPictures& series) {
  const ImageCircle& circle = series.circle.horizon.value_or(series.circle.circle);
  const Radians edge = from_degrees(90.0);
  return camera_of(series, {IdealFisheyeParameters{circle.centre, circle.radius_px / edge.value, false}, edge, false},
                   camera_to_world(from_degrees(180.0), edge, Radians{0.0}));
}

// The lens's circle at the horizon. The picture's rim is a circle around the lens's axis; the sky's edge is one around
// the zenith, and yields the size alone.
ImageCircle at_horizon(const FoundCircle& found) {
  ImageCircle circle = found.circle;
  if (found.horizon) circle.radius_px = found.horizon->radius_px;
  return circle;
}

struct SeenSun {
  std::filesystem::path file;
  SunSight sight;
  double sigma_px = 1.0;
};

struct SeenSuns {
  std::vector<SeenSun> suns;
  int too_low = 0, not_seen = 0;

  double usual_sigma_px() const {
    std::vector<double> sigmas;
    for (const SeenSun& sun : suns) sigmas.push_back(sun.sigma_px);
    return sigmas.empty() ? 1.0 : median(sigmas);
  }
  std::vector<SunSight> sights() const {
    std::vector<SunSight> all;
    for (const SeenSun& sun : suns) {
      all.push_back(sun.sight);
      all.back().relative_sigma = sun.sigma_px / usual_sigma_px();
    }
    return all;
  }
};

constexpr double kLeastSunSigma_px = 0.3;
constexpr double kAcrossOverAlong = 0.3;  // of a sun's sigma: the sky is brighter below it, and alike at its sides

// What a clear sky's growth towards the horizon does to a bright spot's height, as it grows with the zenith angle.
double lowered_at(const Direction& sun) {
  return std::hypot(sun.x, sun.y) / (std::max(sun.z, 0.0) + 0.1);
}

// With `known`, an orientation, the sun is looked for where it should be, in pictures that are not among `known` yet.
SeenSuns seen_suns(const SeriesPictures& series, const Camera& camera, const Site& site, const SeenSuns* known) {
  SeenSuns seen;
  if (known) seen.suns = known->suns;
  for_each_of(series, kMostSuns, [&](const SeriesFile& one, Photograph& photograph) {
    const auto position = sun_position(one.utc, site);
    if (position.zenith > from_degrees(90.0) - kLowestSun) {
      ++seen.too_low;
      return;
    }
    if (std::ranges::any_of(seen.suns, [&](const SeenSun& sun) { return sun.file == one.file; })) return;
    const auto picture = sky_picture(photograph.encoded, photograph.quantum, camera);
    SunBlobLimits options;
    options.largest_by_shape = from_degrees(5.0);  // low ones: their azimuth is sure
    if (known) options.expected = ExpectedSun{position.direction, from_degrees(1.0), true};
    // By its shape first: that sees how far a sky that is brighter below moves it.
    auto blob = picture ? sun_by_shape(*picture, camera, options) : std::nullopt;
    if (picture && !blob) blob = sun_by_aureole(*picture, camera, options);
    const auto aside = blob ? camera.direction_at(blob->pixel + glm::dvec2{1.0, 0.0}) : std::nullopt;
    if (!aside) {
      ++seen.not_seen;
      return;
    }
    const double sigma_px = blob->sigma.value / angle_between(blob->direction, *aside).value;
    seen.suns.push_back({one.file,
                         {position.direction, blob->pixel, 1.0, lowered_at(position.direction), kAcrossOverAlong},
                         std::max(kLeastSunSigma_px, sigma_px)});
  });
  return seen;
}

// Those that the fit left out are looked for once more.
SeenSuns without_rejected(const SeenSuns& seen, const OrientationFit& found) {
  SeenSuns kept;
  for (std::size_t i = 0; i < seen.suns.size(); ++i)
    if (found.used[i]) kept.suns.push_back(seen.suns[i]);
  return kept;
}

// The camera's tone curve and its loss of light towards the rim, by clear skies.
struct Light {
  CameraBelief belief;
  int pictures = 0;
  double rim_loss = 0.0, sigma_rim_loss = 0.0;
};

Light light_of(const SeriesPictures& series, const Camera& camera, const Site& site) {
  Light light;
  std::vector<ToneSight> tones;
  double weight = 0.0, sum = 0.0;
  SkyObserver observer(camera);
  EstimateParameters options;
  options.sky.every_model = true;
  options.sky.altitude_m = site.altitude_m;
  for_each_of(series, kMostTones, [&](const SeriesFile& one, Photograph& photograph) {
    const auto sun = sun_position(one.utc, site).direction;
    const auto picture = sky_picture(photograph.encoded, photograph.quantum, camera);
    if (!picture) return;
    const auto cover = cloud_cover(*picture, camera, sun);
    if (!cover.fraction) return;
    const auto look = observer.observe_by_unknown_camera(*picture, sun, clear_air_of(cover), CameraBelief{}, options);
    if (!look.estimate.usable || !(look.tone_exponent > 0.0)) return;
    tones.push_back({look.tone_exponent, look.sigma_tone_exponent});
    const double share = 1.0 / (look.sigma_rim_loss * look.sigma_rim_loss);
    weight += share;
    sum += share * look.rim_loss;
  });
  light.belief = belief_after(tones);
  light.pictures = static_cast<int>(tones.size());
  if (weight > 0.0) {
    constexpr double kShared = 0.05;  // errors that the skies of one camera share
    light.rim_loss = sum / weight;
    light.sigma_rim_loss = std::hypot(std::sqrt(1.0 / weight), kShared);
  }
  return light;
}

MeasuredCurve curve_of(double exponent) {
  const Response response = corrected(Response::srgb(), exponent);
  MeasuredCurve curve;
  for (int code = 0; code < 256; ++code) {
    const glm::dvec3 light = response.to_light(glm::dvec3(code / 255.0));
    for (int c = 0; c < 3; ++c) curve.light[static_cast<std::size_t>(c)].push_back(light[c]);
  }
  return curve;
}

// exp(-loss r^2) as the polynomial of a configuration.
Vignetting vignetting_of(const ImageCircle& circle, double pixel_aspect, double loss) {
  Vignetting vignetting;
  vignetting.centre = {circle.centre.x / pixel_aspect, circle.centre.y};
  vignetting.radius_px = circle.radius_px;
  vignetting.coefficients = {-loss, loss * loss / 2.0, -loss * loss * loss / 6.0};
  return vignetting;
}

std::string from_text(const SeriesPictures& series, std::ptrdiff_t used, std::string_view what) {
  return fmt::format("{} {} of {} pictures, {} to {}", used, what, series.pictures.size(),
                     utc_text(series.pictures.front().utc), utc_text(series.pictures.back().utc));
}

void report(const SeriesPictures& series, const SeenSuns& suns, const FisheyeFit& fit, const Light& light) {
  const auto& found = fit.orientation;
  const auto used = std::count(found.used.begin(), found.used.end(), true);
  fmt::print("{} pictures of {} x {}: the sun in {}, not seen in {}, too low in {}\n", series.pictures.size(),
             series.width, series.height, suns.suns.size(), suns.not_seen, suns.too_low);
  if (series.unreadable + series.without_time + series.of_other_size > 0)
    fmt::print("left out: {} unreadable, {} without a time, {} of another size\n", series.unreadable,
               series.without_time, series.of_other_size);
  const auto& circle = series.circle.circle;
  fmt::print("image circle: centre ({:.1f}, {:.1f}), radius {:.1f} px +- {:.1f}, {:.0f} % sure\n", circle.centre.x,
             circle.centre.y, circle.radius_px, circle.sigma_px, 100.0 * series.circle.confidence);
  if (series.circle.pixel_aspect != 1.0)
    fmt::print("pixels are 1 : {:.3f}; x is in pixels as high as wide\n", series.circle.pixel_aspect);
  fmt::print("projection: {}, rms {:.2f} px of {} suns; {} rejected\n", fit.projection, found.rms_px, used,
             static_cast<std::ptrdiff_t>(found.used.size()) - used);
  const auto angles = heading_pitch_roll(found.to_world);
  fmt::print(
      "heading {:.2f}, pitch {:.2f}, roll {:.2f} deg; azimuth +- {:.2f}, tilt +- {:.2f} (east), {:.2f} (north)\n",
      to_degrees(angles.heading), to_degrees(angles.pitch), to_degrees(angles.roll), to_degrees(found.sigma.azimuth),
      to_degrees(found.sigma.tilt_east), to_degrees(found.sigma.tilt_north));
  fmt::print("pictures are {}mirrored{}\n", fit.mirrored ? "" : "not ",
             fit.mirror_known ? "" : ", as far as suns so near to each other show");
  if (light.pictures > 0)
    fmt::print(
        "tone curve: sRGB to the power {:.3f} +- {:.3f}; light lost at the rim {:.2f} +- {:.2f}; from {} clear "
        "skies\n",
        std::exp(light.belief.log_exponent), std::exp(light.belief.log_exponent) * light.belief.sigma_log_exponent,
        1.0 - std::exp(-light.rim_loss), std::exp(-light.rim_loss) * light.sigma_rim_loss, light.pictures);
  else
    fmt::print("tone curve: no clear sky determines it; sRGB is supposed\n");
  if (used < 3)
    fmt::print("{} sun{}: that determines the heading, and little else; pictures of other hours determine the rest\n",
               used, used == 1 ? "" : "s");
  for (const auto& remark : found.undetermined) fmt::print("undetermined: {}\n", remark);
}

std::vector<Measured> measured_of(const SeriesPictures& series, const FisheyeFit& fit, const Light& light,
                                  const std::string& now) {
  const auto& found = fit.orientation;
  const auto& sigma = found.sigma;
  const auto used = std::count(found.used.begin(), found.used.end(), true);
  Measured orientation{"orientation",
                       now,
                       from_text(series, used, "suns"),
                       {{"suns", static_cast<double>(used)},
                        {"rms_px", found.rms_px},
                        {"azimuth_sigma_deg", to_degrees(sigma.azimuth)},
                        {"tilt_east_sigma_deg", to_degrees(sigma.tilt_east)},
                        {"tilt_north_sigma_deg", to_degrees(sigma.tilt_north)},
                        {"centre_x_sigma_px", sigma.centre_px.x},
                        {"centre_y_sigma_px", sigma.centre_px.y},
                        {"focal_sigma_percent", 100.0 * sigma.scale},
                        {"k1_sigma", sigma.odd[0]},
                        {"k2_sigma", sigma.odd[1]}},
                       found.undetermined};
  orientation.remarks.push_back(fmt::format("projection: {}", fit.projection));
  orientation.remarks.push_back(
      fmt::format("the pictures are {}mirrored{}", fit.mirrored ? "" : "not ", fit.mirror_known ? "" : " (supposed)"));
  std::vector<Measured> all{orientation};
  const auto& circle = series.circle.circle;
  all.push_back({"image_circle",
                 now,
                 from_text(series, static_cast<std::ptrdiff_t>(series.pictures.size()), "pictures"),
                 {{"centre_x_px", circle.centre.x / series.circle.pixel_aspect},
                  {"centre_y_px", circle.centre.y},
                  {"radius_px", circle.radius_px},
                  {"radius_sigma_px", circle.sigma_px},
                  {"confidence", series.circle.confidence}},
                 {}});
  if (light.pictures > 0)
    all.push_back({"tone_curve",
                   now,
                   from_text(series, light.pictures, "clear skies"),
                   {{"exponent", std::exp(light.belief.log_exponent)},
                    {"exponent_sigma", std::exp(light.belief.log_exponent) * light.belief.sigma_log_exponent},
                    {"rim_loss", light.rim_loss},
                    {"rim_loss_sigma", light.sigma_rim_loss}},
                   {}});
  return all;
}

// Trees, houses and wires, written beside the calibration; nothing where the pictures do not show them.
Result<std::optional<std::string>> save_mask(const SeriesPictures& series, const Camera& camera,
                                             const std::filesystem::path& out) {
  std::vector<Image<Rgb8>> pictures;
  for_each_of(series, kMostForMask,
              [&](const SeriesFile&, Photograph& photograph) { pictures.push_back(to_rgb8(photograph)); });
  auto found = find_sky_mask(pictures, camera, kMaskMargin_px);
  if (!found) {
    fmt::print("mask: none, {}\n", found.error().message);
    return std::optional<std::string>();
  }
  const auto file = beside(out, "sky-free.png");
  const auto kept = keep_old(file);
  if (!kept) return fail(kept.error());
  if (auto written = write_png(file, with_columns(std::move(found->mask), series.width)); !written)
    return fail(written.error());
  fmt::print("mask: {:.1f} % of the sky is hidden, {:.1f} % was decided from its surroundings; written: {}\n",
             100.0 * found->hidden_share, 100.0 * found->unsure_share, file.string());
  return std::optional(file.filename().string());
}

}  // namespace

Result<int> calibrate_sky_series(const OrientationSeries& asked) {
  const auto series = read_series(asked.pictures, asked.times, asked.circle);
  if (!series) return fail(series.error());
  FisheyePrior prior;
  prior.circle = at_horizon(series->circle);
  prior.level_sigma = from_degrees(asked.level_sigma_deg);
  Camera camera = unfitted(*series);
  SeenSuns suns;
  std::optional<FisheyeFit> fit;
  // The second look knows where the suns should be.
  for (const bool second : {false, true}) {
    const auto known = second ? without_rejected(suns, fit->orientation) : SeenSuns{};
    suns = seen_suns(*series, camera, asked.site, second ? &known : nullptr);
    prior.sun_sigma_px = suns.usual_sigma_px();
    auto found = fit_fisheye(suns.sights(), prior);
    if (!found) return fail(found.error().kind, "{}: {}", asked.pictures.front(), found.error().message);
    fit = std::move(*found);
    camera = camera_of(*series, fit->orientation.lens, fit->orientation.to_world);
  }
  const Light light = light_of(*series, camera, asked.site);
  report(*series, suns, *fit, light);
  const auto mask = save_mask(*series, camera, asked.out);
  if (!mask) return fail(mask.error());

  CalibrationStep step;
  step.camera = "sky";
  step.width = series->width;
  step.height = series->height;
  step.serial = asked.serial;
  step.lens = in_stored_pixels(fit->orientation.lens, series->circle.pixel_aspect);
  step.to_world = fit->orientation.to_world;
  step.mask = *mask;
  step.site = asked.site;
  if (light.pictures > 0) {
    step.curve = curve_of(std::exp(light.belief.log_exponent));
    step.vignetting = vignetting_of(prior.circle, series->circle.pixel_aspect, light.rim_loss);
  } else {
    step.response = "srgb";
  }
  const auto now = utc_text(std::chrono::floor<std::chrono::seconds>(SystemClock().utc()));
  step.calibrated_utc = now;
  step.measured = measured_of(*series, *fit, light, now);
  const auto title = fmt::format("{}: rms {:.2f} px, azimuth +- {:.2f} deg", fit->projection, fit->orientation.rms_px,
                                 to_degrees(fit->orientation.sigma.azimuth));
  return save_calibration(asked.out, std::move(step),
                          plot_sun_track(series->brightest, suns.sights(), fit->orientation, title));
}

}  // namespace kasumi
