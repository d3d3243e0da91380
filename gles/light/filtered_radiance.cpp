#include "gles/light/filtered_radiance.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "gles/light/reflection_table.hpp"

namespace kasumi {
namespace {

// On an octahedral map of any `size`.
glm::vec3 look_up(const Image<glm::vec3>& map, const glm::dvec2& place) {
  const double last = map.width() - 1.0;
  const glm::dvec2 at = 0.5 * (place + 1.0) * last;
  const int x = std::min(static_cast<int>(at.x), map.width() - 2),
            y = std::min(static_cast<int>(at.y), map.width() - 2);
  const auto u = static_cast<float>(at.x - x), v = static_cast<float>(at.y - y);
  return glm::mix(glm::mix(map.at(x, y), map.at(x + 1, y), u), glm::mix(map.at(x, y + 1), map.at(x + 1, y + 1), u), v);
}

glm::dvec2 place_of(int x, int y, int size) {
  return 2.0 * glm::dvec2{x, y} / (size - 1.0) - 1.0;
}

// Smooth results are filtered at half the size.
constexpr int kCoarse = (FilteredRadiance::kSize + 1) / 2;
Image<glm::vec3> in_full_size(const Image<glm::vec3>& map) {
  Image<glm::vec3> made(FilteredRadiance::kSize, FilteredRadiance::kSize);
  for (int y = 0; y < made.height(); ++y)
    for (int x = 0; x < made.width(); ++x) made.at(x, y) = look_up(map, place_of(x, y, FilteredRadiance::kSize));
  return made;
}

// Directions around the mirror direction, which is z, and their weights.
struct Lobe {
  std::vector<glm::dvec3> directions;
  std::vector<float> weights;
};

Lobe lobe_of(double roughness) {
  constexpr int kTilts = 16, kTurns = 8;
  Lobe lobe;
  double sum = 0.0;
  for (int i = 0; i < kTilts; ++i) {
    const double nh = facet_cosine((i + 0.5) / kTilts, roughness * roughness);
    const double cosine = 2.0 * nh * nh - 1.0, sine = 2.0 * nh * std::sqrt(1.0 - nh * nh);
    if (cosine <= 0.0) continue;
    for (int j = 0; j < kTurns; ++j) {
      const double turn = 2.0 * kPi * (j + 0.5 * (i % 2)) / kTurns;
      lobe.directions.push_back({sine * std::cos(turn), sine * std::sin(turn), cosine});
      lobe.weights.push_back(static_cast<float>(cosine));
      sum += cosine;
    }
  }
  for (float& weight : lobe.weights) weight /= static_cast<float>(sum);
  return lobe;
}

// The filter of one roughness: each output texel as a weighted sum of the map's texels. The lobes never change, so the
// weights are computed once, for one quarter of the map: the others are its mirror images.
class Mirror {
 public:
  Mirror(double roughness, int size) : size_(size) {
    const Lobe lobe = lobe_of(roughness);
    std::vector<float> share(kMap * kMap, 0.0f);
    std::vector<std::size_t> touched;
    for (int y = 0; y < half(); ++y)
      for (int x = 0; x < half(); ++x) {
        lay(lobe, direction_on_map(place_of(x, y, size)), share, touched);
        float largest = 0.0f;
        for (const std::size_t at : touched) largest = std::max(largest, share[at]);
        const float unit = largest / kWhole;
        for (const std::size_t at : touched) {
          taps_.push_back({static_cast<std::uint8_t>(at % kMap), static_cast<std::uint8_t>(at / kMap),
                           static_cast<std::uint16_t>(std::lround(share[at] / unit))});
          share[at] = 0.0f;
        }
        touched.clear();
        texels_.push_back({taps_.size(), unit});
      }
    taps_.shrink_to_fit();
  }

  Image<glm::vec3> of(const Image<glm::vec3>& radiance) const {
    Image<glm::vec3> picture(size_, size_);
    std::size_t tap = 0;
    for (std::size_t i = 0; i < texels_.size(); ++i) {
      const auto [end, unit] = texels_[i];
      std::array<glm::vec3, 4> sums{};  // here, across, below, both
      for (; tap < end; ++tap) {
        const auto [x, y, of_unit] = taps_[tap];
        const float share = unit * of_unit;
        const glm::vec3 *row = radiance.row(y), *mirrored = radiance.row(kMap - 1 - y);
        sums[0] += share * row[x];
        sums[1] += share * row[kMap - 1 - x];
        sums[2] += share * mirrored[x];
        sums[3] += share * mirrored[kMap - 1 - x];
      }
      const int x = static_cast<int>(i) % half(), y = static_cast<int>(i) / half(), last = size_ - 1;
      picture.at(last - x, last - y) = sums[3];
      picture.at(x, last - y) = sums[2];
      picture.at(last - x, y) = sums[1];
      picture.at(x, y) = sums[0];
    }
    return picture;
  }

 private:
  static constexpr int kMap = LightAround::kSize;
  static_assert(kMap <= 256);
  struct Tap {
    std::uint8_t x, y;      // texel of the map
    std::uint16_t of_unit;  // its share
  };
  static_assert(sizeof(Tap) == 4, "half a million are kept for good");
  struct Filtered {
    std::size_t end;  // of its taps
    float unit;       // of their shares: the largest is kWhole
  };
  static constexpr float kWhole = 65535.0f;
  int half() const { return (size_ + 1) / 2; }

