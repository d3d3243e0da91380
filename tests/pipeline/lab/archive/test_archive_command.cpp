// kasumi estimate --out, --shard, --resume and --merge, as a cluster's tasks run them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>

#include <glm/common.hpp>
#include <nlohmann/json.hpp>

#include "base/outside/json_text.hpp"
#include "calib/light/radiometry.hpp"
#include "pipeline/site/files/photograph_file.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/run_kasumi.hpp"
#include "tests/pipeline/site/files/packed.hpp"

namespace kasumi {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// Frames of the demo, each several times at other times, and one file that is no picture.
class ArchiveCommand : public testing::Test {
 protected:
  static constexpr int kPictures = 24;
  void SetUp() override {
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    std::ofstream(folder / "broken.png") << "no picture";
    std::ofstream list(folder / "list");
    for (int i = 0; i < kPictures; ++i)
      list << (i == 13 ? in("broken.png") : frame(i % 6))
           << fmt::format("\t2026-10-20T0{}:{:02}:00Z\n", 6 + i / 12, i % 12);
  }
  std::string in(const std::string& name) const { return (folder / name).string(); }
  static std::string frame(int number) {
    return fmt::format("{}/fixtures/demo/sky/frame-{:06}.jpg", source_folder().string(), number);
  }
  Outcome estimate(const std::string& arguments, const std::string& environment = "") const {
    return run_kasumi(
        fmt::format("estimate --calibration {}/fixtures/demo/fixture.toml {}", source_folder().string(), arguments),
        "env -u SLURM_ARRAY_TASK_ID -u SGE_TASK_ID -u JOB_COMPLETION_INDEX " + environment);
  }
  Outcome shard(const std::string& name, const std::string& more, const std::string& environment = "") const {
    return estimate(fmt::format("@{} --out {} {}", in("list"), in(name), more), environment);
  }
  std::string text(const std::string& name) const {
    return read_text_file(folder / name).value_or("unreadable " + name);
  }

