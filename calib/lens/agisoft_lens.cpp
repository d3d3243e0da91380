// Metashape's and PhotoScan's camera calibration (its manual, appendix D): f, cx, cy from the picture's middle, b1, b2,
// k1 to k4, p1 to p4.
#include <cmath>
#include <map>
#include <set>

#include "base/finite_number.hpp"
#include "calib/lens/foreign_formats.hpp"

namespace kasumi {
namespace {

// <name>value</name>, of the first <calibration>.
std::map<std::string, std::string> agisoft_elements(const std::string& text) {
  std::map<std::string, std::string> elements;
  const auto begin = text.find("<calibration>"), end = text.find("</calibration>");
  if (begin == std::string::npos || end == std::string::npos || end < begin) return elements;
  for (std::size_t at = begin + 13; at < end;) {
    const auto open = text.find('<', at), close = text.find('>', open);
    if (open >= end || close == std::string::npos || close >= end) break;
    const auto name = text.substr(open + 1, close - open - 1);
    const auto last = text.find("</" + name + ">", close);
    if (last == std::string::npos || last > end) {
      at = close + 1;
      continue;
    }
    elements[name] = text.substr(close + 1, last - close - 1);
    at = last + name.size() + 3;
  }
  return elements;
}

enum class AgisoftKind { frame, equidistant, equisolid };

}  // namespace

bool is_agisoft(const std::string& text) {
  return text.find("<calibration>") != std::string::npos && text.find("<projection>") != std::string::npos;
}

Result<ForeignLens> read_agisoft_lens(const std::string& text) {
  const auto elements = agisoft_elements(text);
  static const std::set<std::string> kRead{"projection", "width", "height", "f",  "cx", "cy", "b1", "b2",
                                           "k1",         "k2",    "k3",     "k4", "p1", "p2", "p3", "p4"};
  Problems problems;
  const auto number = [&](const char* name) {
    const auto found = elements.find(name);
    if (found == elements.end()) return 0.0;
    const auto value = finite_number(found->second);
    if (!value) problems.add("<{}>{}: expected a number", name, found->second);
    return value.value_or(0.0);
  };
  for (const auto& [name, value] : elements)
    if (!kRead.contains(name) && finite_number(value) && *finite_number(value) != 0.0)
      problems.add("<{}>{}: a number whose meaning is not known here", name, value);
  const auto projection = elements.count("projection") ? elements.at("projection") : "";
  AgisoftKind kind = AgisoftKind::frame;
  if (projection == "fisheye" || projection == "equidistant_fisheye")
    kind = AgisoftKind::equidistant;
  else if (projection == "equisolid_fisheye")
    kind = AgisoftKind::equisolid;
  else if (projection != "frame")
    problems.add("<projection>{}: expected frame, fisheye, equidistant_fisheye or equisolid_fisheye", projection);
  const double width = number("width"), height = number("height"), f = number("f"), cx = number("cx"),
               cy = number("cy"), b1 = number("b1"), b2 = number("b2");
  const double k1 = number("k1"), k2 = number("k2"), k3 = number("k3"), k4 = number("k4"), p1 = number("p1"),
               p2 = number("p2"), p3 = number("p3"), p4 = number("p4");
  if (!(width >= 1.0 && height >= 1.0 && width <= 1e5 && height <= 1e5 && f >= 1.0 && f + b1 >= 1.0))
    problems.add("<width>, <height>, <f>: expected numbers >= 1");
  if (!problems.empty()) return fail(problems.fault());
  ForeignLens lens{"Agisoft", projection, static_cast<int>(width),    static_cast<int>(height),
                   {},        {},         kind != AgisoftKind::frame, {}};
  lens.project = [=](const glm::dvec3& ray) -> std::optional<glm::dvec2> {
    const double off = std::hypot(ray.x, ray.y), theta = std::atan2(off, ray.z);
    if (kind == AgisoftKind::frame && !(ray.z > 1e-9)) return std::nullopt;
    const double radius = kind == AgisoftKind::frame         ? off / ray.z
                          : kind == AgisoftKind::equidistant ? theta
                                                             : 2.0 * std::sin(0.5 * theta);
    const double x = off > 0.0 ? radius * ray.x / off : 0.0, y = off > 0.0 ? radius * ray.y / off : 0.0;
    const double r2 = x * x + y * y, radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * (k3 + r2 * k4))),
                 more = 1.0 + r2 * (p3 + r2 * p4);
    const double bent_x = x * radial + (p1 * (r2 + 2.0 * x * x) + 2.0 * p2 * x * y) * more,
                 bent_y = y * radial + (p2 * (r2 + 2.0 * y * y) + 2.0 * p1 * x * y) * more;
    return glm::dvec2{0.5 * width - 0.5 + cx + bent_x * (f + b1) + bent_y * b2, 0.5 * height - 0.5 + cy + bent_y * f};
  };
  // Its p1 goes along x: OpenCV's p2.
  const bool held = b2 == 0.0 && k4 == 0.0 && p3 == 0.0 && p4 == 0.0;
  if (kind == AgisoftKind::frame && held)
    lens.exact = LensDescription{
        PinholeParameters{{f + b1, f}, {0.5 * width - 0.5 + cx, 0.5 * height - 0.5 + cy}, {k1, k2, p2, p1, k3}}};
  return lens;
}

}  // namespace kasumi
