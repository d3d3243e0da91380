// What a recorded run of `kasumi bench` tells about a later one.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "pipeline/lab/bench/recorded_run.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/run_kasumi.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::Field;
using testing::HasSubstr;
using testing::IsEmpty;

std::filesystem::path bench_folder() {
  const auto folder = test_folder("bench");
  std::filesystem::create_directories(folder);
  return folder;
}

RecordedRun run_of(double composite, double points_per_s, double memory_mib) {
  return {"1.0.0",
          "a processor",
          "a renderer",
          {{.name = "composite / blit", .value = composite, .goal = 1.2},
           {.name = "turbidity", .value = points_per_s, .unit = "M points/s", .goal = 2.0, .less_is_better = false},
           {.name = "model", .value = memory_mib, .unit = "MiB", .goal = {}}}};
}

std::vector<std::string> slower(const RecordedRun& before, const RecordedRun& now) {
  std::vector<std::string> names;
  for (const auto& row : compare_runs(before, now).slower) names.push_back(row.name);
  return names;
}

TEST(RecordedRun, NamesWhatCostsMoreThanATenthMore) {
  const RecordedRun before = run_of(1.0, 2.2, 30.0);
  EXPECT_THAT(slower(before, run_of(1.09, 2.01, 32.9)), IsEmpty());
  EXPECT_THAT(slower(before, run_of(1.11, 1.99, 33.1)), ElementsAre("composite / blit", "turbidity", "model"));
  EXPECT_THAT(slower(before, run_of(0.5, 4.0, 10.0)), IsEmpty());
  EXPECT_NEAR(compare_runs(before, run_of(1.0, 1.1, 30.0)).slower.at(0).growth(), 2.0, 1e-12);
}

TEST(RecordedRun, AValueThatIsNoNumberIsSlower) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(slower(run_of(1.0, 2.2, 30.0), run_of(nan, 2.2, 30.0)), ElementsAre("composite / blit"));
}

TEST(RecordedRun, TimesOfAnotherMachineAreNotCompared) {
  RecordedRun elsewhere = run_of(1.2, 1.0, 30.0);
  elsewhere.processor = "a slow processor";
  EXPECT_THAT(slower(run_of(1.0, 2.2, 30.0), elsewhere), ElementsAre("composite / blit"));
  EXPECT_FALSE(compare_runs(run_of(1.0, 2.2, 30.0), elsewhere).same_machine);
}

TEST(RecordedRun, ARatioThatGrewIsARegressionOnTheSameMachineAlone) {
  const RecordedRun before = run_of(1.0, 2.2, 30.0), grown = run_of(1.2, 2.2, 30.0);
  EXPECT_TRUE(compare_runs(before, grown).is_regression());
  EXPECT_FALSE(compare_runs(grown, before).is_regression());
  for (const auto part : {&RecordedRun::processor, &RecordedRun::renderer}) {
    RecordedRun elsewhere = grown;
    elsewhere.*part = "another";
    EXPECT_FALSE(compare_runs(before, elsewhere).is_regression());
  }
}

// A virtual machine's, and a Raspberry Pi's, which has no model name.
TEST(RecordedRun, NamesTheProcessorByAllThatTellsMachinesApart) {
  EXPECT_EQ(processor_of("processor\t: 0\nvendor_id\t: AuthenticAMD\ncpu family\t: 25\nmodel\t\t: 1\nmodel name\t: AMD "
                         "EPYC\nstepping\t: 1\ncpu MHz\t\t: 2445.406\nflags\t\t:\n\nprocessor\t: 1\nmodel\t\t: 2\n"),
            "2 x AMD EPYC, cpu family 25, model 1, stepping 1");
  EXPECT_EQ(processor_of("processor\t: 0\nBogoMIPS\t: 108.00\nCPU implementer\t: 0x41\nCPU part\t: 0xd0b\n"),
            "1 x CPU implementer 0x41, CPU part 0xd0b");
}

