#include "tests/paper/methods.hpp"

#include <cmath>

#include <glm/common.hpp>

#include "estimator/horizon/horizon.hpp"
#include "estimator/photograph/depth_from_haze.hpp"
#include "estimator/photograph/land_around.hpp"
#include "estimator/photograph/picture_noise.hpp"
#include "estimator/photograph/retarget.hpp"
#include "tests/paper/single_image.hpp"

namespace kasumi::paper {
namespace {

glm::dvec3 encoded(const Camera& camera, const glm::dvec2& pixel, const glm::dvec3& light) {
  return glm::clamp(camera.response.to_encoded(light * camera.white_balance * camera.vignetting.at(pixel)), 0.0, 1.0);
}

Image<glm::vec3> encoded(const Camera& camera, const Image<glm::vec3>& light) {
  Image<glm::vec3> result(light.width(), light.height());
  for (int y = 0; y < light.height(); ++y)
    for (int x = 0; x < light.width(); ++x) result.at(x, y) = encoded(camera, {x, y}, glm::dvec3(light.at(x, y)));
  return result;
}

Image<Rgb8> pixels_of(const Image<glm::vec3>& encoded) {
  Image<Rgb8> picture(encoded.width(), encoded.height());
  for (std::size_t i = 0; i < picture.elements().size(); ++i)
    picture.elements()[i] = Rgb8(glm::round(255.0F * glm::clamp(encoded.elements()[i], 0.0F, 1.0F)));
  return picture;
}

Image<glm::vec3> values_of(const Image<Rgb8>& picture) {
  Image<glm::vec3> values(picture.width(), picture.height());
  for (std::size_t i = 0; i < values.elements().size(); ++i)
    values.elements()[i] = glm::vec3(picture.elements()[i]) / 255.0F;
  return values;
}

Image<glm::vec3> light_of(const Camera& camera, const Image<glm::vec3>& values) {
  Image<glm::vec3> light(values.width(), values.height());
  for (int y = 0; y < light.height(); ++y)
    for (int x = 0; x < light.width(); ++x) light.at(x, y) = camera.light_at({x, y}, glm::dvec3(values.at(x, y)));
  return light;
}

template <class Operation>
Image<glm::vec3> each(const Image<glm::vec3>& one, const Image<glm::vec3>& other, Operation operation) {
  Image<glm::vec3> result(one.width(), one.height());
  for (std::size_t i = 0; i < result.elements().size(); ++i)
    result.elements()[i] = operation(one.elements()[i], other.elements()[i]);
  return result;
}
Image<glm::vec3> quotient(const Image<glm::vec3>& one, const Image<glm::vec3>& other) {
  return each(one, other, [](const glm::vec3& a, const glm::vec3& b) { return a / glm::max(b, 1e-6F); });
}
Image<glm::vec3> product(const Image<glm::vec3>& one, const Image<glm::vec3>& other) {
  return each(one, other, [](const glm::vec3& a, const glm::vec3& b) { return a * b; });
}

// Keeps the best candidate, separately for each measure.
class Best {
 public:
  Best(Method method, const Image<Rgb8>& truth) : truth_(truth) { best_.method = method; }
  void offer(Image<Rgb8> picture) {
    const double alike = ssim(picture, truth_);
    const auto colour = hsv_correlation(picture, truth_);
    if (first_ || colour.combined() > best_.colour.combined()) best_.colour = colour;
    if (first_ || alike > best_.ssim) {
      best_.ssim = alike;
      best_.picture = std::move(picture);
    }
    first_ = false;
  }
  Judged found() && { return std::move(best_); }

