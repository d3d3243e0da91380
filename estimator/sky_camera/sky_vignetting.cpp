#include "estimator/sky_camera/sky_vignetting.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Dense>
#include <glm/geometric.hpp>

#include "base/statistics.hpp"
#include "calib/lens/polynomial.hpp"
#include "estimator/turbidity/perez_log.hpp"

namespace kasumi {

namespace {

constexpr int kShape = 3;                                  // v2, v4, v6
constexpr int kMaskRounds = 4;                             // cloud masks with successively better vignetting
constexpr double kOutlier = 4.0;                           // robust standard deviations
constexpr Radians kCorrelationAngle = from_degrees(20.0);  // over which a sky model's errors are correlated
constexpr std::size_t kFewestSamples = 200;                // of a picture
constexpr double kSkyModelError = 0.03;                    // clear skies of any aerosol leave 1 to 3 % (clear_form.hpp)
constexpr double kAbsorbed = 1.3;  // the fit absorbs part of a smooth error, which then is missing from the residuals

struct Sample {
  PerezPoint at;
  double zenith = 0.0, r2 = 0.0, log_light = 0.0, weight = 0.0;
  int patch = 0;  // patch of sky, within which the model's errors are alike
  bool used = true;
};

struct Moment {
  std::vector<Sample> samples;
  double turbidity = 3.0, log_gain = 0.0;
  std::string reason;  // why it is not used
};

// Elements of clear sky, evenly distributed over the picture.
std::vector<glm::ivec2> spread(const Image<PixelUse>& use, int count) {
  const auto clear = std::ranges::count(use.elements(), PixelUse::clear);
  const int step = std::max(1, static_cast<int>(std::sqrt(static_cast<double>(clear) / count)));
  std::vector<glm::ivec2> elements;
  for (int y = step / 2; y < use.height(); y += step)
    for (int x = step / 2; x < use.width(); x += step)
      if (use.at(x, y) == PixelUse::clear) elements.emplace_back(x, y);
  return elements;
}

class Fit {
 public:
  Fit(std::vector<Moment>& moments, const std::array<double, kShape>& shape,
      const std::optional<KnownTurbidity>& known_turbidity)
      : moments_(moments), shape_(shape), known_turbidity_(known_turbidity.has_value()) {
    for (std::size_t m = 0; m < moments_.size(); ++m)
      if (moments_[m].reason.empty()) {
        used_.push_back(m);
        if (known_turbidity) moments_[m].turbidity = clamp_turbidity(Turbidity{known_turbidity->value}).value;
      }
  }

  // Gauss-Newton with least squares on the samples in use; outliers are dropped by their residuals.
  void solve() {
    constexpr int kRounds = 25;  // an upper bound: it ends when a step is below 1e-7
    for (int round = 0; round < kRounds; ++round) {
      build();
      Eigen::VectorXd step = normal_.ldlt().solve(right_);
      if (!step.allFinite()) return;
      const double longest = step.head(kShape).cwiseAbs().maxCoeff();
      if (longest > 0.3) step *= 0.3 / longest;
      for (int k = 0; k < kShape; ++k) shape_[static_cast<std::size_t>(k)] += step(k);
      for (std::size_t i = 0; i < used_.size(); ++i) {
        auto& moment = moments_[used_[i]];
        moment.turbidity =
            std::clamp(moment.turbidity + step(of_t(i)), kLowestTurbidity.value, kHighestTurbidity.value);
        moment.log_gain += step(of_t(i) + 1);
      }
      if (round >= 3) drop_outliers();
      if (round > 8 && step.cwiseAbs().maxCoeff() < 1e-7) break;
    }
    build();
  }

  double illumination(double r2) const {
    return std::max(1e-3, 1.0 + r2 * (shape_[0] + r2 * (shape_[1] + r2 * shape_[2])));
  }
  double residual(const Moment& moment, const Sample& sample) const {
    return sample.log_light - moment.log_gain - PerezLog(Turbidity{moment.turbidity}).at(sample.at).log_f -
           std::log(illumination(sample.r2));
  }
  const std::array<double, kShape>& shape() const { return shape_; }
  std::size_t pictures() const { return used_.size(); }