TEST(RecordedRun, RowsThatOnlyOneRunHasAreNamed) {
  RecordedRun before = run_of(1.0, 2.2, 30.0), now = before;
  before.rows.erase(before.rows.begin());
  now.rows.pop_back();
  const auto compared = compare_runs(before, now);
  EXPECT_THAT(compared.not_found, ElementsAre("composite / blit"));
  EXPECT_THAT(compared.gone, ElementsAre("model"));
}

TEST(RecordedRun, TheBetterOfTwoMeasurementsIsKept) {
  RecordedRun run = run_of(1.3, 2.0, 30.0);
  keep_better(run.rows, run_of(1.1, 1.9, 30.0).rows);
  EXPECT_EQ(run.rows[0].value, 1.1);
  EXPECT_EQ(run.rows[1].value, 2.0);
}

TEST(RecordedRun, IsReadAsItWasWritten) {
  const auto file = bench_folder() / "run.json";
  const RecordedRun run = run_of(1.25, 2.2, 30.0);
  ASSERT_TRUE(write_text_file(file, json_of(run)));
  const auto read = must(read_recorded_run(file));
  EXPECT_EQ(json_of(*read), json_of(run));
}

TEST(RecordedRun, TheOneInTheDocumentsCanBeComparedWith) {
  EXPECT_GT(must(read_recorded_run(source_folder() / "docs" / "bench.json"))->rows.size(), 50U);
}

TEST(RecordedRun, AllProblemsOfAFileAreNamed) {
  const auto file = bench_folder() / "bad.json";
  ASSERT_TRUE(write_text_file(
      file, R"({"kasumi": 1, "processor": "p", "renderer": "r", "rows": [7, {"name": "a", "unit": "x", "value": "1",
               "less_is_better": true, "goal": null}, {"name": "a", "unit": "x", "value": 1, "less_is_better": 1}]})"));
  const auto read = read_recorded_run(file);
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().kind, FaultKind::bad_input);
  EXPECT_THAT(read.error().message,
              AllOf(HasSubstr("bad.json: kasumi: expected text"), HasSubstr("row 1: expected an object"),
                    HasSubstr("row 2: value: expected a number"), HasSubstr("row 3: less_is_better: expected true"),
                    HasSubstr("row 3: name: expected one that no row before has")));
}

TEST(BenchCommand, TellsWhatGotSlower) {
  const auto file = bench_folder() / "air.json";
  ended(0, run_kasumi(fmt::format("bench --only air --json {}", file.string())));
  auto recorded = must(read_recorded_run(file));
  ASSERT_EQ(recorded->rows.size(), 2U);
  for (const double better : {1.0, 100.0}) {
    recorded->rows[1].value *= better;  // how many times slower the reference is
    ASSERT_TRUE(write_text_file(file, json_of(*recorded)));
    const auto second = run_kasumi(fmt::format("bench --only air --json - --against {}", file.string()));
    EXPECT_TRUE(nlohmann::json::accept(second.out)) << second.out;
    if (better == 1.0) continue;  // as quick as it was, or as busy as this machine is
    EXPECT_EQ(second.code, 1);
    EXPECT_THAT(second.err, HasSubstr("(measured twice): 1 nm reference / K = 2, on the CPU"));
  }
  recorded->processor = "another";
  ASSERT_TRUE(write_text_file(file, json_of(*recorded)));
  EXPECT_THAT(ended(0, run_kasumi(fmt::format("bench --only air --against {}", file.string()))).err,
              AllOf(HasSubstr("recorded on another machine (another; "),
                    HasSubstr("(measured twice): 1 nm reference / K = 2, on the CPU")));
}

TEST(BenchCommand, RefusesPartsAndFilesThatItDoesNotKnow) {
  EXPECT_EQ(run_kasumi("bench --only sea").code, 2);
  const auto missing = run_kasumi("bench --only air --against /nowhere/run.json");
  EXPECT_NE(missing.code, 0);
  EXPECT_THAT(missing.err, HasSubstr("/nowhere/run.json"));
}

}  // namespace
}  // namespace kasumi
