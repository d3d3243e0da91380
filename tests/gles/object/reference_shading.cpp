#include "tests/gles/object/reference_shading.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include <glm/geometric.hpp>

#include "base/units.hpp"

namespace kasumi {
namespace {

// The real spherical harmonics of order 2, those of each order times a factor.
std::array<double, 9> basis_of(const glm::dvec3& n, double first, double second) {
  const double pi = kPi;
  return {0.5 * std::sqrt(1 / pi),
          first * std::sqrt(3 / (4 * pi)) * n.y,
          first * std::sqrt(3 / (4 * pi)) * n.z,
          first * std::sqrt(3 / (4 * pi)) * n.x,
          second * 0.5 * std::sqrt(15 / pi) * n.x * n.y,
          second * 0.5 * std::sqrt(15 / pi) * n.y * n.z,
          second * 0.25 * std::sqrt(5 / pi) * (3 * n.z * n.z - 1),
          second * 0.5 * std::sqrt(15 / pi) * n.x * n.z,
          second * 0.25 * std::sqrt(15 / pi) * (n.x * n.x - n.y * n.y)};
}

glm::dvec3 harmonics(const ReferenceSky& sky, const glm::dvec3& n, double first, double second) {
  const auto basis = basis_of(n, first, second);
  glm::dvec3 sum{0.0};
  for (std::size_t i = 0; i < 9; ++i) sum += basis[i] * sky.radiance[i];
  return glm::max(sum, glm::dvec3{0.0});
}

// Facets by tilt and azimuth. Tilts with tan(tilt) = width t / (1 - t) give GGX's peak as many facets as its tail.
template <class Visit>
void each_facet(double roughness, int tilts, int turns, Visit visit) {
  const double width = std::max(roughness * roughness, 1e-6);
  for (int i = 0; i < tilts; ++i) {
    const double t = (i + 0.5) / tilts;
    const double tangent = width * t / (1.0 - t), slope = width / ((1.0 - t) * (1.0 - t));
    const double cosine = 1.0 / std::sqrt(1.0 + tangent * tangent), sine = tangent * cosine;
    const double ring = sine * slope * cosine * cosine / tilts;  // solid angle of this tilt over 2 pi
    for (int j = 0; j < turns; ++j) visit(sine, cosine, kPi * (j + 0.5) / turns, 2.0 * kPi * ring / turns);
  }
}

struct Smear {
  double first = 0.0;
  double second = 0.0;
};

// Factors by which the lobe, seen along the normal, reduces the first and second Legendre polynomials.
Smear smear_of(double roughness) {
  double weight = 0.0;
  Smear sum;
  each_facet(roughness, 500, 1, [&](double, double nh, double, double solid_angle) {
    const double nl = 2.0 * nh * nh - 1.0;
    if (nl <= 0.0) return;
    const double a2 = std::pow(roughness, 4), d = nh * nh * (a2 - 1.0) + 1.0;
    const double share = a2 / (kPi * d * d) * nh * solid_angle * nl;
    weight += share;
    sum.first += share * nl;
    sum.second += share * (1.5 * nl * nl - 0.5);
  });
  return {sum.first / weight, sum.second / weight};
}

// The same at the roughness whose head-on lobe has a mean direction of this length.
Smear smear_of_mean(double length) {
  double low = 0.01, high = 1.0;
  for (int i = 0; i < 12; ++i) {
    const double middle = 0.5 * (low + high);
    (smear_of(middle).first > length ? low : high) = middle;
  }
  return smear_of(0.5 * (low + high));
}

}  // namespace

double microfacet_brdf(double nh, double nl, double nv, double roughness) {
  const double a2 = std::pow(roughness, 4);
  const double d = nh * nh * (a2 - 1.0) + 1.0;
  const double distribution = a2 / (kPi * d * d);
  const auto lambda = [a2](double cosine) {
    const double tangent2 = 1.0 / (cosine * cosine) - 1.0;
    return 0.5 * (std::sqrt(1.0 + a2 * tangent2) - 1.0);
  };
  return distribution / (1.0 + lambda(nl) + lambda(nv)) / (4.0 * nl * nv);
}

ReferenceGivenBack reference_given_back(double across, double roughness) {
  ReferenceGivenBack sum;
  each_facet(roughness, 64, 24, [&](double sine, double nh, double turn, double solid_angle) {
    const double vh = std::sqrt(1.0 - across * across) * sine * std::cos(turn) + across * nh;
    const double nl = 2.0 * vh * nh - across;
    if (vh <= 0.0 || nl <= 0.0) return;
    const double given = microfacet_brdf(nh, nl, across, roughness) * nl * 4.0 * vh * solid_angle;
    const double edge = std::pow(1.0 - vh, 5);
    sum.head_on += given * (1.0 - edge);
    sum.edge += given * edge;
    sum.mean_along += given * nl;
    sum.mean_aside += given * (std::sqrt(1.0 - across * across) - 2.0 * vh * sine * std::cos(turn));
  });
  sum.mean_along /= sum.head_on + sum.edge;
  sum.mean_aside /= sum.head_on + sum.edge;
  return sum;
}

// Cell by cell of the octahedron's map, each cell the mean of its corners, its solid angle that of its two triangles.
ReferenceSky reference_sky(const ObjectLight& light) {
  const Image<glm::vec3>& map = light.around.radiance;
  const auto towards = [&](int x, int y) {
    const double east = 2.0 * x / (map.width() - 1) - 1.0, north = 2.0 * y / (map.height() - 1) - 1.0;
    const double up = 1.0 - std::abs(east) - std::abs(north);
    if (up >= 0.0) return glm::normalize(glm::dvec3{east, north, up});
    return glm::normalize(glm::dvec3{(1.0 - std::abs(north)) * (east < 0.0 ? -1.0 : 1.0),
                                     (1.0 - std::abs(east)) * (north < 0.0 ? -1.0 : 1.0), up});
  };
  ReferenceSky sky;
  double whole = 0.0;
  for (int y = 0; y + 1 < map.height(); ++y)
    for (int x = 0; x + 1 < map.width(); ++x) {
      const glm::dvec3 a = towards(x, y), b = towards(x + 1, y), c = towards(x, y + 1), d = towards(x + 1, y + 1);
      const double solid_angle = 0.5 * (glm::length(glm::cross(b - a, c - a)) + glm::length(glm::cross(b - d, c - d)));
      whole += solid_angle;
      const glm::dvec3 radiance =
          0.25 * glm::dvec3(map.at(x, y) + map.at(x + 1, y) + map.at(x, y + 1) + map.at(x + 1, y + 1));
      const auto basis = basis_of(glm::normalize(a + b + c + d), 1.0, 1.0);
      for (std::size_t i = 0; i < 9; ++i) sky.radiance[i] += solid_angle * basis[i] * radiance;
    }
  for (glm::dvec3& coefficient : sky.radiance) coefficient *= 4.0 * kPi / whole;
  return sky;
}

// Irradiance is radiance convolved with the cosine: its orders times pi, 2 pi / 3 and pi / 4.
glm::dvec3 reference_sky_irradiance(const ReferenceSky& sky, const glm::dvec3& n) {
  return kPi * harmonics(sky, n, 2.0 / 3.0, 0.25);
}

glm::dvec3 reference_sky_radiance(const ReferenceSky& sky, const glm::dvec3& towards) {
  return harmonics(sky, towards, 1.0, 1.0);
}

glm::dvec3 reference_radiance(const ModelMaterial& material, const ReferenceSurface& surface, const ObjectLight& light,
                              const ReferenceSky& sky, const glm::dvec3& to_eye) {
  const auto in_channels = [&](const glm::dvec3& colour) {
    return glm::clamp(light.albedo_to_channels * colour, 0.0, 1.0);
  };
  const glm::dvec3 white =
      (reference_sky_irradiance(sky, {0, 0, 1}) + light.sun_irradiance * std::max(light.sun_direction.z, 0.0)) / kPi;
  const glm::dvec3 body = in_channels(glm::dvec3(surface.colour));
  if (material.unlit) return body * white;
  const glm::dvec3 emitted = glm::max(light.albedo_to_channels * surface.emission, glm::dvec3{0.0}) * white;
  const glm::dvec3 n = surface.normal;
  const double towards_sun = std::max(glm::dot(n, light.sun_direction), 0.0);
  const glm::dvec3 matt =
      (surface.open_sky * reference_sky_irradiance(sky, n) + surface.sun_seen * towards_sun * light.sun_irradiance) /
      kPi;
  if (!material.reflects()) return body * matt + emitted;

  const double m = surface.metallic;
  const glm::dvec3 f0 = in_channels(glm::dvec3(material.reflectance)) * (1.0 - m) + body * m;
  const glm::dvec3 f90{double(material.edge_reflectance) * (1.0 - m) + m};
  const double across = std::clamp(glm::dot(n, to_eye), 0.002, 1.0);

  // Scenes contain many angles and roughnesses: integrated at the nearest multiples of .005 and .01.
  static std::map<std::pair<long, long>, std::pair<ReferenceGivenBack, Smear>> known;
  const long angle_step = std::lround(across * 200.0), rough_step = std::lround(surface.roughness * 100.0);
  const double rough = std::max(double(rough_step), 2.0) / 100.0;
  const auto [found, is_new] = known.try_emplace(std::pair(angle_step, rough_step));
  auto& [back, smear] = found->second;
  if (is_new) {
    back = reference_given_back(std::max(double(angle_step), 0.4) / 200.0, rough);
    smear = smear_of_mean(std::hypot(back.mean_along, back.mean_aside));
  }

  // glTF 2.0, B.2: a fraction m of metal mixed with a fraction 1 - m of coated dielectric.
  const double all = back.head_on + back.edge;
  const auto once_and_between = [&](const glm::dvec3& head_on, const glm::dvec3& edge) {
    const glm::dvec3 first = head_on * back.head_on + edge * back.edge;
    const glm::dvec3 mean = head_on + (edge - head_on) / 21.0;  // of Schlick's Fresnel over the hemisphere
    return std::pair(first, first * mean * (1.0 - all) / (1.0 - mean * (1.0 - all)));
  };
  const auto [coat_once, coat_between] =
      once_and_between(in_channels(glm::dvec3(material.reflectance)), glm::dvec3{double(material.edge_reflectance)});
  const auto [metal_once, metal_between] = once_and_between(body, glm::dvec3{1.0});
  const glm::dvec3 once = (1.0 - m) * coat_once + m * metal_once,
                   between = (1.0 - m) * coat_between + m * metal_between;
  const glm::dvec3 coloured = (1.0 - m) * body * (1.0 - coat_once - coat_between);

  // The lobe's mean direction, which lies in the plane of normal and eye, and its spread around it.
  const double r = surface.roughness;
  const glm::dvec3 away = glm::dot(to_eye, n) * n - to_eye;
  const glm::dvec3 aside = glm::length(away) > 1e-9 ? glm::normalize(away) : glm::dvec3{0.0};
  const glm::dvec3 image = glm::normalize(back.mean_along * n + back.mean_aside * aside);
  const glm::dvec3 mirrored = harmonics(sky, image, smear.first, smear.second);
  const double open = surface.open_sky;
  const double open_image = std::clamp(std::pow(across + open, std::pow(2.0, -16.0 * r - 1.0)) - 1.0 + open, 0.0, 1.0);

  glm::dvec3 glint{0.0};
  if (towards_sun > 0.0) {
    const glm::dvec3 facet = glm::normalize(to_eye + light.sun_direction);
    // The sun's disc: GGX's squared width grows by the disc's solid angle over 4 pi.
    const double wide = std::pow(std::pow(r, 4) + 5.4e-6, 0.25);
    const glm::dvec3 fresnel = f0 + (f90 - f0) * std::pow(1.0 - glm::dot(to_eye, facet), 5);
    glint = fresnel * microfacet_brdf(glm::dot(n, facet), towards_sun, across, wide) * towards_sun * surface.sun_seen *
            light.sun_irradiance;
  }
  return (coloured + between) * matt + open_image * once * mirrored + glint + emitted;
}

}  // namespace kasumi
