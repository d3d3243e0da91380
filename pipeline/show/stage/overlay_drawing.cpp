#include "pipeline/show/stage/overlay_drawing.hpp"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "pipeline/show/stage/caption.hpp"

namespace kasumi {

namespace {

// Of lines' dark edges: visible before a bright sky and before a dark hill.
constexpr double kEdgeOpacity = 0.55;
constexpr glm::dvec3 kEdge{8, 10, 14};

struct Pen {
  glm::dvec3 colour;
  double width;  // relative to the usual
};

Pen pen_of(OverlayLineKind kind) {
  switch (kind) {
    case OverlayLineKind::grid: return {{205, 225, 240}, 0.55};
    case OverlayLineKind::horizon: return {{255, 170, 60}, 1.0};
    case OverlayLineKind::box: return {{255, 240, 150}, 0.6};
    case OverlayLineKind::footprint: return {{255, 240, 150}, 1.2};
    case OverlayLineKind::axis_x: return {{255, 90, 80}, 1.0};
    case OverlayLineKind::axis_y: return {{110, 230, 110}, 1.0};
    case OverlayLineKind::axis_z: return {{100, 160, 255}, 1.0};
    case OverlayLineKind::heading: return {{255, 255, 255}, 1.2};
    case OverlayLineKind::landmark: return {{255, 130, 240}, 1.3};
  }
  return {{255, 255, 255}, 1.0};
}

// Alpha blending; both colours are encoded and not premultiplied.
void blend(Rgba8& pixel, const glm::dvec3& colour, double opacity) {
  if (opacity <= 0.0) return;
  const double below = pixel.a / 255.0 * (1.0 - opacity), together = opacity + below;
  const glm::dvec3 mixed = (opacity * colour + below * glm::dvec3(pixel)) / together;
  pixel = Rgba8(glm::round(glm::dvec4(mixed, 255.0 * together)));
}

double distance_to(const glm::dvec2& point, const glm::dvec2& a, const glm::dvec2& b) {
  const glm::dvec2 along = b - a;
  const double square = glm::dot(along, along);
  const double t = square > 0.0 ? std::clamp(glm::dot(point - a, along) / square, 0.0, 1.0) : 0.0;
  return glm::distance(point, a + t * along);
}

struct Rectangle {
  double left, top, right, bottom;
  bool overlaps(const Rectangle& other) const {
    return left < other.right && other.left < right && top < other.bottom && other.top < bottom;
  }
};

// Next to its point and inside the picture.
Rectangle rectangle_of(const OverlayLabel& label, const glm::dvec2& at, const Image<Rgba8>& text, double gap,
                       const Image<Rgba8>& picture) {
  const double w = text.width(), h = text.height();
  glm::dvec2 corner = at - 0.5 * glm::dvec2{w, h};
  if (label.side == OverlayLabelSide::left_of) corner.x = at.x - gap - w;
  if (label.side == OverlayLabelSide::right_of) corner.x = at.x + gap;
  if (label.side == OverlayLabelSide::above) corner.y = at.y - gap - h;
  if (label.side == OverlayLabelSide::below) corner.y = at.y + gap;
  corner = glm::round(
      glm::clamp(corner, glm::dvec2{gap},
                 glm::max(glm::dvec2{gap}, glm::dvec2{picture.width() - w - gap, picture.height() - h - gap})));
  return {corner.x, corner.y, corner.x + w, corner.y + h};
}

void put(Image<Rgba8>& picture, const Image<Rgba8>& text, const Rectangle& place) {
  const int left = static_cast<int>(place.left), top = static_cast<int>(place.top);
  for (int y = 0; y < text.height(); ++y)
    for (int x = 0; x < text.width(); ++x)
      if (picture.contains(left + x, top + y))
        blend(picture.at(left + x, top + y), glm::dvec3(text.at(x, y)), text.at(x, y).a / 255.0);
}

}  // namespace

void draw_line(Image<Rgba8>& picture, const std::vector<glm::dvec2>& points, double width_px,
               const glm::dvec3& colour) {
  // Computes the distance to the whole line first, so that no seams show between segments.
  const double half = 0.5 * width_px, edge = 1.5 * width_px, reach = edge + 0.5;
  glm::dvec2 low{1e18}, high{-1e18};
  for (const auto& point : points) low = glm::min(low, point), high = glm::max(high, point);
  const auto column = [&](double x) { return static_cast<int>(std::clamp(x, 0.0, picture.width() - 1.0)); };
  const auto row = [&](double y) { return static_cast<int>(std::clamp(y, 0.0, picture.height() - 1.0)); };
  const int left = column(low.x - reach), top = row(low.y - reach);
  const int right = column(std::ceil(high.x + reach)), bottom = row(std::ceil(high.y + reach));
  if (points.size() < 2 || right < left || bottom < top) return;

  Image<float> distances(right - left + 1, bottom - top + 1, static_cast<float>(reach));
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const glm::dvec2 a = points[i], b = points[i + 1];
    const glm::dvec2 first = glm::min(a, b) - reach, last = glm::max(a, b) + reach;
    if (last.x < left || first.x > right || last.y < top || first.y > bottom) continue;
    for (int y = row(first.y); y <= row(std::ceil(last.y)); ++y)
      for (int x = column(first.x); x <= column(std::ceil(last.x)); ++x) {
        if (!distances.contains(x - left, y - top)) continue;
        float& distance = distances.at(x - left, y - top);
        distance = std::min(distance, static_cast<float>(distance_to({x, y}, a, b)));
      }
  }
  for (int y = top; y <= bottom; ++y)
    for (int x = left; x <= right; ++x) {
      const double distance = distances.at(x - left, y - top);
      blend(picture.at(x, y), kEdge, kEdgeOpacity * std::clamp(edge + 0.5 - distance, 0.0, 1.0));
      blend(picture.at(x, y), colour, std::clamp(half + 0.5 - distance, 0.0, 1.0) * std::min(1.0, width_px));
    }
}

