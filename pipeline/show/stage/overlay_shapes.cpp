#include "pipeline/show/stage/overlay_shapes.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include "base/earth.hpp"

namespace kasumi {

namespace {

constexpr int kPieces = 96;  // segments per grid line, since a lens bends it

Direction direction_of(double azimuth_deg, double elevation_deg) {
  return direction_from(from_degrees(90.0 - elevation_deg), from_degrees(azimuth_deg));
}

// Directions that the picture covers, degrees; azimuths may exceed 360 or be negative, so that the range has no gap.
struct Extent {
  double least_azimuth = 1e9, greatest_azimuth = -1e9, least_elevation = 90.0, greatest_elevation = -90.0;
  double azimuths() const { return greatest_azimuth - least_azimuth; }
  double elevations() const { return greatest_elevation - least_elevation; }
};

class Shapes {
 public:
  Shapes(const Installation& installation, const ModelBounds& bounds)
      : installation_(installation), scene_(installation.scene), bounds_(bounds) {}

  OverlayShapes all() {
    add_object();
    add_landmarks();
    add_horizon();
    add_grid();
    return std::move(shapes_);
  }

 private:
  bool contains(const glm::dvec2& pixel) const {
    return pixel.x >= -0.5 && pixel.y >= -0.5 && pixel.x <= scene_.width - 0.5 && pixel.y <= scene_.height - 0.5;
  }
  // Far outside its range, the lens's polynomial may fold back into the picture.
  std::optional<glm::dvec2> pixel_of(const glm::dvec3& place) const {
    if (glm::length(place) <= 0.0) return std::nullopt;
    const auto direction = glm::normalize(place);
    const auto pixel = scene_.pixel_of(direction);
    if (!pixel || !contains(*pixel)) return pixel;
    const auto back = scene_.direction_at(*pixel);
    return back && angle_between(*back, direction).value < 1e-4 ? pixel : std::nullopt;
  }

  // Adds the visible parts of a line; returns its points inside the picture.
  template <class PlaceAt>
  std::vector<glm::dvec2> add_line(OverlayLineKind kind, int pieces, PlaceAt place_at) {
    std::vector<glm::dvec2> inside;
    OverlayLine line{kind, {}};
    const auto end = [&] {
      if (line.points.size() > 1 && std::ranges::any_of(line.points, [&](const auto& p) { return is_near(p); }))
        shapes_.lines.push_back(line);
      line.points.clear();
    };
    for (int i = 0; i <= pieces; ++i) {
      const auto pixel = pixel_of(place_at(static_cast<double>(i) / pieces));
      if (!pixel || !is_near(*pixel)) {
        if (pixel && !line.points.empty()) line.points.push_back(*pixel);  // where it leaves the picture
        end();
        if (pixel) line.points.push_back(*pixel);  // where it may enter the picture
        continue;
      }
      line.points.push_back(*pixel);
      if (contains(*pixel)) inside.push_back(*pixel);
    }
    end();
    return inside;
  }
  bool is_near(const glm::dvec2& pixel) const {
    const double spare = 0.25 * scene_.width;
    return pixel.x > -spare && pixel.y > -spare && pixel.x < scene_.width + spare && pixel.y < scene_.height + spare;
  }

  Extent extent() const {
    constexpr int kSteps = 24;  // sights each way across the picture, whose extent changes little between two
    const double middle = to_degrees(azimuth_angle(scene_.to_world[2]));
    Extent angles;
    for (int j = 0; j <= kSteps; ++j)
      for (int i = 0; i <= kSteps; ++i) {
        const glm::dvec2 pixel{(scene_.width - 1.0) * i / kSteps, (scene_.height - 1.0) * j / kSteps};
        const auto direction = scene_.direction_at(pixel);
        if (!direction) continue;
        const double elevation = 90.0 - to_degrees(zenith_angle(*direction));
        const double azimuth = middle + std::remainder(to_degrees(azimuth_angle(*direction)) - middle, 360.0);
        angles.least_azimuth = std::min(angles.least_azimuth, azimuth);
        angles.greatest_azimuth = std::max(angles.greatest_azimuth, azimuth);
        angles.least_elevation = std::min(angles.least_elevation, elevation);
        angles.greatest_elevation = std::max(angles.greatest_elevation, elevation);
      }
    return angles;
  }