  const std::filesystem::path folder = test_folder("archive-command");
};

TEST_F(ArchiveCommand, MergedShardsAreByteForByteTheSingleRun) {
  const auto single = shard("single.jsonl", "");
  ASSERT_EQ(single.code, 0) << single.err;
  EXPECT_EQ(single.out, "");
  EXPECT_THAT(single.err, HasSubstr("1 could not be read"));
  std::string parts;
  for (int i = 1; i <= 5; ++i) {
    const auto part = fmt::format("part-{}.jsonl", i);
    const auto outcome = shard(part, fmt::format("--shard {}/5 --jobs {}", i, i));
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    parts = in(part) + " " + parts;
  }
  for (const char* table : {"all.jsonl", "all.csv", "all.sqlite"}) {
    for (const auto& [of, from] : {std::pair{"one", in("single.jsonl")}, std::pair{"many", parts}}) {
      std::filesystem::create_directories(folder / of);
      const auto merged = run_kasumi(fmt::format("estimate --merge {} --out {}/{}", from, in(of), table));
      ASSERT_EQ(merged.code, 0) << merged.err;
      EXPECT_THAT(merged.out, HasSubstr("24 pictures"));
    }
    EXPECT_EQ(text(std::string("many/") + table), text(std::string("one/") + table));
  }
  EXPECT_EQ(text("many/summary.html"), text("one/summary.html"));
  EXPECT_EQ(text("many/all.jsonl"), text("single.jsonl"));
}

TEST_F(ArchiveCommand, ARecordIsTheAnswerOfJsonWithItsPlace) {
  ASSERT_EQ(shard("part.jsonl", "--shard 1/1").code, 0);
  const auto json = estimate(fmt::format("@{} --json", in("list")));
  std::istringstream records(text("part.jsonl")), answers(json.out);
  std::string record_line, answer_line;
  int number = 0, unread = 0;
  while (std::getline(records, record_line)) {
    auto record = parse_json(record_line);
    EXPECT_EQ(record["archive"]["picture"], ++number);
    EXPECT_EQ(record["archive"]["of"], kPictures);
    EXPECT_EQ(record["utc"], fmt::format("2026-10-20T0{}:{:02}:00Z", 6 + (number - 1) / 12, (number - 1) % 12));
    if (number == 14) {
      EXPECT_EQ(record["refused"], "could not be read");
      EXPECT_THAT(record["reason"].get<std::string>(), HasSubstr("broken.png"));
      ++unread;
      continue;
    }
    EXPECT_EQ(record["refused"].is_null(), record["usable"].get<bool>());
    for (const char* key : {"archive", "utc", "refused"}) record.erase(key);
    ASSERT_TRUE(std::getline(answers, answer_line));
    EXPECT_EQ(record, parse_json(answer_line));
  }
  EXPECT_EQ(number, kPictures);
  EXPECT_EQ(unread, 1);
}

TEST_F(ArchiveCommand, AKilledTaskGoesOnWhereItWas) {
  ASSERT_EQ(shard("whole.jsonl", "").code, 0);
  const auto command = fmt::format("{} estimate --calibration {}/fixtures/demo/fixture.toml @{} --out {} --jobs 1",
                                   kasumi_program().string(), source_folder().string(), in("list"), in("part.jsonl"));
  const auto killed = fmt::format(
      "{0} 2>/dev/null & pid=$!; while [ \"$(cat {1} 2>/dev/null | wc -l)\" -lt 5 ]; do sleep .01; done; kill -9 $pid; "
      "wait $pid; test $? = 137",
      command, in("part.jsonl"));
  ASSERT_EQ(std::system(killed.c_str()), 0);  // NOLINT: a shell
  const auto before = text("part.jsonl");
  EXPECT_LT(before.size(), text("whole.jsonl").size());
  std::ofstream(folder / "part.jsonl", std::ios::app | std::ios::binary) << R"({"image":"to)";
  EXPECT_EQ(shard("part.jsonl", "").code, 2);  // not without --resume
  const auto resumed = shard("part.jsonl", "--resume");
  ASSERT_EQ(resumed.code, 0) << resumed.err;
  EXPECT_THAT(resumed.err, AllOf(HasSubstr("are there already"), HasSubstr("torn record of 12 bytes")));
  EXPECT_EQ(text("part.jsonl"), text("whole.jsonl"));
  const auto again = shard("part.jsonl", "--resume");
  ASSERT_EQ(again.code, 0);
  EXPECT_THAT(again.err, HasSubstr("0 more pictures"));
  EXPECT_EQ(text("part.jsonl"), text("whole.jsonl"));
}

TEST_F(ArchiveCommand, TheArraysVariablesChooseTheShard) {
  ASSERT_EQ(shard("given.jsonl", "--shard 3/12").code, 0);
  const std::vector<std::string> engines{"SLURM_ARRAY_TASK_ID=9 SLURM_ARRAY_TASK_COUNT=12 SLURM_ARRAY_TASK_MIN=7",
                                         "JOB_COMPLETION_INDEX=2 JOB_COMPLETIONS=12",
                                         "SGE_TASK_ID=3 SGE_TASK_FIRST=1 SGE_TASK_LAST=12 SGE_TASK_STEPSIZE=1"};
  for (const auto& engine : engines) {
    std::filesystem::remove(folder / "part.jsonl");
    const auto outcome = shard("part.jsonl", "", engine);
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_THAT(outcome.err, AllOf(HasSubstr("shard 3/12 by"), HasSubstr("pictures 5 to 6 of 24")));
    EXPECT_EQ(text("part.jsonl"), text("given.jsonl")) << engine;
  }
  const auto half = shard("half.jsonl", "", "SLURM_ARRAY_TASK_ID=9 SLURM_ARRAY_TASK_MIN=7");
  EXPECT_EQ(half.code, 2);
  EXPECT_THAT(half.err, HasSubstr("SLURM_ARRAY_TASK_COUNT"));
  EXPECT_FALSE(std::filesystem::exists(folder / "half.jsonl"));
}

// A task array's variables have no say where a call asks for no part.
TEST_F(ArchiveCommand, WithoutOutTheArrayChangesNothing) {
  const auto plain = estimate(frame(0) + " " + frame(1) + " --json");
  const auto task = estimate(frame(0) + " " + frame(1) + " --json", "SLURM_ARRAY_TASK_ID=9");
  EXPECT_EQ(task.code, plain.code) << task.err;
  EXPECT_EQ(task.out, plain.out);
  EXPECT_EQ(std::ranges::count(task.out, '\n'), 2);
}

