// The air in [site]: values, "auto", and what is said of bad ones.
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/site/config/given_air_keys.hpp"
#include "pipeline/site/config/installation.hpp"
#include "pipeline/site/config/run_config.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

GivenAir read_air(const std::string& text, std::string* problems = nullptr) {
  const auto table = ConfigTable::parse(text, "kasumi.toml").value();
  const auto given = read_given_air(table);
  const auto finished = table.finish();
  if (problems)
    *problems = finished ? "" : finished.error().message;
  else
    EXPECT_TRUE(finished) << finished.error().message;
  return given;
}

TEST(GivenAirKeys, EachIsAValueOrAuto) {
  EXPECT_EQ(read_air(""), GivenAir{});
  EXPECT_EQ(read_air("aod_550 = \"auto\"\nangstrom_exponent = \"auto\"\naerosol = \"auto\""), GivenAir{});
  EXPECT_EQ(read_air("aod_550 = 0.3\nangstrom_exponent = -0.1\naerosol = \"dust\""),
            (GivenAir{0.3, -0.1, AerosolKind::dust}));
  EXPECT_EQ(read_air("aod_550 = 0"), (GivenAir{0.0, std::nullopt, std::nullopt})) << "molecules alone";
}

TEST(GivenAirKeys, EveryBadValueIsNamedWithWhatIsExpected) {
  std::string problems;
  read_air("aod_550 = 3\nangstrom_exponent = \"steep\"\naerosol = \"fog\"", &problems);
  EXPECT_THAT(problems, HasSubstr("aod_550 = 3: expected a number from 0 to 1.8, or \"auto\""));
  EXPECT_THAT(problems, HasSubstr("angstrom_exponent = 'steep': expected a number from -0.5 to 2.5, or \"auto\""));
  EXPECT_THAT(problems, HasSubstr("aerosol = 'fog': expected one of \"continental\""));
  EXPECT_THAT(problems, HasSubstr("\"smoke\", or \"auto\""));
}

TEST(GivenAirKeys, ANumberThatIsNoneIsRefused) {
  for (const char* text : {"aod_550 = nan", "aod_550 = true", "aerosol = 3"}) {
    std::string problems;
    EXPECT_EQ(read_air(text, &problems), GivenAir{});
    EXPECT_THAT(problems, HasSubstr("expected")) << text;
  }
}

TEST(GivenAirKeys, DecideTheSkyThatIsFitted) {
  Installation installation;
  installation.site.altitude_m = 300.0;
  EXPECT_EQ(installation.model_to_fit().model, DaylightModel::preetham);
  EXPECT_TRUE(installation.model_to_fit().every_model) << "all are asked";
  installation.surroundings.air.kind = AerosolKind::smoke;
  EXPECT_EQ(installation.model_to_fit().model, DaylightModel::dome);
  EXPECT_EQ(installation.model_to_fit().aerosol->kind, AerosolKind::smoke);
  EXPECT_EQ(installation.model_to_fit().known, installation.surroundings.air);
  installation.surroundings.sky_model = DaylightModel::preetham;
  EXPECT_EQ(installation.model_to_fit().model, DaylightModel::preetham) << "asked for";
  EXPECT_FALSE(installation.model_to_fit().every_model);
  EXPECT_FALSE(installation.model_to_fit().aerosol);
}

TEST(SkyModelKey, OfAKioskIsNotThePapersAlone) {
  const auto table = ConfigTable::parse("[site]\nsky_model = \"preetham\"\n", "kasumi.toml").value();
  EXPECT_EQ(read_installation(table).surroundings.sky_model, DaylightModel::preetham) << "of a recording";
  const auto config = read_run_config(table);
  EXPECT_EQ(config.installation.surroundings.sky_model, DaylightModel::automatic);
  EXPECT_THAT(config.sky_model_note,
              HasSubstr("sky_model = \"preetham\": the papers' way is for photographs and replays"));
}

TEST(SceneToneKey, CorrectsASupposedResponseAndNoMeasuredOne) {
  const auto scene = [](const std::string& keys) {
    return ConfigTable::parse("[scene]\n" + keys, "kasumi.toml").value();
  };
  const auto corrected_one = read_installation(scene("response = \"srgb\"\ntone_exponent = 1.3\n"));
  const auto plain = read_installation(scene("response = \"srgb\"\n"));
  EXPECT_EQ(corrected_one.scene_tone_exponent, 1.3);
  EXPECT_FALSE(plain.scene_tone_exponent);
  for (const double encoded : {0.1, 0.4, 0.8}) {
    const double as_read = plain.scene.response.to_light(glm::dvec3(encoded)).g;
    EXPECT_NEAR(corrected_one.scene.response.to_light(glm::dvec3(encoded)).g, std::pow(as_read, 1.0 / 1.3), 2e-3);
  }
  for (const char* keys :
       {"response = \"linear\"\ntone_exponent = 1.3\n", "response = \"srgb\"\ntone_exponent = 9\n"}) {
    const auto table = scene(keys);
    EXPECT_NE(read_installation(table).scene_tone_exponent, 1.3) << keys;
    EXPECT_THAT(table.finish().error().message, HasSubstr("scene.tone_exponent = ")) << keys;
  }
}

}  // namespace
}  // namespace kasumi
