#include "tests/estimator/turbidity/estimate_often.hpp"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "tests/estimator/turbidity/cramer_rao.hpp"

namespace kasumi::test {
namespace {

SunDirection turned(const SunDirection& sun, double degrees, double around) {
  const glm::dvec3 a = glm::normalize(glm::cross(sun, glm::dvec3{0.0, 0.0, 1.0})), b = glm::cross(a, sun);
  const double angle = from_degrees(degrees).value;
  return std::cos(angle) * sun + std::sin(angle) * (std::cos(around) * a + std::sin(around) * b);
}

}  // namespace

Repeated estimate_often(const SyntheticSky& description, EstimateParameters options, int repeats,
                        double sun_error_deg) {
  const Camera camera = upward_camera(500);
  const RenderedSky rendered = render(description, camera);
  const Image<Rgb8> image = rendered.to_8_bit();
  const SkyPicture picture = *sky_picture(view_of(image), camera);
  SkyObserver observer(camera);
  Repeated row;
  double sum = 0.0, squares = 0.0;
  for (int i = 0; i < repeats; ++i) {
    options.samples = 100;
    options.seed = 1000 + static_cast<std::uint64_t>(i);
    const double around = 2.0 * kPi * hashed_uniform(99, static_cast<std::uint64_t>(i));
    const TurbidityObservation look = observer.observe(
        picture, sun_error_deg > 0.0 ? turned(rendered.sun, sun_error_deg, around) : rendered.sun, options);
    if (!look.estimate.usable) continue;
    ++row.usable;
    const double error = look.estimate.turbidity.value - description.turbidity;
    sum += error;
    squares += error * error;
    row.worst = std::max(row.worst, std::abs(error));
    row.bound += cramer_rao_sigma(look.samples, Turbidity{description.turbidity}, true);
    row.stated += look.estimate.sigma;
  }
  const double bias = sum / row.usable;
  row.mean = description.turbidity + bias;
  row.sigma = std::sqrt(std::max(0.0, squares / row.usable - bias * bias));
  row.bound /= row.usable;
  row.stated /= row.usable;
  return row;
}

}  // namespace kasumi::test
