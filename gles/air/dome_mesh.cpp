#include "gles/air/dome_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include <glm/common.hpp>

namespace kasumi {
namespace {

constexpr int kFirstParts = 8;       // before any is halved
constexpr double kClosest_px = 0.5;  // lines are never closer than this; the horizon and the aureole need it
constexpr double kProbeSpacing_px = 60.0;

using Look = std::function<glm::dvec3(double along, double across)>;

// The largest error of linear interpolation between the ends, sampled at the middle and the quarters.
double straight_error(const Look& look, const std::vector<double>& across, double from, double to) {
  double worst = 0.0;
  for (const double line : across) {
    const glm::dvec3 first = look(from, line), last = look(to, line);
    for (const double part : {0.25, 0.5, 0.75}) {
      const glm::dvec3 off = glm::abs(look(std::lerp(from, to, part), line) - glm::mix(first, last, part));
      worst = std::max({worst, off.x, off.y, off.z});
    }
  }
  return worst;
}

void halve(const Look& look, const std::vector<double>& across, double from, double to, double tolerance,
           std::vector<double>& lines) {
  if (to - from > 2.0 * kClosest_px && straight_error(look, across, from, to) > tolerance) {
    const double middle = 0.5 * (from + to);
    halve(look, across, from, middle, tolerance, lines);
    halve(look, across, middle, to, tolerance, lines);
  } else {
    lines.push_back(to);
  }
}

std::vector<double> lines_of(const Look& look, double size, const std::vector<double>& across, double tolerance) {
  std::vector<double> lines{-0.5 * size};
  for (int i = 0; i < kFirstParts; ++i)
    halve(look, across, size * (static_cast<double>(i) / kFirstParts - 0.5),
          size * (static_cast<double>(i + 1) / kFirstParts - 0.5), tolerance, lines);
  return lines;
}

// Evenly spaced, plus one through the sun.
std::vector<double> probe_places(double size, std::optional<double> sun) {
  const int count = std::max(8, static_cast<int>(size / kProbeSpacing_px));
  std::vector<double> places;
  for (int i = 0; i <= count; ++i) places.push_back(size * (static_cast<double>(i) / count - 0.5));
  if (sun && std::abs(*sun) < 0.5 * size) places.push_back(*sun);
  return places;
}

}  // namespace

DomeMesh make_dome_mesh(const PanoramaView& view, const DomePainter& painter, const Direction& sun, double tolerance) {
  const glm::dvec2 middle = 0.5 * glm::dvec2(view.width, view.height) - 0.5;
  const auto shown_at = [&](double x, double y) {
    const Direction there = direction_of(view, middle + glm::dvec2(x, y));
    return painter.shown(painter.sky(there), there);
  };
  const auto sun_pixel = pixel_of(view, sun);
  std::optional<double> sun_x, sun_y;
  if (sun_pixel) {
    sun_x = sun_pixel->x - middle.x;
    sun_y = sun_pixel->y - middle.y;
  }
  DomeMesh mesh;
  mesh.columns = lines_of([&](double along, double across) { return shown_at(along, across); }, view.width,
                          probe_places(view.height, sun_y), tolerance);
  mesh.rows = lines_of([&](double along, double across) { return shown_at(across, along); }, view.height,
                       probe_places(view.width, sun_x), tolerance);
  return mesh;
}

}  // namespace kasumi
