#include "pipeline/lab/archive/svg_shapes.hpp"

#include <cmath>

namespace kasumi {

double round_step(double range) {
  const double raw = range / 5.0, power = std::pow(10.0, std::floor(std::log10(raw)));
  for (const double each : {1.0, 2.0, 2.5, 5.0})
    if (each * power >= raw) return each * power;
  return 10.0 * power;
}

void open_svg(PageText& svg, double width, double height, std::string_view title) {
  svg.add(
      "<svg viewBox=\"0 0 {:g} {:g}\" role=\"img\" aria-label=\"{}\" font-family=\"system-ui, DejaVu Sans, "
      "sans-serif\" "
      "font-size=\"12\">\n",
      width, height, html_escaped(title));
}
void add_text(PageText& svg, double x, double y, std::string_view anchor, std::string_view words,
              std::string_view ink) {
  svg.add("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\" fill=\"{}\">{}</text>\n", x, y, anchor, ink,
          html_escaped(words));
}
void add_rule(PageText& svg, double x0, double y0, double x1, double y1, std::string_view ink) {
  svg.add("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"{}\"/>\n", x0, y0, x1, y1, ink);
}
void add_square(PageText& svg, double x, double y, double width, double height, std::string_view colour,
                const std::string& says) {
  svg.add("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"{}\"><title>{}</title></rect>\n",
          x, y, width, height, colour, html_escaped(says));
}

}  // namespace kasumi
