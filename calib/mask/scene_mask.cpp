#include "calib/mask/scene_mask.hpp"

#include <algorithm>
#include <cmath>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "calib/mask/guided_filter.hpp"

namespace kasumi {
namespace {

// Pieces of a kind that no stroke of it touches become the other kind.
void keep_stroked(cv::Mat& labels, const Image<Stroke>& strokes, const cv::Rect& box, Stroke kind) {
  const auto is_hidden = [](std::uint8_t label) { return label == cv::GC_FGD || label == cv::GC_PR_FGD; };
  cv::Mat of(labels.size(), CV_8UC1), pieces;
  for (int y = 0; y < labels.rows; ++y)
    for (int x = 0; x < labels.cols; ++x)
      of.at<std::uint8_t>(y, x) = is_hidden(labels.at<std::uint8_t>(y, x)) == (kind == Stroke::hidden) ? 255 : 0;
  const int count = cv::connectedComponents(of, pieces, 8, CV_32S);
  std::vector<bool> stroked(static_cast<std::size_t>(count), false);
  for (int y = 0; y < labels.rows; ++y)
    for (int x = 0; x < labels.cols; ++x)
      if (strokes.at(box.x + x, box.y + y) == kind) stroked[static_cast<std::size_t>(pieces.at<int>(y, x))] = true;
  for (int y = 0; y < labels.rows; ++y)
    for (int x = 0; x < labels.cols; ++x)
      if (const int piece = pieces.at<int>(y, x); piece > 0 && !stroked[static_cast<std::size_t>(piece)])
        labels.at<std::uint8_t>(y, x) = kind == Stroke::hidden ? cv::GC_PR_BGD : cv::GC_PR_FGD;
}

// A mask of 0 and 1 made to follow what a few pixels of the picture show of leaves and branches.
Image<float> softened(const cv::Mat& view, const cv::Mat& mask, int radius) {
  constexpr double kFlat = 1e-4;
  Image<glm::vec3> guide(view.cols, view.rows);
  Image<float> input(view.cols, view.rows);
  for (int y = 0; y < view.rows; ++y)
    for (int x = 0; x < view.cols; ++x) {
      const auto& pixel = view.at<cv::Vec3b>(y, x);
      guide.at(x, y) = glm::vec3(pixel[0], pixel[1], pixel[2]) / 255.0F;
      input.at(x, y) = mask.at<float>(y, x);
    }
  return guided_filter(guide, input, radius, kFlat);
}

}  // namespace

Result<SceneMask> find_scene_mask(const Image<Rgb8>& picture, const Image<Stroke>& strokes, const MaskExtent& options) {
  const cv::Rect whole(0, 0, picture.width(), picture.height());
  const cv::Rect box =
      options.box ? cv::Rect(options.box->x, options.box->y, options.box->z, options.box->w) & whole : whole;
  Problems problems;
  if (box.area() < 64) problems.add("the box: expected at least 64 pixels of the picture in it");
  std::array<std::int64_t, 3> drawn{};
  for (int y = box.y; y < box.y + box.height; ++y)
    for (int x = box.x; x < box.x + box.width; ++x) ++drawn[static_cast<std::size_t>(strokes.at(x, y))];
  for (const auto& [kind, description] : {std::pair{Stroke::hidden, "what stands in front (red, [[hidden]])"},
                                          std::pair{Stroke::free, "what is free (green or blue, [[free]])"}})
    if (drawn[static_cast<std::size_t>(kind)] < 20)
      problems.add("strokes on {}: {} pixels{}, expected at least 20", description,
                   drawn[static_cast<std::size_t>(kind)], options.box ? " in the box" : "");
  if (!problems.empty()) return fail(problems.fault());

  auto copy = picture.elements();
  const cv::Mat all(picture.height(), picture.width(), CV_8UC3, copy.data());
  const cv::Mat view = all(box).clone();
  // Undecided is what is nearer to strokes of one kind.
  cv::Mat near_hidden(box.size(), CV_8UC1), near_free(box.size(), CV_8UC1), to_hidden, to_free;
  for (int y = 0; y < box.height; ++y)
    for (int x = 0; x < box.width; ++x) {
      const auto stroke = strokes.at(box.x + x, box.y + y);
      near_hidden.at<std::uint8_t>(y, x) = stroke == Stroke::hidden ? 0 : 255;
      near_free.at<std::uint8_t>(y, x) = stroke == Stroke::free ? 0 : 255;
    }
  cv::distanceTransform(near_hidden, to_hidden, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  cv::distanceTransform(near_free, to_free, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  cv::Mat labels(box.size(), CV_8UC1);
  for (int y = 0; y < box.height; ++y)
    for (int x = 0; x < box.width; ++x) {
      const float hidden = to_hidden.at<float>(y, x), free = to_free.at<float>(y, x);
      labels.at<std::uint8_t>(y, x) = hidden == 0.0F  ? cv::GC_FGD
                                      : free == 0.0F  ? cv::GC_BGD
                                      : hidden < free ? cv::GC_PR_FGD
                                                      : cv::GC_PR_BGD;
    }
  cv::setRNGSeed(1);
  try {
    cv::Mat hidden_colours, free_colours;
    cv::grabCut(view, labels, {}, free_colours, hidden_colours, 6, cv::GC_INIT_WITH_MASK);
  } catch (const cv::Exception& error) {
    return fail(FaultKind::bad_input, "the picture cannot be segmented: {}", error.err);
  }
  keep_stroked(labels, strokes, box, Stroke::hidden);
  keep_stroked(labels, strokes, box, Stroke::free);

  cv::Mat free(box.size(), CV_32F);
  for (int y = 0; y < box.height; ++y)
    for (int x = 0; x < box.width; ++x) {
      const auto label = labels.at<std::uint8_t>(y, x);
      free.at<float>(y, x) = label == cv::GC_BGD || label == cv::GC_PR_BGD ? 1.0F : 0.0F;
    }
  if (options.soft_px > 0.0) {
    const int radius = std::max(1, static_cast<int>(std::lround(options.soft_px)));
    const Image<float> soft = softened(view, free, radius);
    cv::Mat hard, to_free_edge, to_hidden_edge;
    free.convertTo(hard, CV_8UC1, 255.0);
    cv::distanceTransform(hard, to_hidden_edge, cv::DIST_L2, cv::DIST_MASK_PRECISE);
    cv::distanceTransform(255 - hard, to_free_edge, cv::DIST_L2, cv::DIST_MASK_PRECISE);
    const auto reach = static_cast<float>(options.soft_px);
    for (int y = 0; y < box.height; ++y)
      for (int x = 0; x < box.width; ++x) {
        const float from_edge = std::max(to_hidden_edge.at<float>(y, x), to_free_edge.at<float>(y, x));
        if (from_edge <= reach) free.at<float>(y, x) = std::clamp(soft.at(x, y), 0.0F, 1.0F);
      }
  }

  SceneMask found{Image<std::uint8_t>(picture.width(), picture.height(), 255), 0.0};
  double hidden = 0.0;
  for (int y = 0; y < box.height; ++y)
    for (int x = 0; x < box.width; ++x) {
      const float share = free.at<float>(y, x);
      // Clamps shares near 0 and 1, so that ripple of the guided filter does not show.
      const float clean = std::clamp((share - 0.04F) / 0.92F, 0.0F, 1.0F);
      found.mask.at(box.x + x, box.y + y) = static_cast<std::uint8_t>(std::lround(255.0F * clean));
      hidden += 1.0 - static_cast<double>(clean);
    }
  found.hidden_share = hidden / static_cast<double>(box.area());
  return found;
}

}  // namespace kasumi