TEST_F(ArchiveCommand, OtherOptionsAndOtherListsAreRefused) {
  ASSERT_EQ(shard("part.jsonl", "--shard 1/4").code, 0);
  EXPECT_THAT(shard("part.jsonl", "--shard 1/4 --resume --samples 900").err, HasSubstr("other options"));
  EXPECT_THAT(shard("part.jsonl", "--shard 2/4 --resume").err, HasSubstr("another shard"));
  std::ofstream(folder / "list", std::ios::app) << frame(0) << "\n";
  EXPECT_THAT(shard("part.jsonl", "--shard 1/4 --resume").err, HasSubstr("another list"));
  ASSERT_EQ(shard("later.jsonl", "--shard 1/1").code, 0);
  const auto merged =
      run_kasumi(fmt::format("estimate --merge {} {} --out {}", in("part.jsonl"), in("later.jsonl"), in("all.csv")));
  EXPECT_EQ(merged.code, 2);
  EXPECT_THAT(merged.err, HasSubstr("another list"));
  EXPECT_FALSE(std::filesystem::exists(folder / "all.csv"));
}

TEST_F(ArchiveCommand, AListThatIsNotWholeIsNotBegun) {
  const auto outcome = shard("part.jsonl", in("none.jpg"));
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("none.jpg"));
  EXPECT_FALSE(std::filesystem::exists(folder / "part.jsonl"));
}

TEST_F(ArchiveCommand, TimesAreInNamesOfFilesAndFolders) {
  std::filesystem::create_directories(folder / "sky/2026/10/20");
  std::filesystem::copy_file(frame(0), folder / "sky/2026/10/20/1510.jpg");
  std::filesystem::copy_file(frame(0), folder / "sky/2026/10/20/other.jpg");
  const auto outcome = estimate(fmt::format("'{}' --time-format %Y/%m/%d/%H%M --utc-offset-h 9 --out {}",
                                            in("sky/*/*/*/*.jpg"), in("part.jsonl")));
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  std::istringstream lines(text("part.jsonl"));
  std::string first, second;
  std::getline(lines, first);
  std::getline(lines, second);
  EXPECT_EQ(parse_json(first)["utc"], "2026-10-20T06:10:00Z");
  EXPECT_THAT(parse_json(second)["reason"].get<std::string>(), HasSubstr("no time like %Y/%m/%d/%H%M"));
}

// Of a camera that nobody calibrated each shard must know the same.
TEST_F(ArchiveCommand, ALearntCameraIsTheSameForAllShards) {
  const auto plain = fmt::format("@{} --lat 46.94 --lon 8.28", in("list"));
  const auto learned = run_kasumi(fmt::format("estimate {} --learn-camera {}", plain, in("camera.toml")));
  ASSERT_EQ(learned.code, 0) << learned.err;
  const auto camera = text("camera.toml");
  EXPECT_THAT(camera, HasSubstr("[[cameras]]"));
  const auto run = [&](const std::string& name, const std::string& shard) {
    const auto outcome = run_kasumi(
        fmt::format("estimate {} --camera-memory {} --out {} --shard {}", plain, in("camera.toml"), in(name), shard));
    EXPECT_EQ(outcome.code, 0) << outcome.err;
  };
  run("all.jsonl", "1/1");
  run("a.jsonl", "1/2");
  run("b.jsonl", "2/2");
  EXPECT_EQ(text("a.jsonl") + text("b.jsonl"), text("all.jsonl"));
  EXPECT_EQ(text("camera.toml"), camera);
}