  // Of ln illumination at the rim.
  struct Certainty {
    double scatter = 0.0;       // standard deviation, assuming that patches of sky are independent
    double misfit = 0.0;        // of whole patches, root mean square: a lower bound of the model's error
    double about_sun = 0.0;     // for an error of 1 that varies with the distance from the sun
    double at_rim = 0.0;        // for one that grows to 1 at 80 deg from the zenith
    double by_turbidity = 0.0;  // for T too high by 1 in all pictures
  };
  Certainty certainty() const {
    Eigen::VectorXd rim = Eigen::VectorXd::Zero(normal_.rows());
    rim.head<kShape>().setConstant(1.0 / illumination(1.0));
    const Eigen::VectorXd weigh = normal_.ldlt().solve(rim);  // sensitivity of the rim to each unknown
    Certainty found;
    double patches = 0.0, counted = 0.0, squares = 0.0;
    Eigen::VectorXd rings = Eigen::VectorXd::Zero(kRings);
    for_all([&](std::size_t i, const std::vector<Eigen::Vector4d>& rows, const std::vector<double>& residuals) {
      const auto& samples = moments_[used_[i]].samples;
      struct Patch {
        double pull = 0.0, sum = 0.0, count = 0.0;
      };
      std::array<Patch, kPatches> sky{};
      for (std::size_t s = 0; s < samples.size(); ++s) {
        const auto& sample = samples[s];
        if (!sample.used) continue;
        const double lever = sample.weight * (rows[s].head<kShape>().dot(weigh.head<kShape>()) +
                                              rows[s](kShape) * weigh(of_t(i)) + weigh(of_t(i) + 1));
        auto& patch = sky[static_cast<std::size_t>(sample.patch)];
        patch.pull += lever * residuals[s];
        patch.sum += residuals[s];
        patch.count += 1.0;
        found.at_rim += lever * std::pow(sample.zenith / from_degrees(80.0).value, 2);
        found.by_turbidity += lever * rows[s](kShape);
        const double ring = sample.at.gamma / kCorrelationAngle.value;  // hat functions over the distance from the sun
        const auto below = static_cast<Eigen::Index>(ring);
        const double part = ring - static_cast<double>(below);
        if (below + 1 >= kRings) continue;
        rings(below) += (1.0 - part) * lever;
        rings(below + 1) += part * lever;
      }
      for (const auto& patch : sky) {
        if (!(patch.count > 0.0)) continue;
        found.scatter += patch.pull * patch.pull;
        patches += 1.0;
        squares += patch.sum * patch.sum / patch.count;
        counted += patch.count;
      }
    });
    const double freedom = patches > kShape + 1 ? patches / (patches - kShape) : 1e12;
    found.scatter = std::sqrt(freedom * found.scatter);
    found.misfit = std::sqrt(squares / std::max(1.0, counted));
    found.about_sun = rings.norm();
    return found;
  }

 private:
  static constexpr Eigen::Index kRings = 10;   // of 20 deg each: all distances from the sun
  static constexpr std::size_t kPatches = 32;  // of sky, within which the model's errors are correlated
  static Eigen::Index of_t(std::size_t i) { return kShape + 2 * static_cast<Eigen::Index>(i); }

  // For each picture: the derivatives of the model by v2, v4, v6 and T for each sample (by the gain it is 1), and
  // residuals.
  template <class F>
  void for_all(const F& f) const {
    for (std::size_t i = 0; i < used_.size(); ++i) {
      const auto& moment = moments_[used_[i]];
      const PerezLog sky(Turbidity{moment.turbidity});
      std::vector<Eigen::Vector4d> rows;
      std::vector<double> residuals;
      for (const auto& sample : moment.samples) {
        const auto [log_f, slope] = sky.at(sample.at);
        const double light = illumination(sample.r2);
        Eigen::Vector4d row;
        row << sample.r2 / light, sample.r2 * sample.r2 / light, sample.r2 * sample.r2 * sample.r2 / light, slope;
        rows.push_back(row);
        residuals.push_back(sample.log_light - moment.log_gain - log_f - std::log(light));
      }
      f(i, rows, residuals);
    }
  }

