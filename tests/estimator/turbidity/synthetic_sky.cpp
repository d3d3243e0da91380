#include "tests/estimator/turbidity/synthetic_sky.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <glm/geometric.hpp>

namespace kasumi::test {

namespace {

double distribution(const double (&table)[5][2], double t, double cos_zenith, double gamma) {
  double k[5];
  for (int i = 0; i < 5; ++i) k[i] = table[i][0] * t + table[i][1];
  return (1 + k[0] * std::exp(k[1] / cos_zenith)) *
         (1 + k[2] * std::exp(k[3] * gamma) + k[4] * std::pow(std::cos(gamma), 2));
}

// Linear sRGB of XYZ (IEC 61966-2-1).
glm::dvec3 linear_srgb(const glm::dvec3& xyz) {
  return {3.2406 * xyz.x - 1.5372 * xyz.y - 0.4986 * xyz.z, -0.9689 * xyz.x + 1.8758 * xyz.y + 0.0415 * xyz.z,
          0.0557 * xyz.x - 0.2040 * xyz.y + 1.0570 * xyz.z};
}

glm::dvec3 from_yxy(const glm::dvec3& v) {
  return {v.x * v.y / v.z, v.x, v.x * (1 - v.y - v.z) / v.z};
}

double smooth(double x) {
  return x * x * (3 - 2 * x);
}

// Value noise on a lattice, five octaves.
double fractal(double x, double y, std::uint64_t seed) {
  double sum = 0, amplitude = 1, total = 0;
  for (std::uint64_t octave = 0; octave < 5; ++octave) {
    const double fx = std::floor(x), fy = std::floor(y);
    const auto corner = [&](double i, double j) {
      const auto cell = static_cast<std::uint64_t>(static_cast<std::int64_t>(fx + i) * 73856093 ^
                                                   static_cast<std::int64_t>(fy + j) * 19349663);
      return hashed_uniform(seed * 977 + octave, cell);
    };
    const double u = smooth(x - fx), v = smooth(y - fy);
    sum += amplitude *
           ((1 - v) * ((1 - u) * corner(0, 0) + u * corner(1, 0)) + v * ((1 - u) * corner(0, 1) + u * corner(1, 1)));
    total += amplitude;
    amplitude *= 0.5;
    x = 2 * x + 17.3;
    y = 2 * y - 9.1;
  }
  return sum / total;
}

double cloud_noise(const Direction& d, const SyntheticSky& sky) {
  const double plane = sky.cloud_scale / (d.z + 0.25);
  return fractal(100 + d.x * plane, 100 + d.y * plane, sky.cloud_seed);
}

}  // namespace

double hashed_uniform(std::uint64_t seed, std::uint64_t index) {
  std::uint64_t z = seed * 0x9e3779b97f4a7c15ull + index * 0xd1342543de82ef95ull + 0x632be59bd9b4e019ull;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
  z ^= z >> 31;
  return static_cast<double>(z >> 11) * 0x1.0p-53;
}

double hashed_normal(std::uint64_t seed, std::uint64_t index) {
  const double u = std::max(1e-300, hashed_uniform(seed, 2 * index)), v = hashed_uniform(seed, 2 * index + 1);
  return std::sqrt(-2 * std::log(u)) * std::cos(2 * kPi * v);
}

glm::dvec3 preetham_yxy(double t, double zenith, double s, double gamma) {
  static constexpr double kY[5][2] = {
      {.1787, -1.4630}, {-.3554, .4275}, {-.0227, 5.3251}, {.1206, -2.5771}, {-.0670, .3703}};
  static constexpr double kSmallX[5][2] = {
      {-.0193, -.2592}, {-.0665, .0008}, {-.0004, .2125}, {-.0641, -.8989}, {-.0033, .0452}};
  static constexpr double kSmallY[5][2] = {
      {-.0167, -.2608}, {-.0950, .0092}, {-.0079, .2102}, {-.0441, -1.6537}, {-.0109, .0529}};
  const double chi = (4.0 / 9.0 - t / 120.0) * (kPi - 2 * s);
  const double zenith_luminance = (4.0453 * t - 4.9710) * std::tan(chi) - 0.2155 * t + 2.4192;
  const double s2 = s * s, s3 = s * s * s;
  const double zenith_x = (.00166 * s3 - .00375 * s2 + .00209 * s) * t * t +
                          (-.02903 * s3 + .06377 * s2 - .03202 * s + .00394) * t +
                          (.11693 * s3 - .21196 * s2 + .06052 * s + .25886);
  const double zenith_y = (.00275 * s3 - .00610 * s2 + .00317 * s) * t * t +
                          (-.04214 * s3 + .08970 * s2 - .04153 * s + .00516) * t +
                          (.15346 * s3 - .26756 * s2 + .06670 * s + .26688);
  const double c = std::max(0.001, std::cos(zenith));
  return {zenith_luminance * distribution(kY, t, c, gamma) / distribution(kY, t, 1, s),
          zenith_x * distribution(kSmallX, t, c, gamma) / distribution(kSmallX, t, 1, s),
          zenith_y * distribution(kSmallY, t, c, gamma) / distribution(kSmallY, t, 1, s)};
}

Camera upward_camera(int side, double field_of_view_deg, Response response) {
  Camera camera;
  camera.name = "sky";
  camera.width = camera.height = side;
  const double radius = side / 2.0, half = from_degrees(field_of_view_deg / 2).value;
  camera.lens = equidistant_lens({radius - 0.5, radius - 0.5}, radius / half, {half});
  camera.to_world = camera_to_world(from_degrees(180), from_degrees(90), {0});
  camera.response = std::move(response);
  return camera;
}

Image<Rgb8> RenderedSky::to_8_bit() const {
  Image<Rgb8> image(encoded.width(), encoded.height());
  for (std::size_t i = 0; i < image.elements().size(); ++i)
    for (int c = 0; c < 3; ++c)
      image.elements()[i][c] =
          static_cast<std::uint8_t>(std::lround(255.0f * std::clamp(encoded.elements()[i][c], 0.0f, 1.0f)));
  return image;
}

RenderedSky render(const SyntheticSky& sky, const Camera& camera) {
  const double s = from_degrees(sky.sun_zenith_deg).value;
  RenderedSky rendered{Image<glm::vec3>(camera.width, camera.height), Image<std::uint8_t>(camera.width, camera.height),
                       direction_from({s}, from_degrees(sky.sun_azimuth_deg))};
  const Direction sun = rendered.sun;

  // The noise level above which there is cloud, for the requested cover.
  double level = 2;
  if (sky.cloud_cover > 0) {
    std::vector<double> noise;
    constexpr int kRings = 120, kSectors = 240;
    const double lowest = std::cos(from_degrees(80).value);
    for (int i = 0; i < kRings; ++i)
      for (int j = 0; j < kSectors; ++j) {  // even steps of cos: equal solid angles
        const double z = lowest + (1 - lowest) * (i + 0.5) / kRings, azimuth = 2 * kPi * j / kSectors;
        noise.push_back(
            cloud_noise({std::sqrt(1 - z * z) * std::sin(azimuth), std::sqrt(1 - z * z) * std::cos(azimuth), z}, sky));
      }
    std::ranges::sort(noise);
    const auto at = static_cast<std::size_t>((1 - sky.cloud_cover) * static_cast<double>(noise.size() - 1));
    level = noise[at];
  }
  constexpr double kEdge = 0.05;  // of the noise: from no cloud to a thick one

  const auto clear = [&](const Direction& d) {
    if (sky.clear) return sky.clear(d);
    return from_yxy(preetham_yxy(sky.turbidity, zenith_angle(d).value, s, angle_between(d, sun).value));
  };
  const double zenith_luminance = clear({0, 0, 1}).y;
  double brightest = 0;
  for (int i = 0; i < 360; ++i)
    for (int j = 10; j <= 80; j += 2) {
      const Direction d = direction_from(from_degrees(j), from_degrees(i));
      if (angle_between(d, sun).value < from_degrees(10).value) continue;
      const glm::dvec3 rgb = linear_srgb(clear(d));
      brightest = std::max({brightest, rgb.r, rgb.g, rgb.b});
    }

  glm::dvec3 sum{0.0};
  int seen = 0;
  Image<glm::vec3> light(camera.width, camera.height);
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      const auto d = camera.direction_at({x, y});
      if (!d || d->z <= 0) continue;
      const double gamma = angle_between(*d, sun).value;
      glm::dvec3 xyz = clear(*d);
      if (sky.sun_disc && gamma < from_degrees(0.27).value) xyz = glm::dvec3{0.95, 1.0, 1.05} * 1e6;
      const double texture =
          fractal(200 + 3 * d->x / (d->z + 0.25), 200 + 3 * d->y / (d->z + 0.25), sky.cloud_seed + 7);
      if (sky.weather == Weather::overcast)
        xyz = from_yxy({zenith_luminance * (1 + 2 * d->z) / 3 * (0.9 + 0.2 * texture), 0.318, 0.330});
      if (sky.weather == Weather::fog) xyz = from_yxy({zenith_luminance * (0.8 + 0.2 * d->z), 0.322, 0.335});
      if (sky.cloud_cover > 0) {
        const double noise = cloud_noise(*d, sky);
        const double cover = smooth(std::clamp((noise - level) / kEdge + 0.5, 0.0, 1.0));
        // Thick centres are grey, thin edges white, and both brighter towards the sun.
        const double thick = std::clamp((noise - level) / 0.25, 0.0, 1.0);
        const double bright =
            zenith_luminance * (2.4 - 1.5 * thick) * (1 + 1.5 * std::exp(-3 * gamma)) * (0.8 + 0.4 * texture);
        xyz = (1 - cover) * xyz + cover * from_yxy({bright, 0.325, 0.338});
        if (cover > 0.02) rendered.cloud.at(x, y) = 1;
      }
      const glm::dvec3 rgb = glm::max(glm::dvec3{0.0}, linear_srgb(xyz) * (sky.exposure / brightest));
      light.at(x, y) = glm::vec3(rgb);
      sum += glm::min(rgb, glm::dvec3{1.0});
      ++seen;
    }
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      if (!camera.direction_at({x, y})) continue;
      glm::dvec3 rgb(light.at(x, y));
      rgb += sky.flare * sum / static_cast<double>(std::max(1, seen));
      const auto index =
          static_cast<std::uint64_t>(y) * static_cast<std::uint64_t>(camera.width) + static_cast<std::uint64_t>(x);
      if (sky.weather == Weather::covered_dark) rgb = glm::dvec3{0.004};
      if (sky.weather == Weather::covered_bright) rgb = glm::dvec3{0.35, 0.34, 0.33};
      for (int c = 0; c < 3; ++c)
        rgb[c] += sky.noise * std::sqrt(std::max(0.0, rgb[c])) *
                  hashed_normal(sky.noise_seed, 3 * index + static_cast<std::uint64_t>(c));
      rendered.encoded.at(x, y) = glm::vec3(camera.response.to_encoded(glm::clamp(rgb, 0.0, 1.0)));
    }
  return rendered;
}

}  // namespace kasumi::test
