// M Sect 7.1.1's experiment: turbidity estimated repeatedly from one generated sky, with different samples each time.
#pragma once

#include "estimator/turbidity/turbidity.hpp"
#include "tests/estimator/turbidity/synthetic_sky.hpp"

namespace kasumi::test {

struct Repeated {
  double mean = 0.0, sigma = 0.0;
  double bound = 0.0;   // Cramer-Rao, mean over the samples drawn
  double stated = 0.0;  // the estimates' own sigma, mean
  double worst = 0.0;   // largest error
  int usable = 0;
};
// An 8-bit sRGB picture of 500 x 500, N = 100 samples. sun_error_deg: the error of the given sun direction, towards a
// different side each time.
Repeated estimate_often(const SyntheticSky& description, EstimateParameters options, int repeats,
                        double sun_error_deg = 0.0);

// M Table 1, T = 2 .. 9: mean and standard deviation. M14 Table 1 has T = 2, 5, 7, 9 of it.
constexpr double kMoralesTable1[8][2] = {{2.011791, .004660}, {2.851666, .027230}, {4.241544, .043840},
                                         {4.992700, .055292}, {5.836839, .061853}, {7.138090, .062630},
                                         {8.010996, .135764}, {9.099154, .089461}};
// M14 Table 2 at T = 2: the sun's error in degrees, M14's and Zhao's error in per cent.
constexpr double kMorales2014Table2[3][3] = {{5, .93630, 3}, {10, 3.14890, 5}, {15, 5.10645, 9}};

}  // namespace kasumi::test