  void add_grid() {
    const auto angles = extent();
    const double span = std::max(std::min(angles.azimuths(), 180.0), angles.elevations());
    constexpr std::array kSteps{0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 15.0, 30.0};  // [deg]
    double step = kSteps.back();
    for (const double candidate : kSteps)
      if (span / candidate <= 8.0) {
        step = candidate;
        break;
      }
    const int decimals = step >= 1.0 ? 0 : step >= 0.1 ? 1 : 2;
    const auto first = [&](double least) { return static_cast<int>(std::ceil(least / step)); };
    const auto last = [&](double greatest) { return static_cast<int>(std::floor(greatest / step)); };
    const double low = std::max(angles.least_elevation - step, -89.0);
    const double high = std::min(angles.greatest_elevation + step, 89.0);
    for (int i = first(angles.least_azimuth); i <= last(angles.greatest_azimuth); ++i) {
      const double azimuth = i * step;
      const auto inside = add_line(OverlayLineKind::grid, kPieces,
                                   [&](double t) { return direction_of(azimuth, low + t * (high - low)); });
      const double named = std::fmod(std::fmod(azimuth, 360.0) + 360.0, 360.0);
      if (inside.empty()) continue;
      const auto highest = *std::ranges::min_element(inside, {}, &glm::dvec2::y);
      shapes_.labels.push_back({highest, OverlayLabelSide::below, fmt::format("{:.{}f}°", named, decimals), true});
    }
    const double from = angles.least_azimuth - step, to = angles.greatest_azimuth + step;
    for (int i = first(angles.least_elevation); i <= last(angles.greatest_elevation); ++i) {
      const double elevation = i * step;
      if (std::abs(elevation) > 89.0) continue;
      const auto inside = add_line(OverlayLineKind::grid, kPieces,
                                   [&](double t) { return direction_of(from + t * (to - from), elevation); });
      if (inside.empty()) continue;
      const auto leftmost = *std::ranges::min_element(inside, {}, &glm::dvec2::x);
      const std::string sign = i > 0 ? "+" : i < 0 ? "\u2212" : "";
      shapes_.labels.push_back(
          {leftmost, OverlayLabelSide::right_of, fmt::format("{}{:.{}f}°", sign, std::abs(elevation), decimals), true});
    }
  }

  void add_horizon() {
    const auto angles = extent();
    const double dip_deg = to_degrees(dip_of_horizon(installation_.site.altitude_m));
    const double from = angles.least_azimuth - 1.0, to = angles.greatest_azimuth + 1.0;
    const auto inside = add_line(OverlayLineKind::horizon, 2 * kPieces,
                                 [&](double t) { return direction_of(from + t * (to - from), -dip_deg); });
    if (inside.empty()) return;
    const auto rightmost = *std::ranges::max_element(inside, {}, &glm::dvec2::x);
    shapes_.labels.push_back(
        {rightmost, OverlayLabelSide::left_of, fmt::format("horizon \u2212{:.2f}°", dip_deg), false});
  }