 private:
  const Image<Rgb8>& truth_;
  Judged best_;
  bool first_ = true;
};

Image<glm::vec3> everywhere(const Image<glm::vec3>& light, int width, int height) {
  return light.width() == 1 ? Image<glm::vec3>(width, height, light.at(0, 0)) : light;
}

Judged by_one_image(Method method, const Experiment& given, const Image<glm::vec3>& light, double most_thickness) {
  Best best(method, given.truth);
  const int width = given.picture.width(), height = given.picture.height();
  const auto values = values_of(given.picture);
  const auto source = everywhere(given.source.from_infinity, width, height),
             target = everywhere(given.target.from_infinity, width, height);
  for (const bool linear : {false, true}) {
    const auto from = linear ? source : encoded(given.camera, source);
    const auto to = linear ? target : encoded(given.camera, target);
    const auto relative = quotient(linear ? light : values, from);
    auto transmission =
        method == Method::he ? transmission_by_dark_channel(relative, values) : transmission_by_colour(values);
    for (std::size_t i = 0; i < transmission.elements().size(); ++i)
      if (!(given.depth.distance_m.elements()[i] > 0.0F)) transmission.elements()[i] = 1.0F;  // sky keeps its ratio
    constexpr int kSteps = 24;
    for (int i = 0; i <= kSteps; ++i) {
      const double thickness = std::pow(most_thickness, static_cast<double>(i) / kSteps);
      auto made = product(to, with_haze_of(relative, transmission, thickness));
      best.offer(pixels_of(linear ? encoded(given.camera, made) : made));
    }
  }
  return std::move(best).found();
}

RetargetAir air_of(const Scene& scene, double turbidity) {
  const Airlight airlight(measure_horizon(scene.camera, view_of(scene.picture)), Turbidity{turbidity}, scene.sun,
                          scene.camera.light_to_xyz());
  return {Turbidity{turbidity}, light_from_infinity(scene.camera, airlight)};
}

}  // namespace

std::string_view name_of(Method method) {
  switch (method) {
    case Method::ours: return "Kasumi";
    case Method::morales: return "M as printed";
    case Method::he: return "He 2011";
    case Method::zhu: return "Zhu 2015";
    case Method::zhao: return "Zhao 2012";
    case Method::untouched: break;
  }
  return "source untouched";
}

Experiment experiment_of(const Scene& source, double source_turbidity, const Scene& target, double target_turbidity) {
  const auto middle = source.camera.direction_at({0.5 * source.camera.width, 0.5 * source.camera.height});
  return {source.camera,
          source.picture,
          target.picture,
          {source.distance_m, rise_of(source.camera), source.altitude_m},
          air_of(source, source_turbidity),
          air_of(target, target_turbidity),
          relighting(source.camera, Turbidity{source_turbidity}, Turbidity{target_turbidity}, source.sun,
                     middle.value(), source.altitude_m)};
}

std::vector<Judged> judge_methods(const Experiment& given, double most_thickness) {
  const auto spectral = attenuation_nodes(spectral_measure(given.camera));
  const auto values = values_of(given.picture);
  const auto light = light_of(given.camera, values);
  const auto by_distance = [&](const RetargetLimits& options, const AttenuationNodes& nodes,
                               const RetargetHints& parts = {}) {
    return pixels_of(
        encoded(given.camera, retarget(light, given.depth, given.source, given.target, nodes, options, parts).light));
  };
  std::vector<Judged> all;
  for (const Method method : kMethods) {
    if (method == Method::he || method == Method::zhu) {
      all.push_back(by_one_image(method, given, light, most_thickness));
      continue;
    }
    Best best(method, given.truth);
    RetargetLimits options;
    if (method == Method::ours) {
      const auto nodes = given.fog ? grey_attenuation_nodes() : spectral;
      options.relit = given.relit;
      best.offer(by_distance(options, nodes,
                             {light_of(given.camera, without_noise(values, noise_of(values))),
                              land_around(light, given.depth, given.source, nodes)}));
    } else if (method == Method::untouched) {
      best.offer(given.picture);
    } else {
      if (method == Method::zhao) options.scattering = ScatteringModel::zhao;
      best.offer(by_distance(options, spectral));
    }
    all.push_back(std::move(best).found());
  }
  return all;
}

}  // namespace kasumi::paper
