// kasumi calibrate report: one self-contained page with the calibration's actual state.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <regex>

#include "calib/calibration_file.hpp"
#include "pipeline/install/calibration_report/report.hpp"
#include "pipeline/site/files/html.hpp"
#include "pipeline/site/files/picture_sink.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/install/calibrate/calibrating.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(Html, EncodesRfc4648TestVectorsAndEscapesMarkup) {
  for (const auto& [plain, encoded] :
       {std::pair{"", ""}, std::pair{"f", "Zg=="}, std::pair{"fo", "Zm8="}, std::pair{"foo", "Zm9v"},
        std::pair{"foob", "Zm9vYg=="}, std::pair{"fooba", "Zm9vYmE="}, std::pair{"foobar", "Zm9vYmFy"}}) {
    const std::string bytes = plain;
    EXPECT_EQ(data_uri("text/plain", {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}),
              std::string("data:text/plain;base64,") + encoded);
  }
  EXPECT_EQ(html_escaped("<b title='x'>\"R&D\"</b>\x01 \xc3\xa9\n"),
            "&lt;b title=&#39;x&#39;&gt;&quot;R&amp;D&quot;&lt;/b&gt;\xef\xbf\xbd \xc3\xa9\n");
}

TEST(CalibrationExpectations, VerdictsFollowTheirUpperAndLowerBounds) {
  const auto rms = expectation_of("lens", "rms_px").value();
  EXPECT_EQ(rms.verdict(rms.good), Verdict::good);
  EXPECT_EQ(rms.verdict(rms.usable), Verdict::usable);
  EXPECT_EQ(rms.verdict(1.01 * rms.usable), Verdict::poor);
  const auto covered = expectation_of("lens", "covered").value();  // here larger is better
  EXPECT_EQ(covered.verdict(1.0), Verdict::good);
  EXPECT_EQ(covered.verdict(0.99 * covered.good), Verdict::usable);
  EXPECT_EQ(covered.verdict(0.1), Verdict::poor);
  EXPECT_THAT(covered.text(), HasSubstr("or more"));
  EXPECT_FALSE(expectation_of("lens", "no such key"));
}

CalibrationStep lens_step(const std::string& from) {
  CalibrationStep step;
  step.camera = "sky";
  step.width = 400;
  step.height = 300;
  step.serial = "<FE&1>";
  step.lens = LensDescription{OpencvFisheyeParameters{{130.0, 130.5}, {203.0, 147.5}, {}}, from_degrees(80.0)};
  step.site = Site{"", 46.9, 8.3, 450.0};
  step.calibrated_utc = "2026-06-21T09:00:00Z";
  step.measured = {{"lens",
                    "2026-06-21T09:00:00Z",
                    from,
                    {{"rms_px", 0.31}, {"focal_sigma_px", 0.26}, {"covered", 0.4}},
                    {"a<b>.png: dropped, 3 px off & more"},
                    "c.sky-lens.png"}};
  return step;
}

TEST(CalibrationReport, OnePageContainsEverythingAndFetchesNothing) {
  const auto folder = fresh_folder("calibrate-report");
  const auto file = folder / "c.toml", page = folder / "report.html";
  ASSERT_TRUE(write_calibration(file, lens_step("3 pictures: \"x\" <script>alert(1)</script>")));
  ASSERT_TRUE(write_png(folder / "c.sky-lens.png", Image<Rgb8>(8, 6, Rgb8(10, 200, 30))));
  CalibrationStep pose;
  pose.camera = "scene";
  pose.width = 960;
  pose.height = 540;
  pose.to_world = camera_to_world(from_degrees(26.1234567), from_degrees(1.2), from_degrees(-1.5));
  pose.calibrated_utc = "2026-06-21T10:00:00Z";
  pose.measured = {{"pose",
                    "2026-06-21T10:00:00Z",
                    "6 landmarks",
                    {{"heading_sigma_deg", 0.0123}, {"new_number_m", 2.5}},
                    {},
                    "../../etc/passwd.png"}};
  ASSERT_TRUE(write_calibration(file, pose));

  const auto outcome = ended(0, run(fmt::format("report {} --out {}", file.string(), page.string())));
  EXPECT_THAT(outcome.out, HasSubstr("sky: still to be done: orientation"));
  const auto html = read_text_file(page).value();
  // The picture is embedded byte for byte.
  EXPECT_THAT(html, HasSubstr(data_uri("image/png", read_file(folder / "c.sky-lens.png").value())));
  // What was measured, when, from what, its uncertainty, its target, and the verdict in words.
  for (const char* part : {"2026-06-21 09:00:00 UTC", "calibrate sky RECORDING --out c.toml", "&lt;script&gt;",
                           "&lt;FE&amp;1&gt;", "a&lt;b&gt;.png: dropped", "0.26 px (0.2 %)", "0.1 % or less", "usable",
                           "0.4", "not good enough: take pictures with the board", "26.123 deg", "0.012 deg",
                           "new number", "2.5 m", "46.90000 deg north"})
    EXPECT_THAT(html, HasSubstr(part));
  // No scripts, no external resources, no file from another folder.
  EXPECT_THAT(html, Not(HasSubstr("<script")));
  EXPECT_THAT(html, Not(HasSubstr("http")));
  EXPECT_FALSE(std::regex_search(html, std::regex("src=\"(?!data:)|href=|url\\(")));
  EXPECT_THAT(html, HasSubstr("passwd.png, is no longer next to the calibration file"));
  // Every opened element is closed again.
  for (const char* tag : {"table", "tr", "td", "ul", "li", "h2", "h3", "p", "body", "html", "details", "pre"}) {
    const auto count = [&](const std::string& what) {
      const std::regex pattern(what);
      return std::distance(std::sregex_iterator(html.begin(), html.end(), pattern), std::sregex_iterator());
    };
    EXPECT_EQ(count(fmt::format("<{}[ >]", tag)), count(fmt::format("</{}>", tag))) << tag;
  }
}

TEST(CalibrationReport, ReportsAllProblemsAtOnceAndWritesNothing) {
  const auto folder = fresh_folder("calibrate-report-wrong");
  const auto page = folder / "report.html";
  ASSERT_TRUE(write_text_file(folder / "other.toml", "[sky]\nwidth = 3\n"));
  ASSERT_TRUE(write_text_file(folder / "broken.toml",
                              "calibration = 1\n[sky]\nwidth = -5\nheight = 3\n[sky.measured.lens]\nutc = 'today'\n"
                              "remarks = 'none'\n[sky.lens]\nmodel = 'equidistant'\nfocal_px = 'long'\n"));
  const auto wrong = [&](const char* file) {
    return run(fmt::format("report {} --out {}", (folder / file).string(), page.string()));
  };
  EXPECT_EQ(wrong("other.toml").code, 2);
  const auto broken = ended(2, wrong("broken.toml"));
  for (const char* part : {"sky.width = -5", "sky.measured.lens.utc", "sky.measured.lens.remarks", "sky.lens.focal_px"})
    EXPECT_THAT(broken.err, HasSubstr(part));
  EXPECT_NE(wrong("missing.toml").code, 0);
  EXPECT_FALSE(std::filesystem::exists(page));
}

}  // namespace
}  // namespace kasumi
