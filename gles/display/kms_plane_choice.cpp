#include "gles/display/kms_plane_choice.hpp"

#include <algorithm>
#include <string>

namespace kasumi {
namespace {

constexpr std::uint32_t kBuildingFormat = drm_format("AR24");

bool has(const KmsPlane& plane, std::uint32_t format) {
  return std::ranges::find(plane.formats, format) != plane.formats.end();
}

// What keeps the plane from showing the camera's picture; empty: nothing.
std::string against_camera(const KmsPlane& plane, std::uint32_t format, std::optional<YuvEncoding> encoding) {
  if (!has(plane, format)) return fmt::format("plane {} does not show {}", plane.id, drm_format_text(format));
  if (encoding && std::ranges::find(plane.encodings, *encoding) == plane.encodings.end())
    return fmt::format("plane {} cannot convert {}", plane.id, name_of(*encoding));
  return {};
}

// Where the driver has no blend property, the kernel's rule is that alpha is premultiplied.
std::string against_building(const KmsPlane& plane) {
  if (!has(plane, kBuildingFormat))
    return fmt::format("plane {} does not show {}", plane.id, drm_format_text(kBuildingFormat));
  if (!plane.premultiplied.value_or(true)) return fmt::format("plane {} does not blend premultiplied alpha", plane.id);
  return {};
}

// Gives them their order. Without zpos, primary planes lie below the others.
bool put_below(const KmsPlane& camera, const KmsPlane& building, KmsPlanePair& pair) {
  if (!camera.zpos || !building.zpos) return camera.kind == KmsPlane::Kind::primary;
  const auto lowest = camera.zpos->fixed ? camera.zpos->now : camera.zpos->least;
  const auto highest = building.zpos->fixed ? building.zpos->now : building.zpos->most;
  if (!camera.zpos->fixed) pair.camera_zpos = lowest;
  if (!building.zpos->fixed) pair.building_zpos = highest;
  return lowest < highest;
}

}  // namespace

Result<std::vector<KmsPlanePair>> choose_planes(const std::vector<KmsPlane>& planes, std::uint32_t primary,
                                                std::uint32_t camera_format, std::optional<YuvEncoding> encoding) {
  const auto base = std::ranges::find(planes, primary, &KmsPlane::id);
  std::vector<KmsPlanePair> pairs;
  std::vector<std::string> reasons;
  const auto consider = [&](const KmsPlane& camera, const KmsPlane& building) {
    std::string why = against_camera(camera, camera_format, encoding);
    if (why.empty()) why = against_building(building);
    KmsPlanePair pair{camera.id, building.id};
    if (why.empty() && !put_below(camera, building, pair))
      why = fmt::format("plane {} cannot lie over plane {}", building.id, camera.id);
    if (why.empty())
      pairs.push_back(pair);
    else if (std::ranges::find(reasons, why) == reasons.end())
      reasons.push_back(why);
  };
  const auto is_other = [&](const KmsPlane& plane) {
    return plane.id != primary && plane.kind == KmsPlane::Kind::overlay && plane.free;
  };
  if (base == planes.end() || std::ranges::none_of(planes, is_other))
    return fail(FaultKind::unsupported, "the display has no overlay plane");
  for (const KmsPlane& other : planes)
    if (is_other(other)) consider(*base, other);
  for (const KmsPlane& other : planes)
    if (is_other(other)) consider(other, *base);
  if (!pairs.empty()) return pairs;
  std::string all;
  for (const std::string& why : reasons) all += (all.empty() ? "" : ", ") + why;
  return fail(FaultKind::unsupported, "{}", all);
}

}  // namespace kasumi
