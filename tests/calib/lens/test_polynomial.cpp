#include <gtest/gtest.h>

#include "calib/lens/polynomial.hpp"

namespace kasumi {
namespace {

Polynomial with_roots(const std::vector<double>& roots, double factor) {
  Polynomial polynomial{factor};
  for (const double root : roots) polynomial = product(polynomial, {-root, 1.0});
  return polynomial;
}

TEST(Polynomial, TheFirstPositiveRootIsFoundAmongNegativeAndLargerOnes) {
  for (const double factor : {1.0, -3.0, 1e-9})
    EXPECT_NEAR(first_positive_root(with_roots({-2.0, 0.25, 0.26, 7.0, 900.0}, factor)).value(), 0.25, 1e-12);
}

TEST(Polynomial, APolynomialWithoutPositiveRootHasNone) {
  EXPECT_FALSE(first_positive_root({1.0, 0.0, 1.0}));
  EXPECT_FALSE(first_positive_root({1.0, 2.0}));
  EXPECT_FALSE(first_positive_root({3.0}));
  EXPECT_FALSE(first_positive_root({}));
}

TEST(Polynomial, ARootIsSoughtUpToThere) {
  const auto polynomial = with_roots({3.0, 5.0, 900.0}, -2.0);
  EXPECT_FALSE(first_positive_root(polynomial, 2.0));
  for (const double most : {3.5, 7.0, 1e6}) EXPECT_NEAR(first_positive_root(polynomial, most).value(), 3.0, 1e-12);
}

TEST(Polynomial, LeadingZerosDoNotHideARoot) {
  EXPECT_NEAR(first_positive_root({-6.0, 2.0, 0.0, 0.0}).value(), 3.0, 1e-12);
}

TEST(SolveIncreasing, AnIllConditionedFunctionIsStillInvertedToFullPrecision) {
  const auto steep = [](double x) { return std::atan(1e3 * (x - 0.7)) + 1e-3 * x; };
  const auto slope = [](double x) { return 1e3 / (1.0 + 1e6 * (x - 0.7) * (x - 0.7)) + 1e-3; };
  for (const double x : {0.0, 0.1, 0.699, 0.7, 0.7001, 1.0})
    EXPECT_NEAR(solve_increasing(steep, slope, steep(x), 0.0, 1.0), x, 1e-11);
}

TEST(SolveIncreasing, ASlopeOfZeroDoesNotStopIt) {
  const auto cube = [](double x) { return x * x * x; };
  const auto slope = [](double x) { return 3.0 * x * x; };
  EXPECT_NEAR(solve_increasing(cube, slope, 0.0, -1.0, 1.0), 0.0, 1e-5);
  EXPECT_NEAR(solve_increasing(cube, slope, 0.5, -1.0, 1.0), std::cbrt(0.5), 1e-14);
}

}  // namespace
}  // namespace kasumi
