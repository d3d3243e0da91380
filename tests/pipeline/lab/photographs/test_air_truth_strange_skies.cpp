// What `kasumi estimate` tells of strangers' pictures with hand-made labels, asked as a user asks: a list on standard
// input. Every share is the mean over cameras of each camera's share, so that a camera of many pictures weighs as one.
#include <cmath>
#include <fstream>
#include <map>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "base/outside/json_text.hpp"
#include "base/statistics.hpp"
#include "pipeline/site/files/contact_sheet.hpp"
#include "tests/estimator/sky_camera/labelled_skies.hpp"
#include "tests/figures.hpp"
#include "tests/pipeline/run_kasumi.hpp"

namespace kasumi {
namespace {

using Json = nlohmann::json;
using test::LabelledSky;

constexpr const char* kTable = "strange-skies";

// Shares by camera.
class Shares {
 public:
  void add(const std::string& camera, double value) {
    auto& [sum, count] = cameras_[camera];
    sum += value;
    ++count;
    ++all_;
  }
  double percent() const {
    double sum = 0.0;
    for (const auto& [camera, share] : cameras_) sum += 100.0 * share.first / share.second;
    return sum / std::max<double>(1.0, static_cast<double>(cameras_.size()));
  }
  std::string of() const {
    return fmt::format("{} pictures of {}", all_,
                       cameras_.size() == 1 ? "one camera" : fmt::format("{} cameras", cameras_.size()));
  }

