#include "gles/picture/picture_cutting.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace kasumi {
namespace {

// Cuts lie at multiples of 4 pixels from the picture's corner: GPUs shade groups of 2 x 2 or 4 x 4 pixels, and a group
// across a border is shaded twice.
constexpr int kGroup = 4;

// Drawing costs relative to a pixel of the camera's picture alone, measured on llvmpipe; only the ratios matter.
constexpr std::array<double, kCutAreas> kPixelCost{1.0, 1.3, 4.0};
constexpr double kDiagonalCost =
    8.0;  // per pixel of a rectangle's width and height, for the diagonal between its two triangles
constexpr double kBorderCost = 5.0;  // per pixel of a side that is not on a multiple of 16 pixels

// From here to cut_picture, rectangles are measured in groups.
int width_of(const PixelBox& r) {
  return r.right - r.left;
}
int height_of(const PixelBox& r) {
  return r.bottom - r.top;
}

double cost(CutArea area, const PixelBox& r) {
  const double w = kGroup * width_of(r), h = kGroup * height_of(r);
  const auto off_line = [](int a, int b) { return (a % 4 != 0 ? 1.0 : 0.0) + (b % 4 != 0 ? 1.0 : 0.0); };
  return w * h * kPixelCost[static_cast<std::size_t>(area)] + kDiagonalCost * (w + h) +
         kBorderCost * (off_line(r.left, r.right) * h + off_line(r.top, r.bottom) * w);
}

// How many groups above and left of a corner meet a condition (a summed-area table).
class Count {
 public:
  template <class Condition>
  Count(const Image<CutArea>& groups, Condition fulfils) : sums_(groups.width() + 1, groups.height() + 1) {
    for (int y = 0; y < groups.height(); ++y)
      for (int x = 0; x < groups.width(); ++x)
        sums_.at(x + 1, y + 1) =
            sums_.at(x, y + 1) + sums_.at(x + 1, y) - sums_.at(x, y) + (fulfils(groups.at(x, y)) ? 1 : 0);
  }
  int in(const PixelBox& r) const {
    return sums_.at(r.right, r.bottom) - sums_.at(r.left, r.bottom) - sums_.at(r.right, r.top) +
           sums_.at(r.left, r.top);
  }

 private:
  Image<int> sums_;
};

struct Piece {
  CutArea area;
  PixelBox box;
};
struct Cutting {
  std::vector<Piece> pieces;
  double cost = 0.0;
};
using Cut = std::array<PixelBox, 2>;

class Cutter {
 public:
  // The first group is (first_x, first_y) of the picture.
  Cutter(const Image<CutArea>& groups, int first_x, int first_y)
      : first_x_(first_x),
        first_y_(first_y),
        plain_(groups, [](CutArea a) { return a == CutArea::plain; }),
        covered_(groups, [](CutArea a) { return a == CutArea::covered; }) {}

  // The cheapest cutting found: the whole rectangle, or the best two parts, cut recursively.
  Cutting cut(const PixelBox& r) const {
    const CutArea area = kind(r);
    Cutting whole{{{area, r}}, cost(area, r)};
    if (area != CutArea::edge) return whole;
    const auto halves = best_cut(r);
    if (!halves) return whole;
    Cutting parts = cut((*halves)[0]);
    const Cutting rest = cut((*halves)[1]);
    parts.cost += rest.cost;
    if (parts.cost >= whole.cost) return whole;
    parts.pieces.insert(parts.pieces.end(), rest.pieces.begin(), rest.pieces.end());
    return parts;
  }

 private:
  CutArea kind(const PixelBox& r) const {
    const int all = width_of(r) * height_of(r);
    const PixelBox own{r.left - first_x_, r.top - first_y_, r.right - first_x_, r.bottom - first_y_};
    if (plain_.in(own) == all) return CutArea::plain;
    return covered_.in(own) == all ? CutArea::covered : CutArea::edge;
  }

