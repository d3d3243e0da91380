// The radiance of a surface by its material, in double precision and none of the renderer's code: reflectances are
// integrated numerically from the microfacet model that glTF specifies.
#pragma once

#include <array>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "gles/model/model.hpp"
#include "gles/scene.hpp"

namespace kasumi {

// A material with its textures sampled.
struct ReferenceSurface {
  glm::dvec4 colour{1.0};
  glm::dvec3 normal{0, 0, 1};  // world, towards the eye's side
  double metallic = 0.0;
  double roughness = 1.0;
  double open_sky = 1.0;
  double sun_seen = 1.0;  // visible fraction of the sun's disc
  glm::dvec3 emission{0.0};
};

// The surroundings' radiance in spherical harmonics of order 2, integrated over their map: complete for skies as smooth
// as those of these tests.
struct ReferenceSky {
  std::array<glm::dvec3, 9> radiance{};
};
ReferenceSky reference_sky(const ObjectLight& light);

// Under sun and sky, as the renderer is meant to approximate it (split sum, energy conserved).
glm::dvec3 reference_radiance(const ModelMaterial& material, const ReferenceSurface& surface, const ObjectLight& light,
                              const ReferenceSky& sky, const glm::dvec3& to_eye);

// GGX distribution times Smith's height-correlated visibility (masking over 4 n.l n.v), without Fresnel: 1/sr.
double microfacet_brdf(double nh, double nl, double nv, double roughness);

// Schlick's f0 and f90 terms of the light that one reflection returns from uniform surroundings of radiance 1.
struct ReferenceGivenBack {
  double head_on = 0.0;
  double edge = 0.0;
  double mean_along = 0.0;  // mean direction: along the normal, and at right angles to it away from the eye
  double mean_aside = 0.0;
};
ReferenceGivenBack reference_given_back(double across, double roughness);

// Irradiance on a surface of normal n; radiance from n.
glm::dvec3 reference_sky_irradiance(const ReferenceSky& sky, const glm::dvec3& n);
glm::dvec3 reference_sky_radiance(const ReferenceSky& sky, const glm::dvec3& towards);

}  // namespace kasumi