Result<Image<Rgba8>> draw_shapes(const OverlayShapes& shapes, int width, int height, double scale,
                                 const std::optional<std::filesystem::path>& font_file) {
  Image<Rgba8> picture(width, height);
  const double usual = std::max(1.5, height / 400.0);
  const auto here = [&](const glm::dvec2& pixel) { return (pixel + 0.5) * scale - 0.5; };
  // The grid lies under everything else.
  for (const bool grid : {true, false})
    for (const auto& line : shapes.lines) {
      if ((line.kind == OverlayLineKind::grid) != grid) continue;
      std::vector<glm::dvec2> points;
      for (const auto& point : line.points) points.push_back(here(point));
      const auto pen = pen_of(line.kind);
      draw_line(picture, points, pen.width * usual, pen.colour);
    }

  CaptionStyle style;
  style.font_file = font_file;
  style.height_px = std::max(14.0, height / 38.0);
  style.largest_width_px = std::max(64, width / 2);
  std::vector<Rectangle> taken;
  for (const auto& label : shapes.labels) {
    const auto text = draw_caption(label.text, style);
    if (!text && text.error().kind == FaultKind::unsupported) break;  // no font: draw the lines only
    if (!text) return fail(text.error());
    auto place = rectangle_of(label, here(label.at), *text, 2.0 * usual, picture);
    const auto is_free = [&] {
      return std::ranges::none_of(taken, [&](const Rectangle& other) { return place.overlaps(other); });
    };
    // A required label moves up until there is room.
    const double step = text->height() + usual;
    while (!label.may_be_left_out && !is_free() && place.top > step) place.top -= step, place.bottom -= step;
    if (label.may_be_left_out && !is_free()) continue;
    taken.push_back(place);
    put(picture, *text, place);
  }
  return picture;
}

}  // namespace kasumi
