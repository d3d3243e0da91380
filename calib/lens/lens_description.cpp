#include "calib/lens/lens_description.hpp"

#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/table/toml_text.hpp"

namespace kasumi {
namespace {

template <class... Functions>
struct Overloaded : Functions... {
  using Functions::operator()...;
};
template <class... Functions>
Overloaded(Functions...) -> Overloaded<Functions...>;

template <class Numbers>
std::string list(const Numbers& numbers) {
  std::vector<std::string> texts;
  for (const double value : numbers) texts.push_back(toml_number(value));
  return fmt::format("[{}]", fmt::join(texts, ", "));
}

std::string pair(const glm::dvec2& v) {
  return list(std::array{v.x, v.y});
}

}  // namespace

LensPtr make_lens(const LensDescription& description) {
  const Radians largest = description.largest_angle;
  const LensPtr lens = std::visit(Overloaded{[&](const IdealFisheyeParameters& m) {
                                               return m.equisolid ? equisolid_lens(m.centre, m.focal_px, largest)
                                                                  : equidistant_lens(m.centre, m.focal_px, largest);
                                             },
                                             [&](const OpencvFisheyeParameters& m) {
                                               return opencv_fisheye_lens(m.focal_px, m.centre, m.k, largest);
                                             },
                                             [&](const ScaramuzzaParameters& m) { return scaramuzza_lens(m, largest); },
                                             [&](const PinholeParameters& m) { return pinhole_lens(m); }},
                                  description.model);
  return description.mirrored ? mirrored_lens(lens) : lens;
}

std::string_view model_name(const LensDescription& description) {
  using namespace std::string_view_literals;
  return std::visit(
      Overloaded{[](const IdealFisheyeParameters& m) { return m.equisolid ? "equisolid"sv : "equidistant"sv; },
                 [](const OpencvFisheyeParameters&) { return "opencv_fisheye"sv; },
                 [](const ScaramuzzaParameters&) { return "scaramuzza"sv; },
                 [](const PinholeParameters&) { return "pinhole"sv; }},
      description.model);
}

glm::dvec2 centre_of(const LensDescription& description) {
  return std::visit([](const auto& m) { return m.centre; }, description.model);
}

double focal_px_of(const LensDescription& description) {
  const auto mean = [](const glm::dvec2& focal) { return 0.5 * (focal.x + focal.y); };
  return std::visit(Overloaded{[](const IdealFisheyeParameters& m) { return m.focal_px; },
                               [&](const OpencvFisheyeParameters& m) { return mean(m.focal_px); },
                               [](const ScaramuzzaParameters& m) { return -m.polynomial.front() * 0.5 * (1.0 + m.c); },
                               [&](const PinholeParameters& m) { return mean(m.focal_px); }},
                    description.model);
}

LensDescription moved(LensDescription description, const glm::dvec2& centre, double scale) {
  std::visit(Overloaded{[&](IdealFisheyeParameters& m) { m.focal_px *= scale; },
                        [&](OpencvFisheyeParameters& m) { m.focal_px *= scale; },
                        [&](ScaramuzzaParameters& m) {
                          for (std::size_t i = 0; i < m.polynomial.size(); ++i)
                            m.polynomial[i] *= std::pow(scale, 1.0 - static_cast<double>(i));
                        },
                        [&](PinholeParameters& m) { m.focal_px *= scale; }},
             description.model);
  std::visit([&](auto& m) { m.centre = centre; }, description.model);
  return description;
}

std::string toml_of(const LensDescription& description) {
  auto text = fmt::format("model = \"{}\"\n", model_name(description));
  text += std::visit(
      Overloaded{
          [](const IdealFisheyeParameters& m) { return fmt::format("focal_px = {}\n", toml_number(m.focal_px)); },
          [](const OpencvFisheyeParameters& m) {
            return fmt::format("focal_px = {}\nk = {}\n", pair(m.focal_px), list(m.k));
          },
          [](const ScaramuzzaParameters& m) {
            // The focal length is the polynomial's: for people and other programs' scripts.
            return fmt::format("focal_px = {}\npolynomial = {}\naffine = {}\n",
                               pair(-m.polynomial.front() * glm::dvec2{1.0, m.c}), list(m.polynomial),
                               list(std::array{m.c, m.d, m.e}));
          },
          [](const PinholeParameters& m) {
            return fmt::format("focal_px = {}\ndistortion = {}\n", pair(m.focal_px), list(m.distortion));
          }},
      description.model);
  text += fmt::format("centre_px = {}\n", pair(centre_of(description)));
  if (!std::holds_alternative<PinholeParameters>(description.model))
    text += fmt::format("largest_angle_deg = {}\n", toml_number(to_degrees(description.largest_angle)));
  if (description.mirrored) text += "mirrored = true\n";
  return text;
}

}  // namespace kasumi