// The same pictures by themselves and inside of a tar and a zip file: the same answers, shards and all.
TEST_F(ArchiveCommand, PicturesOfATarFileAnswerAsTheyDoUnpacked) {
  std::filesystem::create_directories(folder / "day");
  std::vector<std::pair<std::string, std::string>> first, second;
  for (int i = 0; i < 6; ++i) {
    const auto name = fmt::format("day/20261020_06{:02}.jpg", i);
    (i < 4 ? first : second).emplace_back(name, read_text_file(frame(i)).value());
    std::filesystem::copy_file(frame(i), folder / name);
  }
  second.emplace_back("day/readme.txt", "no picture");
  second.emplace_back("day/20261020_0606.jpg", "broken");
  std::ofstream(folder / "day/20261020_0606.jpg") << "broken";
  pack(folder / "1.tar", first);
  pack(folder / "2.zip", second);
  const auto packed = fmt::format("{} {} --time-format auto", in("1.tar"), in("2.zip"));
  ASSERT_EQ(estimate(packed + " --out " + in("whole.jsonl")).code, 0);
  ASSERT_EQ(estimate(fmt::format("{} --time-format auto --out {}", in("day"), in("files.jsonl"))).code, 0);
  for (int i = 1; i <= 3; ++i)
    ASSERT_EQ(estimate(fmt::format("{} --shard {}/3 --out {}", packed, i, in(fmt::format("p{}.jsonl", i)))).code, 0);
  // A torn part goes on inside of the archive.
  std::filesystem::resize_file(folder / "p2.jsonl", std::filesystem::file_size(folder / "p2.jsonl") - 10);
  ASSERT_EQ(estimate(packed + " --shard 2/3 --resume --out " + in("p2.jsonl")).code, 0);
  const auto merged = run_kasumi(fmt::format("estimate --merge {} {} {} --out {}", in("p1.jsonl"), in("p2.jsonl"),
                                             in("p3.jsonl"), in("all.jsonl")));
  ASSERT_EQ(merged.code, 0) << merged.err;
  EXPECT_EQ(text("all.jsonl"), text("whole.jsonl"));
  std::istringstream of_files(text("files.jsonl")), of_members(text("whole.jsonl"));
  std::string file, member;
  int lines = 0;
  while (std::getline(of_files, file) && std::getline(of_members, member)) {
    auto one = parse_json(file), other = parse_json(member);
    EXPECT_EQ(other["image"],
              (lines < 4 ? in("1.tar:") : in("2.zip:")) + fmt::format("day/20261020_06{:02}.jpg", lines));
    for (auto* record : {&one, &other}) {
      record->erase("image");
      record->erase("archive");
      if (lines == 6) record->erase("reason");  // names it
    }
    EXPECT_EQ(one, other);
    ++lines;
  }
  EXPECT_EQ(lines, 7);
  const auto single = run_kasumi(fmt::format("estimate {}:day/20261020_0600.jpg --sun-from-image --json", in("1.tar")));
  EXPECT_THAT(single.out, HasSubstr("1.tar:day/20261020_0600.jpg"));
}

TEST_F(ArchiveCommand, ListsComeOnStandardInput) {
  const auto outcome =
      run_kasumi(fmt::format("estimate --list - --json --calibration {}/fixtures/demo/fixture.toml < {}",
                             source_folder().string(), in("list")));
  EXPECT_EQ(std::ranges::count(outcome.out, '\n'), kPictures - 1) << outcome.err;
}

