// What `kasumi estimate` may be given, mixed and in order.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fcntl.h>
#include <cstdlib>
#include <fstream>
#include <set>

#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "base/outside/json_text.hpp"
#include "base/utc_text.hpp"
#include "capture/fixture/fixture.hpp"
#include "pipeline/lab/photographs/estimate_inputs.hpp"
#include "tests/house/document_code.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/run_kasumi.hpp"

namespace kasumi {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

class GivenInputs : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder / "sky/below");
    std::filesystem::create_directories(folder / "empty");
    for (const char* name : {"one.png", "two[1].jpg", "@at.png", "sky/b.JPG", "sky/a.jpeg", "sky/.hidden.png",
                             "sky/a.jpeg.fit.png", "sky/notes.txt", "sky/below/c.png"})
      std::ofstream(folder / name) << "x";
    std::ofstream(folder / "list") << "x.png\t2018-01-29T11:09:20Z\r\n\ny.png\n z.png\tnoon\n";
    arguments.sun_from_image = true;
  }
  std::string in(const std::string& name) const { return (folder / name).string(); }
  // The files, relative to the folder where they are in it.
  std::vector<std::string> files_of(const std::vector<std::string>& images) {
    arguments.images = images;
    auto expanded = EstimateInputs::expand(arguments);
    EXPECT_TRUE(expanded) << expanded.error().message;
    if (!expanded) return {};
    problems = expanded->problems().lines();
    std::vector<std::string> files;
    inputs.clear();
    while (auto input = expanded->next()) {
      const auto name = input->file.string();
      files.push_back(name.starts_with(in("")) ? name.substr(in("").size()) : name);
      inputs.push_back(std::move(*input));
    }
    EXPECT_EQ(expanded->count(), files.size());
    return files;
  }

  const std::filesystem::path folder = test_folder("estimate-inputs");
  EstimateRequest arguments;
  std::vector<EstimateInput> inputs;
  std::vector<std::string> problems;
};

TEST_F(GivenInputs, AFolderGivesItsOwnPicturesByName) {
  EXPECT_THAT(files_of({in("sky")}), ElementsAre("sky/a.jpeg", "sky/b.JPG"));
  EXPECT_THAT(problems, IsEmpty());
}

TEST_F(GivenInputs, AreTakenInTheOrderGiven) {
  EXPECT_THAT(files_of({in("two[1].jpg"), "@" + in("list"), in("sky"), in("one.png")}),
              ElementsAre("two[1].jpg", "x.png", "y.png", " z.png", "sky/a.jpeg", "sky/b.JPG", "one.png"));
  EXPECT_THAT(problems, IsEmpty());
}

// Of 480 days with a picture each ten minutes: even steps would all meet the same hour.
TEST_F(GivenInputs, ASampleMeetsAllHoursAndSeasons) {
  constexpr std::size_t kPictures = 144 * 480, kSample = 480;
  std::ofstream list(folder / "long");
  for (std::size_t i = 0; i < kPictures; ++i) list << i << ".jpg\n";
  list.close();
  arguments.images = {"@" + in("long")};
  const auto expanded = EstimateInputs::expand(arguments);
  ASSERT_TRUE(expanded) << expanded.error().message;
  std::vector<int> hours(24), seasons(16);
  std::set<std::string> files;
  for (const auto& input : expanded->sample(kSample)) {
    const auto number = std::stoul(input.file.stem().string());
    ++hours[number % 144 / 6];
    ++seasons[number * seasons.size() / kPictures];
    files.insert(input.file.string());
  }
  EXPECT_EQ(files.size(), kSample);
  for (const int pictures : hours) EXPECT_GE(pictures, 10);
  for (const int pictures : seasons) EXPECT_GE(pictures, 25);
  EXPECT_EQ(expanded->sample(2 * kPictures).size(), kPictures);
}

TEST_F(GivenInputs, AListHasItsTimesAndItsWrongOnesAreTold) {
  files_of({"@" + in("list")});
  ASSERT_EQ(inputs.size(), 3u);
  EXPECT_EQ(inputs[0].utc, parse_utc("2018-01-29T11:09:20Z"));
  EXPECT_FALSE(inputs[1].utc);
  EXPECT_THAT(inputs[2].problem, HasSubstr("time 'noon'"));
}