  // The longest uniform strip along a side; strip(length) gives the strip and the rest of r.
  template <class Strip>
  std::optional<Cut> longest(const PixelBox& r, int most, Strip strip) const {
    const CutArea area = kind(strip(1)[0]);
    if (area == CutArea::edge) return std::nullopt;
    int fits = 1, fails = most;
    while (fails - fits > 1) {
      const int middle = (fits + fails) / 2;
      (kind(strip(middle)[0]) == area ? fits : fails) = middle;
    }
    const Cut cut = strip(fits);
    if (cost(area, cut[0]) + cost(CutArea::edge, cut[1]) >= cost(CutArea::edge, r)) return std::nullopt;
    return cut;
  }

  // The strip that saves most when cut off, and how much it saves.
  std::optional<Cut> best_strip(const PixelBox& r, double& saved) const {
    const int w = width_of(r), h = height_of(r);
    const std::array<std::optional<Cut>, 4> strips{
        longest(r, w,
                [&](int n) {
                  return Cut{{{r.left, r.top, r.left + n, r.bottom}, {r.left + n, r.top, r.right, r.bottom}}};
                }),
        longest(r, w,
                [&](int n) {
                  return Cut{{{r.right - n, r.top, r.right, r.bottom}, {r.left, r.top, r.right - n, r.bottom}}};
                }),
        longest(r, h,
                [&](int n) {
                  return Cut{{{r.left, r.top, r.right, r.top + n}, {r.left, r.top + n, r.right, r.bottom}}};
                }),
        longest(r, h, [&](int n) {
          return Cut{{{r.left, r.bottom - n, r.right, r.bottom}, {r.left, r.top, r.right, r.bottom - n}}};
        })};
    std::optional<Cut> best;
    saved = 0.0;
    for (const auto& strip : strips) {
      if (!strip) continue;
      const double saves =
          cost(CutArea::edge, r) - cost(kind((*strip)[0]), (*strip)[0]) - cost(CutArea::edge, (*strip)[1]);
      if (saves > saved) saved = saves, best = strip;
    }
    return best;
  }

  double promise(const PixelBox& r) const {
    const CutArea area = kind(r);
    double saved = 0.0;
    if (area == CutArea::edge)
      best_strip(r, saved);
    else
      saved = cost(CutArea::edge, r) - cost(area, r);
    return saved;
  }

  // Cuts off a strip where that saves cost; else makes the cut that allows the largest saving next; else cuts in the
  // middle.
  std::optional<Cut> best_cut(const PixelBox& r) const {
    double saved = 0.0;
    if (auto strip = best_strip(r, saved)) return strip;
    if (std::max(width_of(r), height_of(r)) < 2) return std::nullopt;
    const auto upright = [&](int x) { return Cut{{{r.left, r.top, x, r.bottom}, {x, r.top, r.right, r.bottom}}}; };
    const auto level = [&](int y) { return Cut{{{r.left, r.top, r.right, y}, {r.left, y, r.right, r.bottom}}}; };
    Cut best = width_of(r) > height_of(r) ? upright((r.left + r.right) / 2) : level((r.top + r.bottom) / 2);
    double most = 0.0;
    const auto consider = [&](const Cut& cut) {
      const double promised = promise(cut[0]) + promise(cut[1]);
      if (promised > most) most = promised, best = cut;
    };
    for (int x = r.left + 1; x < r.right; ++x) consider(upright(x));
    for (int y = r.top + 1; y < r.bottom; ++y) consider(level(y));
    return best;
  }