  void add_object() {
    const auto to_world = model_to_world(installation_.object.placement);
    const glm::dvec3 low(bounds_.lowest), high(bounds_.highest);
    const auto world = [&](const glm::dvec3& model) { return glm::dvec3(to_world * glm::dvec4(model, 1.0)); };
    const auto segment = [&](OverlayLineKind kind, const glm::dvec3& a, const glm::dvec3& b) {
      return add_line(kind, 8, [&](double t) { return world(a + t * (b - a)); });
    };
    const auto corner = [&](int x, int y, int z) {
      return glm::dvec3{x ? high.x : low.x, y ? high.y : low.y, z ? high.z : low.z};
    };
    for (const int x : {0, 1})
      for (const int z : {0, 1}) segment(OverlayLineKind::box, corner(x, 0, z), corner(x, 1, z));
    for (const int y : {1, 0}) {
      const auto kind = y == 0 ? OverlayLineKind::footprint : OverlayLineKind::box;
      // The corners in order, back to the first.
      constexpr std::array<std::array<int, 2>, 5> kAround{{{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}}};
      for (std::size_t i = 0; i < 4; ++i)
        segment(kind, corner(kAround[i][0], y, kAround[i][1]), corner(kAround[i + 1][0], y, kAround[i + 1][1]));
    }

    // The model's own axes; at heading 0 its x points east and its -z north.
    const glm::dvec3 size = high - low;
    const double length = 0.75 * std::max({size.x, size.y, size.z});
    const auto axis = [&](OverlayLineKind kind, const glm::dvec3& towards, const char* name) {
      const auto inside = segment(kind, glm::dvec3{0.0}, length * towards);
      const auto tip = pixel_of(world(length * towards));
      if (!inside.empty() && tip && contains(*tip))
        shapes_.labels.push_back({*tip, OverlayLabelSide::above, name, true});
    };
    axis(OverlayLineKind::axis_x, {1, 0, 0}, "x");
    axis(OverlayLineKind::axis_y, {0, 1, 0}, "y");
    axis(OverlayLineKind::axis_z, {0, 0, 1}, "z");
    add_heading(world, length);

    const glm::dvec3 centre = world(0.5 * (low + high));
    const auto above = pixel_of(world({0.5 * (low.x + high.x), high.y, 0.5 * (low.z + high.z)}));
    if (!above || !contains(*above)) return;
    shapes_.labels.push_back(
        {*above, OverlayLabelSide::above,
         fmt::format("{:.2f} km at {:.2f}°, heading {:.1f}°", glm::length(centre) / 1000.0,
                     to_degrees(azimuth_angle(centre)), to_degrees(installation_.object.placement.heading)),
         false});
  }

  // An arrow on the ground along -z, as long as the axes.
  template <class World>
  void add_heading(World world, double length) {
    const double barb = 0.15 * length;
    const glm::dvec3 tip{0.0, 0.0, -length};
    const std::array<std::array<glm::dvec3, 2>, 3> strokes{
        {{glm::dvec3{0.0}, tip}, {tip, tip + glm::dvec3{-barb, 0.0, barb}}, {tip, tip + glm::dvec3{barb, 0.0, barb}}}};
    for (const auto& stroke : strokes)
      add_line(OverlayLineKind::heading, 8, [&](double t) { return world(glm::mix(stroke[0], stroke[1], t)); });
  }

  void add_landmarks() {
    const double arm = 0.008 * scene_.width;
    for (const auto& landmark : installation_.landmarks) {
      const auto pixel = pixel_of(landmark.place_m);
      if (!pixel || !contains(*pixel)) continue;
      const auto stroke = [&](const glm::dvec2& from, const glm::dvec2& to) {
        shapes_.lines.push_back({OverlayLineKind::landmark, {*pixel + arm * from, *pixel + arm * to}});
      };
      // A cross with an open centre, so that the landmark stays visible.
      for (const glm::dvec2 towards : {glm::dvec2{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) stroke(0.3 * towards, towards);
      shapes_.labels.push_back({*pixel - glm::dvec2{0.0, arm}, OverlayLabelSide::above,
                                fmt::format("{}, {:.1f} km", landmark.name, glm::length(landmark.place_m) / 1000.0),
                                false});
    }
  }

  const Installation& installation_;
  const Camera& scene_;
  const ModelBounds& bounds_;
  OverlayShapes shapes_;
};

}  // namespace

Radians dip_of_horizon(double altitude_m) {
  const double radius = kEarthRadius_m / (1.0 - kUsualRefraction);  // the effective radius with refraction
  return {std::acos(radius / (radius + std::max(altitude_m, 0.0)))};
}

OverlayShapes overlay_shapes(const Installation& installation, const ModelBounds& bounds) {
  return Shapes(installation, bounds).all();
}

}  // namespace kasumi