  void build() {
    const auto size = of_t(used_.size());
    normal_ = Eigen::MatrixXd::Zero(size, size);
    right_ = Eigen::VectorXd::Zero(size);
    for_all([&](std::size_t i, const std::vector<Eigen::Vector4d>& rows, const std::vector<double>& residuals) {
      const auto& samples = moments_[used_[i]].samples;
      Eigen::Matrix<double, kShape + 2, kShape + 2> block = Eigen::Matrix<double, kShape + 2, kShape + 2>::Zero();
      Eigen::Matrix<double, kShape + 2, 1> pull = Eigen::Matrix<double, kShape + 2, 1>::Zero();
      for (std::size_t s = 0; s < samples.size(); ++s) {
        if (!samples[s].used) continue;
        Eigen::Matrix<double, kShape + 2, 1> row;
        row << rows[s], 1.0;
        block += samples[s].weight * row * row.transpose();
        pull += samples[s].weight * residuals[s] * row;
      }
      const auto t = of_t(i);
      normal_.topLeftCorner<kShape, kShape>() += block.topLeftCorner<kShape, kShape>();
      normal_.block<2, 2>(t, t) += block.bottomRightCorner<2, 2>();
      normal_.block<kShape, 2>(0, t) += block.topRightCorner<kShape, 2>();
      normal_.block<2, kShape>(t, 0) += block.bottomLeftCorner<2, kShape>();
      right_.head<kShape>() += pull.head<kShape>();
      right_.segment<2>(t) += pull.tail<2>();
      if (known_turbidity_) normal_(t, t) += 1e12;  // held fixed
    });
  }

  void drop_outliers() {
    std::vector<double> all;
    for (const auto m : used_)
      for (const auto& sample : moments_[m].samples) all.push_back(residual(moments_[m], sample));
    const double limit = kOutlier * std::max(1e-3, robust_sigma(std::move(all)));
    for (const auto m : used_)
      for (auto& sample : moments_[m].samples) sample.used = std::abs(residual(moments_[m], sample)) <= limit;
  }