// The camera was turned between two of its pictures.
TEST_F(ArchiveCommand, EachTimeHasItsCamera) {
  const auto demo = source_folder() / "fixtures/demo", old_camera = demo / "fixture.toml";
  std::ofstream(folder / "list") << frame(0) << "\t2026-10-20T06:10:00Z\n"
                                 << frame(0) << "\t2026-10-21T06:10:00Z\n"
                                 << frame(0) << "\t2026-10-22T00:00:00Z\n"
                                 << frame(0) << "\n";
  auto turned = read_text_file(old_camera).value();
  const std::string up = "azimuth_up_deg = 18.0";
  ASSERT_NE(turned.find(up), std::string::npos);
  std::ofstream(folder / "new.toml") << turned.replace(turned.find(up), up.size(), "azimuth_up_deg = 108.0");
  std::filesystem::copy_file(demo / "sky-mask.png", folder / "sky-mask.png");
  const auto ask = [&](const std::string& cameras) {
    return run_kasumi(fmt::format("estimate @{} {} --json", in("list"), cameras));
  };
  const auto outcome = ask(
      fmt::format("--camera 2026-10-21..2026-10-22={} --camera ..2026-10-21={}", in("new.toml"), old_camera.string()));
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("no --camera is of 2026-10-22T00:00:00Z"),
                                 HasSubstr("no time, by which its --camera is known")));
  ASSERT_EQ(std::ranges::count(outcome.out, '\n'), 2) << outcome.err;
  const auto end = outcome.out.find('\n') + 1;
  const auto alone = [&](const std::filesystem::path& camera, const char* utc) {
    return run_kasumi(fmt::format("estimate {} --utc {} --calibration {} --json", frame(0), utc, camera.string())).out;
  };
  const auto before = outcome.out.substr(0, end), after = outcome.out.substr(end);
  EXPECT_EQ(before, alone(old_camera, "2026-10-20T06:10:00Z"));
  EXPECT_EQ(after, alone(folder / "new.toml", "2026-10-21T06:10:00Z"));
  EXPECT_NE(after, alone(old_camera, "2026-10-21T06:10:00Z"));
  EXPECT_THAT(ask("--camera ..2026-10-21=/nowhere.toml").err, HasSubstr("--camera /nowhere.toml: "));
  EXPECT_THAT(ask(fmt::format("--camera ..2026-10-21={0} --calibration {0}", old_camera.string())).err,
              HasSubstr("expected neither --calibration"));
}

// Three exposures of one sky within seconds, of which the short and the long one tell nothing by themselves, and three
// alike, which are a series: each by itself.
TEST_F(ArchiveCommand, ExposuresOfOneSkyAreOnePicture) {
  const auto demo = must(read_photograph(frame(0)));
  const auto srgb = Response::srgb();
  std::ofstream list(folder / "list");
  int second = 0;
  for (const double exposure : {0.2, 1.0, 4.0}) {
    auto exposed = *demo;
    for (auto& value : exposed.encoded.elements())
      value = glm::vec3(
          glm::clamp(srgb.to_encoded(exposure * srgb.to_light(glm::dvec3(value))), glm::dvec3(0.0), glm::dvec3(1.0)));
    must(write_photograph(folder / fmt::format("{}.png", exposure), exposed));
    list << in(fmt::format("{}.png", exposure)) << fmt::format("\t2026-10-20T06:10:{:02}Z\n", ++second);
  }
  for (int i = 0; i < 3; ++i) list << frame(i) << fmt::format("\t2026-10-20T06:20:{:02}Z\n", ++second);
  list.close();
  ASSERT_EQ(shard("all.jsonl", "--shard 1/1").code, 0);
  std::vector<nlohmann::json> records;
  std::istringstream lines(text("all.jsonl"));
  for (std::string line; std::getline(lines, line);) records.push_back(parse_json(line));
  ASSERT_EQ(records.size(), 6u);
  const auto alone = parse_json(estimate(frame(0) + " --utc 2026-10-20T06:10:00Z --json").out);
  EXPECT_NEAR(records[0]["aod_550"].get<double>(), alone["aod_550"].get<double>(),
              alone["sigma_aod_550"].get<double>() / 3.0);
  ASSERT_EQ(records[0]["stack"]["images"].size(), 3u);
  EXPECT_NEAR(records[0]["stack"]["exposure_ratios"][1].get<double>(), 5.0, 0.3);
  EXPECT_NEAR(records[0]["stack"]["exposure_ratios"][2].get<double>(), 20.0, 1.5);
  for (const int i : {1, 2}) {
    EXPECT_EQ(records[i]["refused"], "exposure of a stack");
    EXPECT_EQ(records[i]["stack_of"], in("0.2.png"));
  }
  for (const int i : {3, 4, 5}) {
    EXPECT_TRUE(records[i]["refused"].is_null());
    EXPECT_TRUE(records[i]["stack"].is_null());
  }
  for (const char* exposure : {"0.2", "4"}) {
    const auto answer = estimate(fmt::format("{} --utc 2026-10-20T06:10:00Z --json", in(exposure) + ".png"));
    EXPECT_FALSE(parse_json(answer.out)["usable"]) << exposure;
  }
  // Shards that cut the stack.
  std::string parts;
  for (int i = 1; i <= 6; ++i) {
    ASSERT_EQ(shard(fmt::format("{}.jsonl", i), fmt::format("--shard {}/6", i)).code, 0);
    parts += text(fmt::format("{}.jsonl", i));
  }
  EXPECT_EQ(parts, text("all.jsonl"));
  const auto merged = run_kasumi(fmt::format("estimate --merge {} --out {}", in("all.jsonl"), in("all.csv")));
  ASSERT_EQ(merged.code, 0) << merged.err;
  EXPECT_THAT(text("summary.html"), HasSubstr("2 are exposures of stacks"));
}

