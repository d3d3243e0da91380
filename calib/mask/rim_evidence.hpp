// What a picture says for and against a circle's being the image circle.
#pragma once

#include <vector>

#include <opencv2/core.hpp>

#include "calib/mask/rim_edges.hpp"
#include "calib/mask/rim_fit.hpp"

namespace kasumi {

struct RimEvidence {
  double shown = 0.0;      // share of the rim that the frame shows
  double covered = 0.0;    // share of that with an edge on the rim
  double tightly = 0.0;    // with one within half of that tolerance
  double beyond = 0.0;     // share of the directions with an edge across the radius further out
  double step = 0.0;       // median step across the rim, tones
  double weak_step = 0.0;  // its lower quartile
  double depth = 0.0;      // step over how much the surround differs from what lies further in
  double same_way = 0.0;   // |mean sign of the steps|: all darker outwards, or all lighter
  double uneven = 0.0;     // scatter of tones just outside, from one direction to the next, over the step
  double uneven_inside = 0.0;
  double ripple = 0.0;         // median change of tones along the radius just outside, over the step
  double lit_inside = 0.0;     // share of the area inside that is unlike the surround
  double lit_outside = 0.0;    // of the area outside
  double hem_in = 0.0;         // of what lies just inside the rim
  double hem_out = 0.0;        // of what lies just outside
  double relative_step = 0.0;  // ln of the step over the largest one across any other well seen circle
  double off_centre = 0.0;     // of the frame, over its shorter side
  double size = 0.0;           // radius over the frame's shorter side
  double sigma = 0.0;          // of the fit, over the radius
};
RimEvidence evidence_for(const Rim& rim, const cv::Mat3f& tones, const std::vector<RimEdge>& edges);

// Sets the findings that need a comparison with the others.
void compare(std::vector<RimEvidence*> all);

// ln of the odds that the circle is within 2 % of the image circle.
double score_of(const RimEvidence& evidence);

}  // namespace kasumi