  std::vector<Moment>& moments_;
  std::array<double, kShape> shape_;
  bool known_turbidity_ = false;
  std::vector<std::size_t> used_;
  Eigen::MatrixXd normal_;
  Eigen::VectorXd right_;
};

// What stays the same over the rounds: the bare camera's light and the lens's centre.
struct Bare {
  Camera camera;
  std::optional<ElementGeometry> geometry;
  glm::dvec2 centre{};
};

Moment look_at(SkyObserver& observer, Bare& bare, const SunMoment& seen, double radius_px,
               const VignettingRequest& options) {
  // A lens whose vignetting is not known yet leaves larger residuals than a clear sky may.
  EstimateParameters look_options;
  look_options.largest_log_residual = 0.4;
  look_options.least_agreement = 0.2;
  look_options.largest_relative_sigma = 1.0;
  Moment moment;
  const auto observation = observer.observe(seen.picture, seen.sun, look_options);
  if (!observation.estimate.usable) {
    moment.reason = observation.estimate.reason;
    return moment;
  }
  moment.turbidity = observation.estimate.turbidity.value;
  const SampleLimits limits;
  if (!bare.geometry || !bare.geometry->fits(seen.picture)) bare.geometry = sky_geometry(bare.camera, seen.picture);
  auto light = sky_light(seen.picture, *bare.geometry, seen.sun, limits);
  for (std::size_t i = 0; i < light.use.elements().size(); ++i)
    if (observation.use.elements()[i] != PixelUse::clear) light.use.elements()[i] = PixelUse::cloud;
  const auto elements = spread(light.use, options.samples);
  const auto samples = samples_at(elements, seen.picture, *bare.geometry, light, bare.camera, seen.sun, limits);
  double sum = 0.0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const glm::dvec2 off = (seen.picture.camera_pixel(elements[i].x, elements[i].y) - bare.centre) / radius_px;
    Sample sample;
    sample.at = perez_point(samples[i]);
    sample.zenith = static_cast<double>(samples[i].zenith);
    sample.r2 = glm::dot(off, off);
    sample.log_light = static_cast<double>(samples[i].log_luminance);
    // Half a percent of model error, so that bright pixels do not dominate.
    sample.weight = 1.0 / (2.5e-5 + std::pow(static_cast<double>(samples[i].sigma), 2));
    const int ring = std::min(3, static_cast<int>(sample.zenith / 0.35));
    sample.patch = 8 * ring + std::min(7, static_cast<int>(sample.at.gamma / 0.35));
    sum += sample.log_light;
    moment.samples.push_back(sample);
  }
  if (moment.samples.size() < kFewestSamples)
    moment.reason = fmt::format("{} clear samples: expected at least {}", moment.samples.size(), kFewestSamples);
  else
    moment.log_gain = sum / static_cast<double>(moment.samples.size()) - 1.0;
  return moment;
}

// The largest distance from the centre at which the sky is used.
double reach_px(const Camera& camera, const glm::dvec2& centre, const SkyPicture& picture) {
  const double lowest = std::cos(SampleLimits{}.largest_zenith.value);
  double reach = 0.0;
  for (int y = 0; y < picture.encoded.height(); ++y)
    for (int x = 0; x < picture.encoded.width(); ++x) {
      const auto pixel = picture.camera_pixel(x, y);
      const auto direction = camera.direction_at(pixel);
      if (direction && direction->z > lowest) reach = std::max(reach, glm::distance(pixel, centre));
    }
  return reach;
}

// The largest distance from the centre that the lens images: the curve must be valid there too.
double lens_reach_px(const Camera& camera, const glm::dvec2& centre) {
  double reach = 0.0;
  for (int y = 0; y < camera.height; y += 4)
    for (int x = 0; x < camera.width; x += 4)
      if (camera.lens->unproject({x, y})) reach = std::max(reach, glm::distance(glm::dvec2{x, y}, centre));
  return reach + 4.0;
}

// Medians over rings of the picture's light relative to the sky model's.
std::vector<glm::dvec2> profile_of(const Fit& fit, const Moment& moment, double radius_px) {
  constexpr std::size_t kBins = 16;  // rings of the plot
  std::array<std::vector<double>, kBins> rings;
  for (const auto& sample : moment.samples)
    if (sample.used)
      rings[std::min(kBins - 1, static_cast<std::size_t>(std::sqrt(sample.r2) * kBins))].push_back(
          fit.illumination(sample.r2) * std::exp(fit.residual(moment, sample)));
  std::vector<glm::dvec2> profile;
  for (std::size_t b = 0; b < kBins; ++b) {
    auto& values = rings[b];
    if (values.size() < 10) continue;
    profile.emplace_back(radius_px * (static_cast<double>(b) + 0.5) / kBins, median_in_place(values));
  }
  return profile;
}

}  // namespace