  // The lobe around `image`, interpolated between the map's texels.
  static void lay(const Lobe& lobe, const Direction& image, std::vector<float>& share,
                  std::vector<std::size_t>& touched) {
    const glm::dvec3 aside = std::abs(image.z) < 0.9 ? glm::dvec3{0, 0, 1} : glm::dvec3{1, 0, 0};
    const glm::dvec3 x = glm::normalize(glm::cross(aside, image)), y = glm::cross(image, x);
    for (std::size_t i = 0; i < lobe.directions.size(); ++i) {
      const glm::dvec3& d = lobe.directions[i];
      const glm::dvec2 at = 0.5 * (place_on_map(d.x * x + d.y * y + d.z * image) + 1.0) * (kMap - 1.0);
      const int left = std::min(static_cast<int>(at.x), kMap - 2), top = std::min(static_cast<int>(at.y), kMap - 2);
      const double u = at.x - left, v = at.y - top;
      const auto add = [&](int column, int row, double part) {
        const auto texel = static_cast<std::size_t>(row * kMap + column);
        if (!(part > 0.0)) return;
        if (share[texel] == 0.0f) touched.push_back(texel);
        share[texel] += lobe.weights[i] * static_cast<float>(part);
      };
      add(left, top, (1.0 - u) * (1.0 - v));
      add(left + 1, top, u * (1.0 - v));
      add(left, top + 1, (1.0 - u) * v);
      add(left + 1, top + 1, u * v);
    }
  }

  int size_;
  std::vector<Tap> taps_;
  std::vector<Filtered> texels_;
};

// Of roughness 1/6 .. 5/6; 2 MB.
const std::vector<Mirror>& mirrors() {
  static const auto made = [] {
    std::vector<Mirror> all;
    for (int level = 1; level < FilteredRadiance::kMirrors; ++level)
      all.emplace_back(static_cast<double>(level) / FilteredRadiance::kMirrors,
                       level == 1 ? FilteredRadiance::kSize : kCoarse);
    return all;
  }();
  return made;
}

// Irradiance / pi for 32 normals at a time: a loop short enough to be unrolled is not vectorised for NEON.
Image<glm::vec3> matt_of(const LightAround& around) {
  constexpr int kLanes = 32, kSize = FilteredRadiance::kSize;
  using Lanes = std::array<float, kLanes>;
  struct Source {
    float x, y, z, weight, r, g, b;
  };
  std::vector<Source> sources;
  const glm::vec3* light = around.radiance.elements().data();
  for (const MapTexel& texel : map_texels()) {
    const glm::vec3 direction(texel.direction), power = static_cast<float>(texel.solid_angle) * *light++;
    sources.push_back(
        {direction.x, direction.y, direction.z, static_cast<float>(texel.solid_angle), power.r, power.g, power.b});
  }
  Image<glm::vec3> map(kSize, kSize);
  for (int first = 0; first < kSize * kSize; first += kLanes) {
    Lanes x{}, y{}, z{}, weight{}, r{}, g{}, b{};
    for (int lane = 0; lane < kLanes; ++lane) {
      const int at = std::min(first + lane, kSize * kSize - 1);
      const auto i = static_cast<std::size_t>(lane);
      const glm::vec3 normal(direction_on_map(place_of(at % kSize, at / kSize, kSize)));
      x[i] = normal.x, y[i] = normal.y, z[i] = normal.z;
    }
    for (const Source& s : sources)
      for (std::size_t i = 0; i < kLanes; ++i) {
        const float product = x[i] * s.x + y[i] * s.y + z[i] * s.z, cosine = product > 0.0f ? product : 0.0f;
        weight[i] += cosine * s.weight;
        r[i] += cosine * s.r;
        g[i] += cosine * s.g;
        b[i] += cosine * s.b;
      }
    for (int lane = 0; lane < kLanes && first + lane < kSize * kSize; ++lane) {
      const auto i = static_cast<std::size_t>(lane);
      map.elements()[static_cast<std::size_t>(first + lane)] = glm::vec3{r[i], g[i], b[i]} / weight[i];
    }
  }
  return map;
}

}  // namespace

void prepare_filters() {
  (void)mirrors();
}

FilteredRadiance filter_sky(const LightAround& around, bool with_mirrors) {
  FilteredRadiance sky;
  sky.matt = matt_of(around);
  if (!with_mirrors) return sky;
  sky.mirrors[0] = in_full_size(around.radiance);
  for (std::size_t level = 1; level < sky.mirrors.size(); ++level) {
    auto picture = mirrors()[level - 1].of(around.radiance);
    sky.mirrors[level] = picture.width() == FilteredRadiance::kSize ? std::move(picture) : in_full_size(picture);
  }
  return sky;
}

glm::u8vec4 in_bytes(const glm::vec3& light, float unit) {
  const glm::vec3 root = glm::sqrt(glm::clamp(light / unit, 0.0f, 1.0f));
  const float shared = std::ceil(255.0f * std::max({root.r, root.g, root.b}));
  if (shared < 1.0f) return {0, 0, 0, 0};
  return glm::u8vec4(glm::vec4(glm::round(255.0f * 255.0f / shared * root), shared));
}

}  // namespace kasumi