// A folder of FITS files as INDI writes them: time and place are theirs, and another place than the one given is told.
TEST_F(ArchiveCommand, TimeAndPlaceMayBeTheFiles) {
  const auto demo = must(read_photograph(frame(0)));
  const auto& picture = demo->encoded;
  const auto card = [](const std::string& text) { return text + std::string(80 - text.size(), ' '); };
  const auto in_blocks = [](std::string text, char with) {
    text.resize((text.size() + 2879) / 2880 * 2880, with);
    return text;
  };
  std::string header;
  for (const auto& line :
       {std::string("SIMPLE  =                    T"), std::string("BITPIX  =                    8"),
        std::string("NAXIS   =                    3"), fmt::format("NAXIS1  = {:>20}", picture.width()),
        fmt::format("NAXIS2  = {:>20}", picture.height()), std::string("NAXIS3  =                    3"),
        std::string("ROWORDER= 'TOP-DOWN'"), std::string("SITELAT =            34.210000 / Latitude in degrees"),
        std::string("SITELONG=           135.590000 / Longitude in degrees"),
        std::string("SITEELEV=                  980"),
        std::string("DATE-OBS= '2026-10-20T06:10:00.000' / UTC start date of observation"), std::string("END")})
    header += card(line);
  std::string samples;
  for (const int colour : {0, 1, 2})
    for (const auto& value : picture.elements())
      samples += static_cast<char>(std::lround(255.0 * Response::srgb().to_light(glm::dvec3(value))[colour]));
  std::ofstream(folder / "sky.fits", std::ios::binary) << in_blocks(header, ' ') + in_blocks(samples, '\0');
  const std::string options = " --json --circle 241.42,238.06,237 --fov-deg 184 --azimuth-up-deg 18";
  const auto by_file = run_kasumi("estimate " + in("sky.fits") + options);
  ASSERT_EQ(by_file.code, 0) << by_file.err;
  const auto given = run_kasumi("estimate " + in("sky.fits") + options +
                                " --lat 34.21 --lon 135.59 --altitude-m 980 --utc 2026-10-20T06:10:00Z");
  auto one = parse_json(by_file.out), other = parse_json(given.out);
  EXPECT_EQ(one["taken"]["by"], "FITS header");
  EXPECT_EQ(one["taken"]["utc"], "2026-10-20T06:10:00Z");
  EXPECT_EQ(one["taken"]["altitude_m"], 980.0);
  EXPECT_TRUE(one["taken"]["time_used"].get<bool>() && one["taken"]["place_used"].get<bool>());
  EXPECT_FALSE(other["taken"]["time_used"].get<bool>() || other["taken"]["place_used"].get<bool>());
  EXPECT_TRUE(other["taken"]["off_km"].is_null());
  for (auto* answer : {&one, &other}) answer->erase("taken");
  EXPECT_EQ(one, other);
  const auto elsewhere = run_kasumi("estimate " + in("sky.fits") + options + " --lat 36.21 --lon 135.59");
  EXPECT_THAT(elsewhere.err, HasSubstr("of another place than the one given, which is followed: "));
  EXPECT_NEAR(parse_json(elsewhere.out)["taken"]["off_km"].get<double>(), 222.4, 0.5);
  ASSERT_EQ(run_kasumi("estimate " + in("sky.fits") + " --shard 1/1 --out " + in("part.jsonl")).code, 0);
  EXPECT_EQ(parse_json(text("part.jsonl"))["utc"], "2026-10-20T06:10:00Z");
}

}  // namespace
}  // namespace kasumi
