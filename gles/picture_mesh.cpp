#include "gles/picture_mesh.hpp"

#include <algorithm>
#include <map>

#include <glm/vec2.hpp>

#include "gles/gl.hpp"
#include "gles/program.hpp"

namespace kasumi {
namespace {

constexpr int kTile = 16;

PictureArea area_of(const Image<float>& coverage, int left, int top, int right, int bottom) {
  // Halves and bytes cannot tell a hair from nothing at all: 1 is stored exactly, 0 too.
  constexpr float kFull = 0.9995f;
  bool any = false, all = true;
  for (int y = top; y < bottom; ++y)
    for (int x = left; x < right; ++x) {
      any = any || coverage.at(x, y) > 0.0f;
      all = all && coverage.at(x, y) >= kFull;
    }
  return all ? PictureArea::covered : any ? PictureArea::edge : PictureArea::plain;
}

struct Run {
  PictureArea area;
  PixelBox box;
};

bool grows(const Run& run, PictureArea area, int size, int largest) {
  return run.area == area && (area == PictureArea::plain || size <= largest);
}

}  // namespace

PictureRectangles cut_picture(int width, int height, const PixelBox& box, const Image<float>& coverage) {
  PictureRectangles rectangles;
  const auto add = [&](PictureArea area, const PixelBox& rectangle) {
    if (!rectangle.empty()) rectangles[static_cast<std::size_t>(area)].push_back(rectangle);
  };
  if (box.empty()) {
    add(PictureArea::plain, {0, 0, width, height});
    return rectangles;
  }
  add(PictureArea::plain, {0, 0, width, box.top});
  add(PictureArea::plain, {0, box.top, box.left, box.bottom});
  add(PictureArea::plain, {box.right, box.top, width, box.bottom});
  add(PictureArea::plain, {0, box.bottom, width, height});

  const int largest =
      std::max(kTile, std::max(box.right - box.left, box.bottom - box.top) / (2 * (AirlightGrid::kColumns - 1)));
  std::vector<Run> open;  // of the rows above, still growing downwards
  for (int top = box.top; top < box.bottom; top += kTile) {
    const int bottom = std::min(top + kTile, box.bottom);
    std::vector<Run> row;
    for (int left = box.left; left < box.right; left += kTile) {
      const int right = std::min(left + kTile, box.right);
      const PictureArea area = area_of(coverage, left - box.left, top - box.top, right - box.left, bottom - box.top);
      if (!row.empty() && grows(row.back(), area, right - row.back().box.left, largest))
        row.back().box.right = right;
      else
        row.push_back({area, {left, top, right, bottom}});
    }
    for (Run& run : row) {
      const auto above = std::ranges::find_if(open, [&](const Run& o) {
        return o.box.left == run.box.left && o.box.right == run.box.right && o.box.bottom == top &&
               grows(o, run.area, bottom - o.box.top, largest);
      });
      if (above == open.end()) continue;
      run.box.top = above->box.top;
      open.erase(above);
    }
    for (const Run& finished : open) add(finished.area, finished.box);
    open = std::move(row);
  }
  for (const Run& finished : open) add(finished.area, finished.box);
  return rectangles;
}

PictureMesh PictureMesh::upload(const PictureRectangles& rectangles) {
  PictureMesh mesh;
  std::vector<glm::vec2> corners;
  for (std::size_t area = 0; area < kPictureAreas; ++area) {
    for (const PixelBox& box : rectangles[area]) {
      const glm::vec2 a(box.left, box.top), b(box.right, box.top), c(box.left, box.bottom), d(box.right, box.bottom);
      corners.insert(corners.end(), {a, b, c, c, b, d});
    }
    mesh.first_[area + 1] = static_cast<int>(corners.size());
  }
  mesh.corners_ = make_buffer();
  glBindBuffer(GL_ARRAY_BUFFER, mesh.corners_.name());
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(corners.size() * sizeof(glm::vec2)), corners.data(),
               GL_STATIC_DRAW);
  return mesh;
}

bool PictureMesh::empty(PictureArea area) const {
  const auto at = static_cast<std::size_t>(area);
  return first_[at] == first_[at + 1];
}

void PictureMesh::draw(PictureArea area) const {
  if (empty(area)) return;
  const auto at = static_cast<std::size_t>(area);
  glBindBuffer(GL_ARRAY_BUFFER, corners_.name());
  glEnableVertexAttribArray(kPosition);
  glVertexAttribPointer(kPosition, 2, GL_FLOAT, GL_FALSE, sizeof(glm::vec2), nullptr);
  glDrawArrays(GL_TRIANGLES, first_[at], first_[at + 1] - first_[at]);
  glDisableVertexAttribArray(kPosition);
}

}  // namespace kasumi
