// Curves as SVG, for a self-contained page.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <glm/vec2.hpp>

namespace kasumi::paper {

struct Series {
  std::string name;
  std::vector<glm::dvec2> points{};
  bool line = true, marks = false, dashed = false;
};
struct Band {  // between two heights, labelled at the right edge
  std::string name;
  double from = 0.0, to = 0.0;
};
struct Plot {
  std::string title, across, up;  // axis labels, with units
  std::vector<Series> series{};
  std::vector<Band> bands{};
  bool log_across = false, log_up = false;
  // When omitted: from the points. A logarithmic axis shows only positive values.
  std::optional<glm::dvec2> range_across{}, range_up{};
};

// Every point inside the ranges is drawn; curves are clipped at the frame.
std::string svg_of(const Plot& plot);

}  // namespace kasumi::paper
