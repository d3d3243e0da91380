// The examples for job engines, on the engines that are installed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>

#include "base/utc_text.hpp"
#include "capture/codec/encode.hpp"
#include "tests/figures.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/run_kasumi.hpp"

namespace kasumi {
namespace {

class Engine : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    std::ofstream list(folder / "list");
    for (int i = 0; i < 60; ++i)
      list << fmt::format("{}/fixtures/demo/sky/frame-{:06}.jpg\t2026-10-20T06:{:02}:00Z\n", source_folder().string(),
                          i % 6, i);
  }
  static bool is_installed(const std::string& program) {
    return std::system(fmt::format("PATH=$PATH:/usr/sbin; command -v {} >/dev/null", program).c_str()) ==
           0;  // NOLINT: a shell
  }
  // With this program as `kasumi`. Its exit status.
  int run(const std::string& command) const {
    const auto line = fmt::format("cd {} && PATH={}:/usr/sbin:$PATH && {} >>out 2>&1", folder.string(),
                                  kasumi_program().parent_path().string(), command);
    return std::system(line.c_str());  // NOLINT: a shell
  }
  // With all that it started: its own session. Fails where it ends before.
  static std::string killed_after_8_pictures(const std::string& command) {
    return fmt::format(
        "(setsid {} & pid=$!; while kill -0 $pid && [ \"$(cat parts/*.jsonl | wc -l)\" -lt 8 ]; do sleep "
        ".02; done 2>/dev/null; pkill -9 -s $pid; wait $pid; test $? = 137)",
        command);
  }
  static std::string calibrated() {
    return fmt::format("--calibration {}/fixtures/demo/fixture.toml", source_folder().string());
  }
  // Small skies of a fisheye, each another, a picture each ten minutes: nights, clear days and clouds. Their list.
  void make_skies(int count) const {
    constexpr int kSide = 96;
    constexpr double kMiddle = 47.5, kRadius = 46.0;
    std::filesystem::create_directories(folder / "sky");
    std::ofstream list(folder / "list");
    for (int i = 0; i < count; ++i) {
      Image<Rgb8> sky(kSide, kSide);
      for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) {
          const double off = std::hypot(x - kMiddle, y - kMiddle) / kRadius;
          if (off >= 1.0) continue;
          const double light = 60.0 + 60.0 * off * off + i % 7, wave = std::sin(0.17 * x + i) * std::sin(0.13 * y - i);
          const double cloud = i % 3 == 0 ? std::clamp(2.0 * wave, 0.0, 1.0) : 0.0;
          const auto mixed = [&](double clear) {
            return static_cast<std::uint8_t>(std::lround((1.0 - cloud) * clear + cloud * 220.0));
          };
          sky.at(x, y) = {mixed(light), mixed(1.3 * light), mixed(1.7 * light)};
        }
      const auto file = fmt::format("sky/{:05}.jpg", i);
      const auto bytes = *must(encode_jpeg(sky, 90, ChromaSubsampling::s420));
      std::ofstream(folder / file, std::ios::binary)
          .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
      list << file << "\t" << utc_text(*parse_utc("2026-01-01T00:00:00Z") + std::chrono::minutes(10 * i)) << "\n";
    }
  }
  static std::string example(const char* name) { return (source_folder() / "examples/archive" / name).string(); }
  std::string text(const std::string& name) const {
    return read_text_file(folder / name).value_or("unreadable " + name);
  }
  void expect_whole(const std::string& options = calibrated()) const {
    ASSERT_EQ(run("kasumi estimate @list --shard 1/1 --out single.jsonl " + options), 0) << text("out");
    ASSERT_EQ(run("kasumi estimate --merge parts/*.jsonl --out all.jsonl"), 0) << text("out");
    EXPECT_EQ(text("all.jsonl"), text("single.jsonl"));
  }
  const std::filesystem::path folder = test_folder("archive-engines");
};

TEST_F(Engine, ParallelDoesAllShardsAndGoesOnAfterAKill) {
  if (!is_installed("parallel")) GTEST_SKIP() << "GNU parallel is not installed";
  const auto command = fmt::format("{} 5 list {}", example("parallel.sh"), calibrated());
  ASSERT_EQ(run(killed_after_8_pictures(command)), 0) << text("out");
  ASSERT_NE(run("kasumi estimate --merge parts/*.jsonl --out all.jsonl"), 0);
  ASSERT_EQ(run(command), 0) << text("out");
  expect_whole();
}

// Killed with all that it started, the same goes on: no part is made anew.
TEST_F(Engine, SnakemakeGoesOnAfterAKill) {
  if (!is_installed("snakemake")) GTEST_SKIP() << "snakemake is not installed";
  const auto snakemake = fmt::format(
      "XDG_CACHE_HOME=$PWD/cache snakemake --quiet --snakefile {} --cores 2 --config list=list shards=5 options='{}'",
      example("Snakefile"), calibrated());
  ASSERT_EQ(run(killed_after_8_pictures("sh -c \"" + snakemake + "\"")), 0) << text("out");
  ASSERT_EQ(run(fmt::format("({0} --unlock && {0} --rerun-incomplete)", snakemake)), 0) << text("out");
  EXPECT_THAT(text("out"), testing::ContainsRegex("[1-9][0-9]* are there already"));
  EXPECT_TRUE(std::filesystem::exists(folder / "archive.sqlite"));
  expect_whole();
}

// Of two workers one dies; its process ends with it, or the part would stay locked.
TEST_F(Engine, DaskGoesOnAfterAWorkersDeath) {
  if (!is_installed("dask-scheduler")) GTEST_SKIP() << "Dask is not installed: apt install python3-distributed";
  ASSERT_EQ(run(fmt::format("{}/tests/dask-on-loopback {} 5 list {}", source_folder().string(),
                            example("dask_shards.py"), calibrated())),
            0)
      << text("out");
  EXPECT_THAT(text("out"), testing::ContainsRegex("[1-9][0-9]* are there already"));
  expect_whole();
}

// munged, slurmctld and slurmd of this machine alone, over loopback. Whole: 40 shards of 20,000 pictures.
TEST_F(Engine, SlurmsArraySurvivesRequeueAndKill) {
  for (const char* program : {"munged", "slurmctld", "slurmd", "sbatch"})
    if (!is_installed(program))
      GTEST_SKIP() << program << " is not installed: apt install slurmctld slurmd slurm-client munge";
  if (::geteuid() != 0) GTEST_SKIP() << "slurmd runs tasks as root only";
  constexpr int kPictures = 20000;
  const int shards = whole_figures() ? 40 : 6;
  std::string options = calibrated();
  if (whole_figures()) {
    make_skies(kPictures);
    options = "--circle 47.5,47.5,46 --azimuth-up-deg 0 --lat 34.21 --lon 135.59 --altitude-m 980 --sky-model preetham";
  }
  const auto started = std::chrono::steady_clock::now();
  ASSERT_EQ(run(fmt::format("{}/tests/slurm-on-loopback {} {} list {}", source_folder().string(),
                            example("slurm.sbatch"), shards, options)),
            0)
      << text("out");
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - started;
  expect_whole(options);
  EXPECT_THAT(text("out"), testing::HasSubstr("slurm/1.log")) << "went on behind what was there";
  EXPECT_THAT(text("out"), testing::HasSubstr("slurm/2.log"));
  if (whole_figures()) std::printf("%d pictures in %d shards in %.0f s\n", kPictures, shards, took.count());
}

}  // namespace
}  // namespace kasumi
