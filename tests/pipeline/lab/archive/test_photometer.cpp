// The camera against a sun photometer's table.
#include <gmock/gmock.h>

#include <cmath>
#include <fstream>

#include <nlohmann/json.hpp>

#include "base/utc_text.hpp"
#include "pipeline/lab/archive/photometer.hpp"
#include "pipeline/lab/archive/series_plots.hpp"
#include "tests/pipeline/recorded.hpp"

namespace kasumi {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(Photometer, AngstromsLawIsFollowedTo550) {
  const auto law = [](double nm, double exponent) { return 0.2 * std::pow(nm / 550.0, -exponent); };
  EXPECT_NEAR(*aod_at_550({{440.0, law(440.0, 1.4)}, {870.0, law(870.0, 1.4)}}), 0.2, 1e-12);
  // The exponent itself changes with the wavelength.
  const auto curved = [](double nm) {
    const double x = std::log(nm / 550.0);
    return std::exp(std::log(0.2) - 1.4 * x - 0.5 * x * x);
  };
  EXPECT_NEAR(
      *aod_at_550({{440.0, curved(440.0)}, {500.0, curved(500.0)}, {675.0, curved(675.0)}, {870.0, curved(870.0)}}),
      0.2, 1e-9);
  EXPECT_FALSE(aod_at_550({{440.0, 0.2}}));
  EXPECT_FALSE(aod_at_550({{440.0, 0.2}, {500.0, 0.18}}));
}

class PhotometerTable : public testing::Test {
 protected:
  static constexpr const char* kHead =
      "AERONET Version 3; AOD Level 2.0\nSite\nVersion 3: AOD Level 2.0\nThe following data are automatically cloud "
      "cleared\nContact: PI=nobody\nAll Points,UNITS\n"
      "AERONET_Site,Date(dd:mm:yyyy),Time(hh:mm:ss),Day_of_Year,AOD_1640nm,AOD_870nm,AOD_675nm,AOD_500nm,AOD_440nm\n";
  void SetUp() override { std::filesystem::create_directories(folder); }
  std::filesystem::path file_of(const std::string& text) const {
    std::ofstream(folder / "site.lev20") << text;
    return folder / "site.lev20";
  }
  std::string problem_of(const std::string& text) const {
    const auto read = read_photometer({file_of(text)});
    return read ? "" : read.error().message;
  }
  const std::filesystem::path folder = test_folder("photometer");
};

TEST_F(PhotometerTable, IsReadAsAeronetGivesIt) {
  const auto read =
      read_photometer({file_of(std::string(kHead) + "Bern,21:06:2025,09:30:00,172,0.01,0.1,-999.,-999.,0.2\r\n"
                                                    "Bern,20:06:2025,09:30:00,171,0.01,-999.,-999.,-999.,0.2\n"
                                                    "Bern,20:06:2025,10:30:00,171,0.01,0.1,0.1,0.1,0.1\n")});
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->size(), 2u);
  EXPECT_EQ(utc_text((*read)[0].utc), "2025-06-20T10:30:00Z");
  EXPECT_NEAR((*read)[0].aod_550, 0.1, 1e-9);
  EXPECT_EQ(utc_text((*read)[1].utc), "2025-06-21T09:30:00Z");
  EXPECT_NEAR((*read)[1].aod_550, 0.2 * std::pow(0.5, std::log(550.0 / 440.0) / std::log(870.0 / 440.0)), 1e-9);
}

TEST_F(PhotometerTable, OtherTablesAreRefusedWithTheirLine) {
  EXPECT_THAT(problem_of("a,b\n1,2\n"), HasSubstr("site.lev20: expected a table of AERONET"));
  EXPECT_THAT(problem_of(""), HasSubstr("expected a table of AERONET"));
  EXPECT_THAT(problem_of(std::string(kHead) + "Bern,2025-06-21,09:30:00,1,1,1,1,1,1\n"), HasSubstr("line 8: no date"));
  EXPECT_THAT(problem_of(std::string(kHead) + "Bern,21:06:2025,09:30:00,172,0.1,x\n"),
              HasSubstr("line 8: AOD_870nm: expected a number"));
  EXPECT_THAT(problem_of(std::string(kHead) + "Bern\n"), HasSubstr("line 8: no date"));
  EXPECT_THAT(read_photometer({"/nowhere.lev20"}).error().message, HasSubstr("--photometer /nowhere.lev20"));
}

nlohmann::json taken(const char* utc, double aod) {
  return {{"utc", utc}, {"refused", nullptr}, {"aod_550", aod}};
}

TEST(PhotometerComparison, TakesTheNearestWithinAQuarterOfAnHour) {
  PhotometerComparison comparison(
      {{*parse_utc("2025-06-21T09:30:00Z"), 0.10}, {*parse_utc("2025-06-21T09:50:00Z"), 0.20}});
  comparison.add(taken("2025-06-21T09:14:59Z", 9.0));
  comparison.add(taken("2025-06-21T09:15:00Z", 0.16));  // 0.10
  comparison.add(taken("2025-06-21T09:41:00Z", 0.24));  // 0.20
  comparison.add(taken("2025-06-21T10:05:01Z", 9.0));
  auto refused = taken("2025-06-21T09:30:00Z", 9.0);
  refused["refused"] = "overcast";
  comparison.add(refused);
  auto night = taken("2025-06-21T09:30:00Z", 9.0);
  night["sun_zenith_deg"] = 95.0;
  comparison.add(night);
  comparison.add({{"utc", nullptr}, {"refused", nullptr}, {"aod_550", 9.0}});
  const auto all = comparison.agreement();
  ASSERT_EQ(all.pairs, 2u);
  EXPECT_NEAR(all.bias, 0.05, 1e-6);
  EXPECT_NEAR(all.rmse, std::sqrt((0.06 * 0.06 + 0.04 * 0.04) / 2.0), 1e-6);
  EXPECT_NEAR(all.scatter, std::sqrt(2.0) * 0.01, 1e-6);
  EXPECT_NEAR(all.within_expected, 1.0, 1e-12);
  comparison.add(taken("2025-06-21T09:30:00Z", 0.17));
  EXPECT_NEAR(comparison.agreement().within_expected, 2.0 / 3.0, 1e-12);
  EXPECT_THAT(plot_agreement(comparison), AllOf(HasSubstr("+0.060 at 0.130"), HasSubstr("stroke-dasharray")));
  EXPECT_EQ(PhotometerComparison({}).agreement().pairs, 0u);
}

}  // namespace
}  // namespace kasumi