Result<FoundVignetting> vignetting_from_sky(const Camera& camera, std::span<const SunMoment> seen,
                                            const VignettingRequest& options) {
  if (seen.empty()) return fail(FaultKind::bad_input, "no sky picture to measure vignetting from");
  Bare bare{camera, std::nullopt, {}};
  bare.camera.vignetting = {};
  const auto centre = camera.lens->project({0.0, 0.0, 1.0});
  if (!centre) return fail(FaultKind::bad_input, "the sky camera's lens does not see its own axis");
  bare.centre = *centre;
  const double radius_px = reach_px(bare.camera, bare.centre, seen.front().picture);
  if (!(radius_px > 1.0))
    return fail(FaultKind::bad_input, "the sky camera sees no sky: expected one that points upwards");

  FoundVignetting result;
  result.vignetting = {bare.centre, radius_px, {}};
  std::vector<Moment> moments;
  Fit::Certainty certainty;
  for (int round = 0; round < kMaskRounds; ++round) {
    Camera corrected = bare.camera;
    corrected.vignetting = result.vignetting;
    SkyObserver observer(corrected);
    moments.clear();
    for (const auto& moment : seen) moments.push_back(look_at(observer, bare, moment, radius_px, options));
    Fit fit(moments, result.vignetting.coefficients, options.turbidity);
    if (fit.pictures() == 0)
      return fail(FaultKind::bad_input, "none of {} pictures shows enough clear sky (the first, {}: {})", seen.size(),
                  seen.front().name, moments.front().reason);
    fit.solve();
    result.vignetting.coefficients = fit.shape();
    result.pictures = static_cast<int>(fit.pictures());
    if (round + 1 < kMaskRounds) continue;
    certainty = fit.certainty();
    result.residuals.clear();
    for (const auto& moment : moments) {
      const bool used = moment.reason.empty();
      result.moments.push_back({used, moment.reason, Turbidity{moment.turbidity},
                                used ? profile_of(fit, moment, radius_px) : std::vector<glm::dvec2>{}});
      for (const auto& sample : moment.samples)
        if (used && sample.used) result.residuals.push_back(fit.residual(moment, sample));
    }
  }
  double squares = 0.0;
  for (const double residual : result.residuals) squares += residual * residual;
  result.residual = std::sqrt(squares / static_cast<double>(std::max<std::size_t>(1, result.residuals.size())));
  const double by_sky = kAbsorbed * certainty.misfit * certainty.about_sun;
  const double by_turbidity = options.turbidity ? options.turbidity->sigma * certainty.by_turbidity : 0.0;
  result.rim_sigma = std::hypot(certainty.scatter, by_sky, by_turbidity);
  result.by_3_percent_about_sun = kSkyModelError * certainty.about_sun;
  result.by_3_percent_at_rim = kSkyModelError * certainty.at_rim;
  for (std::size_t a = 0; a < seen.size(); ++a)
    for (std::size_t b = 0; b < a; ++b)
      if (result.moments[a].used && result.moments[b].used)
        result.sun_way = std::max(result.sun_way, angle_between(seen[a].sun, seen[b].sun));
  if (!options.turbidity && result.sun_way < options.least_sun_way)
    return fail(FaultKind::bad_input,
                "{} picture{} with the sun in one place (within {:.0f} deg, expected {:.0f} or more): the effects "
                "of lens and T cannot be separated; a sky that differs from the model by 3 % would change the "
                "illumination at the rim by {:.0f} %; take pictures over several hours, or give T",
                result.pictures, result.pictures == 1 ? "" : "s", to_degrees(result.sun_way),
                to_degrees(options.least_sun_way), 100.0 * result.by_3_percent_about_sun);
  if (!(result.rim_sigma <= options.largest_rim_sigma))
    return fail(
        FaultKind::bad_input,
        "{} pictures leave the illumination at the rim uncertain by {:.1f} % (one standard deviation, expected {:.1f} "
        "or less): the sky differs from the model by {:.1f} %; give T, or take a flat field",
        result.pictures, 100.0 * result.rim_sigma, 100.0 * options.largest_rim_sigma, 100.0 * certainty.misfit);
  const auto& v = result.vignetting.coefficients;
  const double farthest_px = lens_reach_px(camera, bare.centre);
  const auto dark = first_positive_root({1.0, v[0], v[1], v[2]});
  if (dark && std::sqrt(*dark) * radius_px <= farthest_px)
    return fail(FaultKind::bad_input,
                "the fit darkens to zero {:.0f} px from the centre, but the lens images up to {:.0f} px: "
                "expected a clear sky and the right lens; is the lens's largest_angle_deg right?",
                std::sqrt(*dark) * radius_px, farthest_px);
  return result;
}

}  // namespace kasumi
