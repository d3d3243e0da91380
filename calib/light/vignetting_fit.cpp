#include "calib/light/vignetting_fit.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>
#include <glm/geometric.hpp>

#include "base/statistics.hpp"
#include "calib/lens/polynomial.hpp"

namespace kasumi {
namespace {

struct Pixel {
  double r2, light;
  Eigen::Index picture;
};

std::vector<Pixel> pixels_of(const std::vector<Image<float>>& pictures, const Image<std::uint8_t>& mask,
                             const glm::dvec2& centre, double radius_px) {
  constexpr double kWanted = 2e5;
  double all = 0.0;
  for (const auto& picture : pictures) all += static_cast<double>(picture.elements().size());
  const int step = std::max(1, static_cast<int>(std::sqrt(all / kWanted)));
  std::vector<Pixel> pixels;
  for (std::size_t p = 0; p < pictures.size(); ++p)
    for (int y = 0; y < pictures[p].height(); y += step)
      for (int x = 0; x < pictures[p].width(); x += step) {
        const glm::dvec2 off = (glm::dvec2{x, y} - centre) / radius_px;
        const double r2 = glm::dot(off, off), light = static_cast<double>(pictures[p].at(x, y));
        if (r2 > 1.0 || !(light > 0.0) || (!mask.empty() && mask.at(x, y) == 0)) continue;
        pixels.push_back({r2, light, static_cast<Eigen::Index>(p)});
      }
  return pixels;
}

}  // namespace

// Light k_p (1 + v2 r^2 + v4 r^4 + v6 r^6): for given v the gains, for given gains the v, in turn; each is linear.
Result<VignettingFit> fit_vignetting(const std::vector<Image<float>>& pictures, const Image<std::uint8_t>& mask,
                                     const glm::dvec2& centre, double radius_px) {
  auto pixels = pixels_of(pictures, mask, centre, radius_px);
  constexpr std::size_t kFewest = 200;
  if (pixels.size() < kFewest)
    return fail(FaultKind::bad_input, "{} pixels to see vignetting in: expected at least {}, lit and not saturated",
                pixels.size(), kFewest);
  Eigen::Vector3d v = Eigen::Vector3d::Zero();
  Eigen::VectorXd gain = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(pictures.size()));
  const auto shape = [&](double r2) { return 1.0 + r2 * (v(0) + r2 * (v(1) + r2 * v(2))); };
  const auto relative = [&](const Pixel& pixel) { return pixel.light / (gain(pixel.picture) * shape(pixel.r2)) - 1.0; };
  Eigen::Matrix3d normal;
  double sigma = 1e18, sum = 0.0;
  std::size_t used = 0;
  for (int round = 0; round < 40; ++round) {
    Eigen::VectorXd top = Eigen::VectorXd::Zero(gain.size()), bottom = top;
    for (const auto& pixel : pixels) {
      if (round > 5 && std::abs(relative(pixel)) > 4.0 * sigma) continue;
      const double s = shape(pixel.r2);
      top(pixel.picture) += pixel.light * s;
      bottom(pixel.picture) += s * s;
    }
    for (Eigen::Index p = 0; p < gain.size(); ++p)
      if (bottom(p) > 0.0) gain(p) = top(p) / bottom(p);
    normal.setZero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    std::vector<double> off;
    sum = 0.0;
    used = 0;
    for (const auto& pixel : pixels) {
      const double error = relative(pixel);
      off.push_back(error);
      if (round > 5 && std::abs(error) > 4.0 * sigma) continue;
      const Eigen::Vector3d row{pixel.r2, pixel.r2 * pixel.r2, pixel.r2 * pixel.r2 * pixel.r2};
      normal += row * row.transpose();
      right += row * (pixel.light / gain(pixel.picture) - 1.0);
      sum += error * error;
      ++used;
    }
    v = normal.ldlt().solve(right);
    sigma = std::max(1e-4, robust_sigma(std::move(off)));
  }
  VignettingFit fit;
  fit.vignetting = {centre, radius_px, {v(0), v(1), v(2)}};
  fit.pixels = used;
  fit.residual = std::sqrt(sum / static_cast<double>(std::max<std::size_t>(used, 1)));
  const Eigen::Vector3d at_rim = Eigen::Vector3d::Ones();
  fit.rim_sigma = fit.residual * std::sqrt(at_rim.dot(normal.ldlt().solve(at_rim)));
  if (const auto dark = first_positive_root({1.0, v(0), v(1), v(2)}); dark && *dark <= 1.0)
    return fail(FaultKind::bad_input,
                "the picture darkens to nothing {:.0f} px from the centre: expected something evenly lit out to {:.0f} "
                "px",
                std::sqrt(*dark) * radius_px, radius_px);
  return fit;
}

}  // namespace kasumi
