// The drawing of the air over a recording.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/lab/recording/air_curve.hpp"

namespace kasumi {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::Not;

TrackedAir air_of_aod(double aod_550, std::vector<ObserverPart> observers) {
  TrackedAir state;
  state.air = AirState(Aerosol{aod_550, 1.3, AerosolKind::continental}, {4e-4, 0.0, 0.01});
  state.observers = std::move(observers);
  return state;
}

int count_of(const std::string& text, const std::string& part) {
  int count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

TEST(AirCurve, HasABandForEachStepAndAMarkForEachReading) {
  AirCurve curve;
  EXPECT_TRUE(curve.empty());
  curve.add(Utc{0s}, air_of_aod(0.2, {{AirObserver::sky, 0s, 0.21, 0.02, 1.0, 0.0}}));
  curve.add(Utc{60s}, air_of_aod(0.3, {{AirObserver::landmarks, 0s, 0.35, 0.04, 0.7, 1.5},
                                       {AirObserver::sky, 60s, 0.21, 0.02, 0.3, -1.5}}));
  curve.add(Utc{120s}, air_of_aod(0.3, {{AirObserver::landmarks, 60s, 0.35, 0.04, 0.7, 1.5}}));
  const auto svg = curve.svg();
  EXPECT_EQ(count_of(svg, "<polygon"), 2);
  EXPECT_EQ(count_of(svg, "<circle"), 2) << "a reading is drawn once, when it is made";
  EXPECT_THAT(svg, HasSubstr("1970-01-01T00:02:00Z"));
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
  EXPECT_THAT(svg, Not(HasSubstr("inf")));
}

TEST(AirCurve, IsPaleWhereTheAirIsSupposed) {
  AirCurve curve;
  TrackedAir supposed = air_of_aod(0.15, {});
  curve.add(Utc{0s}, supposed);
  curve.add(Utc{60s}, supposed);
  const auto seen = curve.svg();
  supposed.supposed = true;
  AirCurve pale;
  pale.add(Utc{0s}, supposed);
  pale.add(Utc{60s}, supposed);
  EXPECT_NE(pale.svg(), seen);
}

TEST(AirCurve, OfOneMomentIsADrawingToo) {
  AirCurve curve;
  EXPECT_THAT(curve.svg(), HasSubstr("</svg>"));
  curve.add(Utc{0s}, air_of_aod(0.0, {}));
  EXPECT_THAT(curve.svg(), Not(HasSubstr("nan")));
}

}  // namespace
}  // namespace kasumi
