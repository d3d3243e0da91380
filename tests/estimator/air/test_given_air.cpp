#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estimator/air/scattering.hpp"
#include "estimator/given_air.hpp"

namespace kasumi {
namespace {

TEST(GivenAir, WhatIsNotGivenIsThatOfTheKind) {
  EXPECT_FALSE(GivenAir{}.any());
  EXPECT_FALSE(GivenAir{}.to_be_found());
  const GivenAir dust{std::nullopt, std::nullopt, AerosolKind::dust};
  EXPECT_FALSE(dust.whole());
  EXPECT_EQ(dust.to_be_found()->angstrom_exponent, natural_exponent(AerosolKind::dust));
  EXPECT_EQ((GivenAir{0.2, std::nullopt, std::nullopt}.whole()), (Aerosol{0.2, 1.3, AerosolKind::continental}));
  EXPECT_EQ((GivenAir{0.2, 0.4, AerosolKind::smoke}.whole()), (Aerosol{0.2, 0.4, AerosolKind::smoke}));
}

TEST(GivenAir, OptionsGoBeforeKeysOneByOne) {
  const GivenAir site{0.2, 1.0, AerosolKind::dust}, option{std::nullopt, 0.5, std::nullopt};
  EXPECT_EQ(site.overridden_by(option), (GivenAir{0.2, 0.5, AerosolKind::dust}));
  EXPECT_EQ(site.overridden_by({}), site);
}

TEST(AirState, TIsTheAerosolsAndBack) {
  const AirState papers(Turbidity{3.0});
  EXPECT_FALSE(papers.aerosol_known());
  EXPECT_EQ(papers.turbidity(), Turbidity{3.0});
  const Aerosol smoke{0.4, 1.6, AerosolKind::smoke};
  const AirState known(smoke);
  EXPECT_TRUE(known.aerosol_known());
  EXPECT_NEAR(air_of(known.turbidity(), smoke).aerosol().aod_550, 0.4, 1e-12);
  EXPECT_EQ(air_of(Turbidity{3.0}, std::nullopt), papers);
  EXPECT_NE(AirState(aerosol_of(3.0)), papers) << "of the same T, but known";
}

TEST(AirState, SigmaOfTIsCarriedToTheOpticalDepth) {
  const Aerosol like{0.0, 0.5, AerosolKind::desert};
  const double up = air_of(Turbidity{4.1}, like).aerosol().aod_550,
               down = air_of(Turbidity{3.9}, like).aerosol().aod_550;
  EXPECT_NEAR(std::sqrt(air_of(Turbidity{4.0}, like, 0.1).covariance().aod_550), 0.5 * (up - down), 1e-9);
}

TEST(AirState, IsNamedForPeopleAndFiles) {
  EXPECT_THAT(text_of({0.3, 1.32, AerosolKind::continental}), testing::HasSubstr("exponent 1.32, continental (T 3.9"));
  EXPECT_EQ(name_of(AirState(Turbidity{2.5})), "T2.50");
  EXPECT_EQ(name_of(AirState(Aerosol{0.3})), "AOD0.300");
}

TEST(KnownAerosol, ExtinctionIsItsOpticalDepthOver1200mAtAnyAltitude) {
  const AirState dust(Aerosol{0.6, -0.12, AerosolKind::dust});
  EXPECT_NEAR(mie_per_m(ScatteringModel::aerosol, 550.0, dust), 0.6 / 1200.0, 1e-12);
  EXPECT_GT(mie_per_m(ScatteringModel::aerosol, 650.0, dust), mie_per_m(ScatteringModel::aerosol, 450.0, dust));
  double column = 0.0;
  for (double h = 5.0; h < 30e3; h += 10.0) column += 10.0 * mie_per_m(ScatteringModel::aerosol, 550.0, dust, h);
  EXPECT_NEAR(column, 0.6, 1e-4);
}

TEST(KnownAerosol, QualityIsByItsOwnExtinction) {
  const Aerosol aerosol{0.3, 1.3, AerosolKind::continental};
  const auto quality = air_quality(aerosol, 0.0);
  EXPECT_EQ(quality.aod_550, 0.3);
  EXPECT_EQ(quality.aerosol, aerosol);
  EXPECT_NEAR(quality.visibility_m, 3.912 / (0.3 / 1200.0 + molecular_optical_depth(550.0) / 8434.5), 1.0);
  EXPECT_FALSE(air_quality(Turbidity{3.0}, 0.0).aerosol);
}

}  // namespace
}  // namespace kasumi