  int first_x_;
  int first_y_;
  Count plain_;
  Count covered_;
};

// The kind of each group of the box; the first begins at or before the box's corner.
Image<CutArea> grouped(const PixelBox& box, const Image<float>& coverage) {
  const int skip_x = box.left % kGroup, skip_y = box.top % kGroup;
  Image<CutArea> groups((skip_x + coverage.width() + kGroup - 1) / kGroup,
                        (skip_y + coverage.height() + kGroup - 1) / kGroup);
  for (int v = 0; v < groups.height(); ++v)
    for (int u = 0; u < groups.width(); ++u) {
      bool any = false, all = true;
      for (int y = std::max(0, v * kGroup - skip_y); y < std::min(coverage.height(), (v + 1) * kGroup - skip_y); ++y)
        for (int x = std::max(0, u * kGroup - skip_x); x < std::min(coverage.width(), (u + 1) * kGroup - skip_x); ++x) {
          any = any || coverage.at(x, y) > 0.0f;
          all = all && coverage.at(x, y) >= 1.0f;
        }
      groups.at(u, v) = all ? CutArea::covered : any ? CutArea::edge : CutArea::plain;
    }
  return groups;
}

// Where lines at first_line + i * spacing divide first .. last, rounded to the nearest group and without slivers.
std::vector<int> ends_at_lines(int first, int last, double first_line, double last_line, int lines) {
  constexpr int kSliver = 2 * kGroup;
  std::vector<int> ends;
  for (int line = 0; line < lines; ++line) {
    const double place = first_line + (last_line - first_line) * line / (lines - 1);
    if (!(place > first && place < last)) continue;
    const int at = static_cast<int>(std::lround(place / kGroup)) * kGroup;
    if (at >= (ends.empty() ? first : ends.back()) + kSliver && at + kSliver <= last) ends.push_back(at);
  }
  ends.push_back(last);
  return ends;
}

}  // namespace

CutRectangles cut_picture(int width, int height, const PixelBox& box, const Image<float>& coverage) {
  CutRectangles rectangles;
  const auto add = [&](CutArea area, const PixelBox& rectangle) {
    if (!rectangle.empty()) rectangles[static_cast<std::size_t>(area)].push_back(rectangle);
  };
  if (box.empty()) {
    add(CutArea::plain, {0, 0, width, height});
    return rectangles;
  }
  add(CutArea::plain, {0, 0, width, box.top});
  add(CutArea::plain, {0, box.top, box.left, box.bottom});
  add(CutArea::plain, {box.right, box.top, width, box.bottom});
  add(CutArea::plain, {0, box.bottom, width, height});

  // Groups are counted from the picture's corner, which is on the 16-pixel lines that the cost assumes.
  const int first_x = box.left / kGroup, first_y = box.top / kGroup;
  const Image<CutArea> groups = grouped(box, coverage);
  const PixelBox all{first_x, first_y, first_x + groups.width(), first_y + groups.height()};
  for (const auto& [area, piece] : Cutter(groups, first_x, first_y).cut(all).pieces) {
    const PixelBox pixels{std::max(box.left, piece.left * kGroup), std::max(box.top, piece.top * kGroup),
                          std::min(box.right, piece.right * kGroup), std::min(box.bottom, piece.bottom * kGroup)};
    add(area, pixels);
  }
  return rectangles;
}

CutRectangles cut_at_lines(const CutRectangles& rectangles, const AirlightGrid& grid) {
  CutRectangles cut;
  for (std::size_t area = 0; area < kCutAreas; ++area)
    for (const PixelBox& whole : rectangles[area]) {
      if (area == static_cast<std::size_t>(CutArea::plain)) {
        cut[area].push_back(whole);
        continue;
      }
      int top = whole.top;
      for (const int bottom :
           ends_at_lines(whole.top, whole.bottom, grid.first_px.y, grid.last_px.y, AirlightGrid::kRows)) {
        int left = whole.left;
        for (const int right :
             ends_at_lines(whole.left, whole.right, grid.first_px.x, grid.last_px.x, AirlightGrid::kColumns)) {
          cut[area].push_back({left, top, right, bottom});
          left = right;
        }
        top = bottom;
      }
    }
  return cut;
}

}  // namespace kasumi