TEST_F(GivenInputs, APatternMatchesUnlessAFileHasItsName) {
  EXPECT_THAT(files_of({in("*.png")}), ElementsAre("@at.png", "one.png"));
  EXPECT_THAT(files_of({in("two[1].jpg")}), ElementsAre("two[1].jpg"));
  EXPECT_THAT(files_of({in("s?y")}), ElementsAre("sky/a.jpeg", "sky/b.JPG"));
}

TEST_F(GivenInputs, WhatGivesNoPictureIsToldAndTheOthersStay) {
  EXPECT_THAT(files_of({in("none.png"), in("empty"), in("one.png"), in("*.tiff"), "@" + in("nolist"), "@/dev/null"}),
              ElementsAre("one.png"));
  EXPECT_THAT(problems, ElementsAre(in("none.png") + ": no such file or folder",
                                    in("empty") + ": a folder without any picture", in("*.tiff") + ": no file matches",
                                    HasSubstr("nolist"), "@/dev/null: an empty list, expected one path a line"));
}

TEST_F(GivenInputs, ARecordingHasItsOwnTimesCameraAndSite) {
  arguments.sun_from_image = false;
  const auto demo = source_folder() / "fixtures/demo";
  arguments.images = {demo.string()};
  auto expanded = must(EstimateInputs::expand(arguments));
  EXPECT_THAT(expanded->problems().lines(), IsEmpty());
  EXPECT_EQ(expanded->count(), 6u);
  expanded->next();
  const auto second = must(expanded->next());
  EXPECT_EQ(second->file, demo / "sky/frame-000001.jpg");
  EXPECT_EQ(second->utc, parse_utc("2026-10-20T06:10:05Z"));
  const auto& camera = expanded->cameras().at(second->camera);
  ASSERT_TRUE(camera.calibrated && camera.site);
  EXPECT_EQ(camera.calibrated->width, 480);
  EXPECT_EQ(camera.site->altitude_m, 980.0);

  // A calibration goes before the recording's own.
  arguments.calibration = (folder / "calibration.toml").string();
  auto text = read_text_file(demo / "fixture.toml").value();
  text.replace(text.find("980.0"), 5, "981.0");
  std::filesystem::copy_file(demo / "sky-mask.png", folder / "sky-mask.png");
  ASSERT_TRUE(write_text_file(arguments.calibration, text));
  auto calibrated = must(EstimateInputs::expand(arguments));
  EXPECT_EQ(calibrated->cameras().at(calibrated->next()->camera).site->altitude_m, 981.0);
}

TEST_F(GivenInputs, ARecordingThatIsBrokenIsToldAndTheOthersStay) {
  std::filesystem::create_directories(folder / "broken/sky");
  std::ofstream(folder / "broken/fixture.toml") << "format = 1\n";
  std::ofstream(folder / "broken/sky/index.csv") << kIndexHeader << "\n";
  EXPECT_THAT(files_of({in("broken"), in("one.png")}), ElementsAre("one.png"));
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_THAT(problems[0], HasSubstr(in("broken")));
}

TEST_F(GivenInputs, PicturesWithoutTimesTakeTheSunFromThemselves) {
  arguments.sun_from_image = false;
  arguments.lat = 46.94;
  arguments.lon = 8.28;
  arguments.images = {"@" + in("list"), in("sky")};
  EXPECT_TRUE(EstimateInputs::expand(arguments));
}

TEST_F(GivenInputs, AFirstLookTakesNothing) {
  arguments.images = {"@" + in("list"), in("sky")};
  auto expanded = must(EstimateInputs::expand(arguments));
  EXPECT_EQ(expanded->ahead(2).size(), 2u);
  const auto all = expanded->ahead(100);
  EXPECT_EQ(expanded->ahead(1).size(), 1u);
  EXPECT_EQ(expanded->all().size(), all.size());
  std::size_t taken = 0;
  for (; const auto input = expanded->next(); ++taken) EXPECT_EQ(input->file, all.at(taken).file);
  EXPECT_EQ(taken, all.size());
}

