// The same scene retargeted to other air by Kasumi, by M as printed, and by the baselines that M compares with (M Sect
// 7.2.3), each compared with the true picture.
#pragma once

#include <string_view>
#include <vector>

#include "estimator/photograph/retarget.hpp"
#include "pipeline/lab/comparison/similarity.hpp"
#include "tests/paper/generated_scene.hpp"

namespace kasumi::paper {

// untouched: the source picture itself, as a baseline.
enum class Method { ours, morales, he, zhu, zhao, untouched };
constexpr Method kMethods[] = {Method::ours, Method::morales, Method::he, Method::zhu, Method::zhao, Method::untouched};
std::string_view name_of(Method method);  // "He 2011"

struct Judged {
  Method method = Method::ours;
  Image<Rgb8> picture;    // the one of best SSIM
  double ssim = 0.0;      // against the true picture
  HsvCorrelation colour;  // of the picture of best combined correlation
};

// A picture, the same scene as it truly looks under other air, and the methods' inputs.
struct Experiment {
  Camera camera;
  Image<Rgb8> picture, truth;
  RetargetGeometry depth;
  RetargetAir source, target;  // light from infinity of every pixel
  Relighting relit;            // only for ours
  bool fog = false;            // only for ours: droplets, which attenuate all colours alike
};
// Light from infinity as measured at the two pictures' horizons.
Experiment experiment_of(const Scene& source, double source_turbidity, const Scene& target, double target_turbidity);

// What each is given. All: the light from infinity of source and target, and which pixels are sky. Ours, M, Zhao: both
// turbidities, the distances, the camera's sensitivity; ours besides what it makes of
// the picture itself, its noise and its land. Zhao 2012 is a thesis that is not public; M Sect 5.2 gives its
// concentration factor, M14 its use: M's rendering equation with Preetham's coefficients times .01, and so it is here.
// He, Zhu: their own transmission from the source picture, as published; the haze is then made so many times as thick
// (t^k) as makes the picture most alike the true one, k searched from 1 (`most_thickness`: to what) for each of the two
// measures separately, in encoded values as published and in linear light, the better of the two taken. Nobody could do
// so without the true picture.
std::vector<Judged> judge_methods(const Experiment& experiment, double most_thickness = 10.0);

}  // namespace kasumi::paper
