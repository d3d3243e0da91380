// Edges at which a picture grows darker outwards, along rays from a point.
#pragma once

#include <vector>

#include <glm/vec2.hpp>
#include <opencv2/core.hpp>

namespace kasumi {

struct RimEdge {
  glm::dvec2 point{};
  double contrast = 0.0;  // ln of brightness, inside less outside
};
using RayEdges = std::vector<RimEdge>;  // of one ray, outwards

// How brightness is compared: steps are relative where it is light, and drown where it is as dark as the noise.
class RimScan {
 public:
  explicit RimScan(const cv::Mat1b& brightness);

  static constexpr int kRays = 720;
  // The strongest edges of every ray.
  std::vector<RayEdges> edges(const glm::dvec2& from) const;
  // Where light falls through the middle between its level inside and outside of an edge. NaN if it does not.
  double crossing_px(const glm::dvec2& centre, int ray, double radius_px, double reach_px) const;
  double log_at(const glm::dvec2& point) const;
  bool contains(const glm::dvec2& point, double margin) const;
  static glm::dvec2 direction(int ray);
  int width() const { return log_.cols; }
  int height() const { return log_.rows; }

 private:
  cv::Mat1f log_;
  cv::Mat1f light_;
  double least_contrast_ = 0.0;  // of an edge that stands out of the noise
};

}  // namespace kasumi