TEST_F(GivenInputs, TheCommandTellsAllThatIsMissingInOneMessageAndAnswersTheRest) {
  const auto frame = (source_folder() / "fixtures/demo/sky/frame-000000.jpg").string();
  const auto outcome = ended(
      2,
      run_kasumi(fmt::format(
          "estimate --json --calibration {}/fixtures/demo/fixture.toml --utc 2026-10-20T06:10:00Z {} {} {} '{}/*.gif'",
          source_folder().string(), in("none.png"), frame, in("empty"), folder.string())));
  EXPECT_EQ(outcome.err, fmt::format("kasumi: {}: no such file or folder\n{}: a folder without any picture\n{}/*.gif: "
                                     "no file matches\n",
                                     in("none.png"), in("empty"), folder.string()));
  EXPECT_EQ(parse_json(outcome.out)["image"], frame);
  const auto nothing = ended(2, run_kasumi("estimate --sun-from-image " + in("none.png") + " " + in("empty")));
  EXPECT_EQ(nothing.out, "");
  EXPECT_THAT(nothing.err, testing::AllOf(HasSubstr("none.png"), HasSubstr("without any picture")));
}

TEST_F(GivenInputs, OptionsForListsKeepTheirPlaceAndStandardInputComesInItsTurn) {
  std::ofstream(folder / "l1") << "l1.png\n";
  std::ofstream(folder / "l2") << "l2.png\n";
  const auto outcome =
      ended(2, run_kasumi(fmt::format("estimate --csv --sun-from-image --list {} {} - --list={} @{} </dev/null",
                                      in("l1"), in("one.png"), in("l2"), in("l1"))));
  std::vector<std::string> images;
  for (const auto& line : house::lines_of(outcome.out))
    if (!line.empty()) images.push_back(line.substr(0, line.find(',')));
  EXPECT_THAT(images, ElementsAre("image", "l1.png", in("one.png"), "l2.png", "l1.png"));
}

// The example that everybody tries first.
TEST(EstimateExample, OfTheBundledRecordingRunsAsDocumented) {
  const auto page = read_text_file(source_folder() / "docs/commands.md").value();
  const std::string example = "build/kasumi estimate fixtures/demo";
  std::vector<std::string> lines;
  for (const auto& code : house::code_in(page))
    if (code.block)
      for (const auto& line : house::command_lines_in(code)) lines.push_back(line);
  ASSERT_THAT(lines, testing::Contains(example));
  const auto outcome =
      run_kasumi(example.substr(example.find("estimate")), fmt::format("cd '{}' &&", source_folder().string()));
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "") << "progress where there is no terminal";
  for (int i = 0; i < 6; ++i) EXPECT_THAT(outcome.out, HasSubstr(fmt::format("fixtures/demo/sky/frame-{:06}.jpg", i)));
  EXPECT_THAT(outcome.out, HasSubstr("turbidity        2."));
  EXPECT_THAT(outcome.out, Not(HasSubstr("not usable")));
}

TEST(EstimateProgress, IsDrawnOnATerminalAlone) {
  const int terminal = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK);
  if (terminal < 0 || ::grantpt(terminal) != 0 || ::unlockpt(terminal) != 0)
    GTEST_SKIP() << "no pseudo-terminal here: progress not tested";
  const std::string name = ::ptsname(terminal);
  const int held = ::open(name.c_str(), O_RDWR | O_NOCTTY);  // what is written stays until it is read
  const auto command = fmt::format("printf 'a.png\\nb.png\\n' >{0}; {1} estimate --csv --sun-from-image @{0} 2>{2}",
                                   test_folder("progress-list").string(), kasumi_program().string(), name);
  FILE* pipe = ::popen(command.c_str(), "r");
  ASSERT_TRUE(pipe);
  std::string out;
  for (int c; (c = std::fgetc(pipe)) != EOF;) out += static_cast<char>(c);
  ::pclose(pipe);
  std::string shown(4096, '\0');
  const auto n = ::read(terminal, shown.data(), shown.size());
  shown.resize(n > 0 ? static_cast<std::size_t>(n) : 0);
  EXPECT_THAT(shown, HasSubstr("\r\033[Kestimate [###############...............] 1/2, "));
  EXPECT_THAT(shown, HasSubstr("left"));
  EXPECT_THAT(out, Not(HasSubstr("\033")));
  ::close(held);
  ::close(terminal);
}

}  // namespace
}  // namespace kasumi