 private:
  std::map<std::string, std::pair<double, int>> cameras_;
  int all_ = 0;
};

std::map<std::string, Json> answers_to(const std::vector<LabelledSky>& skies) {
  const auto folder = shared_data_folder() / "sky" / "real";
  const auto list = test_folder("strange-skies.list");
  std::ofstream file(list);
  for (const auto& sky : skies) file << (folder / sky.file).string() << "\n";
  file.close();
  // The labels have the image circle at 90 deg.
  const auto outcome = run_kasumi(fmt::format("estimate - --json --fov-deg 180 < {}", list.string()));
  std::map<std::string, Json> answers;
  std::istringstream lines(outcome.out);
  for (std::string line; std::getline(lines, line);) {
    auto json = parse_json(line);
    const std::filesystem::path image = json["image"].get<std::string>();
    answers[image.filename().string()] = std::move(json);
  }
  return answers;
}

std::optional<ImageCircle> circle_of(const Json& answer) {
  const auto circle = answer.value("circle", Json());
  if (!circle.is_array()) return std::nullopt;
  return ImageCircle{{circle[0].get<double>(), circle[1].get<double>()}, circle[2].get<double>()};
}

// How far the circle told is from a label, over the label's radius.
double off(const ImageCircle& told, const ImageCircle& label) {
  return std::max(glm::distance(told.centre, label.centre), std::abs(told.radius_px - label.radius_px)) /
         label.radius_px;
}

// The sun's pixel by the circle told, so that lens and orientation do not matter.
std::optional<glm::dvec2> sun_of(const Json& answer) {
  const auto circle = circle_of(answer);
  const auto& seen = answer["sun_seen"];
  if (!circle || !seen.is_object()) return std::nullopt;
  const auto up = answer["azimuth_up_deg"].is_number() ? answer["azimuth_up_deg"].get<double>() : 0.0;
  const double azimuth = from_degrees(seen["azimuth_deg"].get<double>() - up).value;
  const double from_middle = seen["zenith_deg"].get<double>() / 90.0 * circle->radius_px;
  return circle->centre - from_middle * glm::dvec2{std::sin(azimuth), std::cos(azimuth)};
}

void draw(ContactSheet& sheet, const LabelledSky& sky, const Json& answer) {
  auto picture = sky.pixels;
  cv::Mat view(picture.height(), picture.width(), CV_8UC3, picture.row(0));
  const int width = std::max(1, picture.width() / 200);
  const auto ring = [&](const glm::dvec2& at, double radius, const cv::Scalar& colour) {
    cv::circle(view, cv::Point(static_cast<int>(at.x), static_cast<int>(at.y)), static_cast<int>(radius), colour, width,
               cv::LINE_AA);
  };
  if (const auto circle = circle_of(answer)) ring(circle->centre, circle->radius_px, cv::Scalar(255, 220, 0));
  if (const auto sun = sun_of(answer)) ring(*sun, picture.width() / 30.0, cv::Scalar(255, 0, 0));
  if (sky.sun_px) ring(*sky.sun_px, picture.width() / 60.0, cv::Scalar(0, 220, 0));
  std::string caption = answer["sky"].is_string() ? answer["sky"].get<std::string>() : "no sky";
  if (answer["cloud_fraction"].is_number())
    caption += fmt::format(" {:.0f} %", 100.0 * answer["cloud_fraction"].get<double>());
  if (answer["usable"].get<bool>())
    caption += fmt::format(", T {:.1f} +- {:.1f}", answer["turbidity"].get<double>(), answer["sigma"].get<double>());
  sheet.add(picture, sky.id + ": " + caption);
}

TEST(AirTruthStrangeSkies, CircleSunCloudAndAirOfStrangersPictures) {
  const auto skies = test::labelled_skies();
  if (skies.empty()) GTEST_SKIP() << "no shared data: sky/real";
  const auto answers = answers_to(skies);
  ContactSheet sheet;
  Shares circle, wrong, sun, false_sun, overcast, taken, answered, cloud_off, covered, classes;
  std::vector<double> turbidities;
  for (const LabelledSky& sky : skies) {
    const auto found = answers.find(std::filesystem::path(sky.file).filename().string());
    ASSERT_NE(found, answers.end()) << sky.file;
    const Json& answer = found->second;
    draw(sheet, sky, answer);
    const auto told = circle_of(answer);
    double least = 9.0;
    for (const auto& label : sky.circles)
      if (told) least = std::min(least, off(*told, label));
    circle.add(sky.name, told && least <= sky.circle_tolerance);
    wrong.add(sky.name, told && least > sky.circle_tolerance);
    const auto seen = sun_of(answer);
    if (sky.sun_px && sky.sun_scored) {
      const double away = seen ? glm::distance(*seen, *sky.sun_px) / sky.tolerance_px : 9.0;
      sun.add(sky.name, away <= 1.0);
      false_sun.add(sky.name, seen && away > 2.0);
    } else if (sky.sun_scored) {
      false_sun.add(sky.name, seen.has_value());
    }
    const bool usable = answer["usable"].get<bool>();
    if (sky.sky == "overcast") overcast.add(sky.name, usable);
    if ((sky.sky == "clear" || sky.sky == "few") && sky.sun_px) {
      taken.add(sky.name, usable);
      if (usable) turbidities.push_back(answer["turbidity"].get<double>());
    }
    if (sky.sky != "unknown" && sky.sky != "none")
      classes.add(sky.name, answer["sky"].is_string() && answer["sky"].get<std::string>() == sky.sky);
    if (!sky.cloud) continue;
    answered.add(sky.name, answer["cloud_fraction"].is_number());
    if (!answer["cloud_fraction"].is_number()) continue;
    const double away = std::abs(answer["cloud_fraction"].get<double>() - *sky.cloud);
    cloud_off.add(sky.name, away);
    covered.add(sky.name, away <= 2.0 * answer["sigma_cloud_fraction"].get<double>());
  }
  const auto drawn = test_folder("strange-skies.png");
  ASSERT_TRUE(sheet.write(drawn));
  fmt::print("circles (yellow), suns (red; labelled: green): {}\n", drawn.string());

  const auto row = [](const char* what, const Shares& shares, const char* goal) {
    const auto found = fmt::format("{} %", figure_text(shares.percent(), 1));
    fmt::print("{}: {} of {} (goal {})\n", what, found, shares.of(), goal);
    figure_row(kTable, {what, found, goal, shares.of()});
  };
  row("image circle within 2 or 3 % of its radius", circle, ">= 95 %");
  row("image circle told wrong", wrong, "<= 1 %");
  row("sun, disc or blob, within 2 deg", sun, ">= 90 %");
  row("sun told where there is none, or elsewhere", false_sun, "<= 2 %");
  row("overcast skies taken for air", overcast, "<= 2 %");
  row("clear and few-clouded skies with a sun: air told", taken, ">= 60 %");
  row("cloud fraction told", answered, ">= 90 %");
  row("cloud fraction off its mask, mean", cloud_off, "<= 10 %");
  row("cloud fraction within 2 sigma of its mask", covered, ">= 95 %");
  row("sky class", classes, ">= 85 %");
  fmt::print("T {:.1f} to {:.1f}\n", quantile(turbidities, 0.0), quantile(turbidities, 1.0));
  EXPECT_GE(circle.percent(), 95.0);
  EXPECT_LE(wrong.percent(), 1.0);
  EXPECT_GE(sun.percent(), 90.0);
  EXPECT_LE(false_sun.percent(), 2.0);
  EXPECT_LE(overcast.percent(), 2.0);
  EXPECT_GE(taken.percent(), 60.0);
  EXPECT_GE(answered.percent(), 90.0);
  EXPECT_LE(cloud_off.percent(), 10.0);
}

}  // namespace
}  // namespace kasumi
