// Hugin's projects: an "i" line for each picture, with w, h, f (projection), v (horizontal field of view), a b c d e
// (panotools' lens correction: r_picture = (a r^3 + b r^2 + c r + 1 - a - b - c) r, r 1 at half the shorter side).
#include <cctype>
#include <cmath>
#include <map>
#include <sstream>

#include "base/finite_number.hpp"
#include "calib/lens/foreign_formats.hpp"

namespace kasumi {
namespace {

// "i w4000 h3000 f3 v180 ... n"name"": letters, then the value; =0 is "as picture 0's".
std::map<std::string, std::string> hugin_values(const std::string& line) {
  std::map<std::string, std::string> values;
  std::istringstream words(line.substr(0, line.find(" n\"")));
  std::string word;
  words >> word;
  while (words >> word) {
    std::size_t letters = 0;
    while (letters < word.size() && std::isalpha(static_cast<unsigned char>(word[letters]))) ++letters;
    values.emplace(word.substr(0, letters), word.substr(letters));
  }
  return values;
}

std::optional<std::string> first_picture(const std::string& text, bool& has_panorama) {
  std::istringstream lines(text);
  std::optional<std::string> found;
  for (std::string line; std::getline(lines, line);) {
    has_panorama = has_panorama || line.starts_with("p ");
    if (!found && line.starts_with("i ")) found = line;
  }
  return found;
}

// Radius in focal lengths at an angle; empty: beyond it.
std::optional<double> hugin_radius(int projection, double angle) {
  switch (projection) {
    case 0: return angle < 0.4999 * kPi ? std::optional(std::tan(angle)) : std::nullopt;
    case 2:
    case 3: return angle;
    case 8: return angle <= 0.5 * kPi ? std::optional(std::sin(angle)) : std::nullopt;
    case 10: return angle < 0.999 * kPi ? std::optional(2.0 * std::tan(0.5 * angle)) : std::nullopt;
    default: return 2.0 * std::sin(0.5 * angle);
  }
}

}  // namespace

bool is_hugin(const std::string& text) {
  bool has_panorama = false;
  return first_picture(text, has_panorama) && has_panorama;
}

Result<ForeignLens> read_hugin_lens(const std::string& text) {
  bool has_panorama = false;
  const auto values = hugin_values(first_picture(text, has_panorama).value_or("i"));
  Problems problems;
  const auto number = [&](const char* name) {
    const auto found = values.find(name);
    if (found == values.end()) return 0.0;
    const auto value = finite_number(found->second);
    if (!value) problems.add("{}{}: expected a number", name, found->second);
    return value.value_or(0.0);
  };
  static const std::map<int, const char*> kProjections{{0, "rectilinear"},        {2, "circular fisheye"},
                                                       {3, "full-frame fisheye"}, {8, "orthographic"},
                                                       {10, "stereographic"},     {21, "equisolid"}};
  const double width = number("w"), height = number("h"), view_deg = number("v"), a = number("a"), b = number("b"),
               c = number("c"), d = number("d"), e = number("e"), g = number("g"), t = number("t");
  const double f = number("f");
  const int projection = f >= 0.0 && f < 100.0 ? static_cast<int>(f) : -1;
  if (!kProjections.contains(projection))
    problems.add(
        "f{}: expected 0 (rectilinear), 2, 3 (fisheye), 8 (orthographic), 10 (stereographic) or 21 (equisolid)",
        projection);
  if (!(width >= 1.0 && height >= 1.0 && width <= 1e5 && height <= 1e5))
    problems.add("w, h: expected the picture's size");
  if (g != 0.0 || t != 0.0)
    problems.add("g{} t{}: expected 0: a sheared picture, as from a scanner, is not held", g, t);
  const auto half = hugin_radius(projection, 0.5 * view_deg * kPi / 180.0);
  if (!(view_deg > 0.0 && view_deg <= 360.0) || !half || !(*half > 0.0))
    problems.add("v{}: expected the horizontal field of view in degrees", view_deg);
  if (!problems.empty()) return fail(problems.fault());
  ForeignLens lens{
      "Hugin", kProjections.at(projection), static_cast<int>(width), static_cast<int>(height), {}, {}, projection != 0,
      {}};
  const double focal_px = 0.5 * width / *half, unit_px = 0.5 * std::min(width, height);
  lens.project = [=](const glm::dvec3& ray) -> std::optional<glm::dvec2> {
    const double off = std::hypot(ray.x, ray.y);
    const auto ideal = hugin_radius(projection, std::atan2(off, ray.z));
    if (!ideal) return std::nullopt;
    const double r = *ideal * focal_px / unit_px, scale = r * (r * (a * r + b) + c) + 1.0 - a - b - c;
    const double slope = r * (r * (4.0 * a * r + 3.0 * b) + 2.0 * c) + 1.0 - a - b - c;
    if (!(slope > 0.0)) return std::nullopt;
    const glm::dvec2 centre{0.5 * width - 0.5 + d, 0.5 * height - 0.5 + e};
    return off > 0.0 ? centre + glm::dvec2(ray.x, ray.y) * (r * scale * unit_px / off) : centre;
  };
  return lens;
}

}  // namespace kasumi
