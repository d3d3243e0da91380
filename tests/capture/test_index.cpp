#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/utc_text.hpp"
#include "recording.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;
using testing::Not;

std::string message_of(std::string_view row) {
  const auto rows = read_index(folder_with_index("index", std::string(row) + "\n"));
  return rows ? std::string("accepted") : rows.error().message;
}

TEST(Index, ARowIsReadColumnByColumn) {
  const auto rows = read_index(
      folder_with_index("index",
                        "# a comment\n\n1000,2026-06-21T03:00:00.000000001Z,7,YUYV,2,2,4,8,0.004,1.5,error,a.yuyv\r\n"
                        "2000,2026-06-21T03:00:01Z,,,,,,,,,disconnected,\n"));
  ASSERT_TRUE(rows) << rows.error().message;
  ASSERT_EQ(rows->size(), 2u);
  const auto& [line, metadata, disconnected, payload] = rows->front();
  EXPECT_EQ(line, 4);
  EXPECT_EQ(metadata.captured_at, Instant{1000ns});
  EXPECT_EQ(metadata.utc, std::chrono::sys_days{std::chrono::June / 21 / 2026} + 3h + 1ns);
  EXPECT_EQ(metadata.sequence, 7u);
  EXPECT_EQ(metadata.format, four_cc("YUYV"));
  EXPECT_EQ(metadata.width, 2);
  EXPECT_EQ(metadata.height, 2);
  EXPECT_EQ(metadata.stride, 4u);
  EXPECT_EQ(metadata.bytes_used, 8u);
  EXPECT_EQ(metadata.exposure_s, 0.004);
  EXPECT_EQ(metadata.gain, 1.5);
  EXPECT_EQ(metadata.status, FrameStatus::flagged);
  EXPECT_FALSE(disconnected);
  EXPECT_EQ(payload, "a.yuyv");
  EXPECT_TRUE(rows->back().disconnected);
}

TEST(Index, EachWrongValueIsNamedWithLineColumnAndWhatIsExpected) {
  const std::string path = (fresh_folder("index") / "index.csv").string();
  EXPECT_EQ(message_of("x,2026-06-21T03:00:00Z,7,YUYV,2,2,4,8,,,,a.yuyv"),
            path + ":2: monotonic_ns = \"x\": expected a whole number from 0 to 2305843009213693952");
  EXPECT_THAT(message_of("0,21.6.2026,7,YUYV,2,2,4,8,,,,a.yuyv"), HasSubstr("utc = \"21.6.2026\": expected a time"));
  EXPECT_THAT(message_of("0,2026-06-21T03:00:00Z,-1,YUYV,2,2,4,8,,,,a.yuyv"), HasSubstr("sequence = \"-1\""));
  EXPECT_THAT(message_of("0,2026-06-21T03:00:00Z,7,H264,2,2,4,8,,,,a.yuyv"), HasSubstr("fourcc = \"H264\""));
  EXPECT_THAT(message_of("0,2026-06-21T03:00:00Z,7,YUYV,2147483648,2,4,8,,,,a.yuyv"), HasSubstr("width = "));
  EXPECT_THAT(message_of("0,2026-06-21T03:00:00Z,7,YUYV,2,99999999999999999999,4,8,,,,a.yuyv"), HasSubstr("height = "));
  EXPECT_THAT(message_of("0,2026-06-21T03:00:00Z,7,YUYV,0,2,4,8,,,,a.yuyv"), HasSubstr("size 0x2"));
  EXPECT_THAT(message_of("0,2026-06-21T03:00:00Z,7,YUYV,16384,16384,32768,8,,,,a.yuyv"), HasSubstr("size 16384x16384"));
  EXPECT_THAT(message_of("0,2026-06-21T03:00:00Z,7,YUYV,2,2,3,8,,,,a.yuyv"),
              HasSubstr("stride 3: expected at least 4"));
  EXPECT_THAT(message_of("0,2026-06-21T03:00:00Z,7,YUYV,2,2,4,4294967295,,,,a.yuyv"), HasSubstr("bytes_used = "));
  EXPECT_THAT(message_of("0,2026-06-21T03:00:00Z,7,YUYV,2,2,4,8,nan,,,a.yuyv"), HasSubstr("exposure_s = \"nan\""));
  EXPECT_THAT(message_of("0,2026-06-21T03:00:00Z,7,YUYV,2,2,4,8,,-1,,a.yuyv"), HasSubstr("gain = \"-1\""));
  EXPECT_THAT(message_of("0,2026-06-21T03:00:00Z,7,YUYV,2,2,4,8,,,broken,a.yuyv"), HasSubstr("flags = \"broken\""));
  EXPECT_THAT(message_of("0,2026-06-21T03:00:00Z,7,YUYV,2,2,4,8,,,a.yuyv"), HasSubstr("11 columns: expected 12"));
  EXPECT_THAT(message_of("0,2026-06-21T03:00:00Z,7,YUYV,2,2,4,8,,,,a.yuyv,"), HasSubstr("13 columns: expected 12"));
}

TEST(Index, PayloadsAreFilesBesideTheIndexAndNothingElse) {
  const auto row = [](std::string_view payload) {
    return message_of("0,2026-06-21T03:00:00Z,7,YUYV,2,2,4,8,,,," + std::string(payload));
  };
  EXPECT_EQ(row("a.yuyv"), "accepted");
  EXPECT_EQ(row(""), "accepted") << "an empty frame";
  EXPECT_THAT(row("missing.yuyv"), HasSubstr("expected an existing file beside the index"));
  for (const char* name : {"../index/a.yuyv", "/etc/passwd", "..", ".", "sub/a.yuyv", "..\\a.yuyv"})
    EXPECT_THAT(row(name), HasSubstr("without a folder")) << name;

  const auto folder = folder_with_index("index_link", "0,2026-06-21T03:00:00Z,7,YUYV,2,2,4,8,,,,link.yuyv\n");
  std::filesystem::create_symlink("/etc/passwd", folder / "link.yuyv");
  EXPECT_FALSE(read_index(folder)) << "a link leads out of the folder as well";
}

TEST(Index, AllProblemsComeAtOnceButNotWithoutEnd) {
  const auto two = message_of("x,y,7,YUYV,2,2,4,8,,,,a.yuyv\n0,2026-06-21T03:00:00Z,7,YUYV,2,2,4,8,,,,b.yuyv");
  EXPECT_THAT(two, HasSubstr(":2: monotonic_ns"));
  EXPECT_THAT(two, HasSubstr(":2: utc"));
  EXPECT_THAT(two, HasSubstr(":3: payload"));
  std::string many;
  for (int i = 0; i < 1000; ++i) many += "nonsense\n";
  EXPECT_EQ(std::ranges::count(message_of(many), '\n'), 19);
}

TEST(Index, ATimestampThatWouldTakeYearsToPlayIsRefused) {
  EXPECT_THAT(message_of("0,2026-06-21T03:00:00Z,7,YUYV,2,2,4,8,,,,a.yuyv\n"
                         "90000000000000000,2026-06-21T03:00:00Z,8,YUYV,2,2,4,8,,,,a.yuyv"),
              HasSubstr(":3: monotonic_ns = \"90000000000000000\": expected at most 366 days from the first row's 0"));
}

TEST(Index, AForeignFileIsRefusedByItsHeader) {
  const auto folder = fresh_folder("index");
  ASSERT_TRUE(write_text_file(folder / "index.csv", "time,temperature\n1,2\n"));
  EXPECT_THAT(read_index(folder).error().message, HasSubstr(":1: \"time,temperature\": expected the header"));
  std::filesystem::remove(folder / "index.csv");
  EXPECT_THAT(read_index(folder).error().message, HasSubstr("there is no such file"));
}

TEST(Index, ARowWrittenIsTheRowRead) {
  const auto folder = folder_with_index("index", "");
  IndexRow row;
  row.metadata = frame_at(1234567890123456789ns, 0xFFFFFFFF).metadata;
  row.metadata.exposure_s = 1.0 / 3.0;
  row.metadata.gain = 1e-7;
  row.payload = "a.yuyv";
  ASSERT_TRUE(write_text_file(folder / "index.csv", std::string(kIndexHeader) + "\n" + index_line(row) + "\n"));
  const auto rows = read_index(folder);
  ASSERT_TRUE(rows) << rows.error().message;
  EXPECT_EQ(rows->front().metadata.exposure_s, 1.0 / 3.0);
  EXPECT_EQ(rows->front().metadata.gain, 1e-7);
  EXPECT_EQ(rows->front().metadata.captured_at, row.metadata.captured_at);
  EXPECT_EQ(rows->front().metadata.utc, row.metadata.utc);
  EXPECT_EQ(rows->front().metadata.sequence, 0xFFFFFFFFu);
}

TEST(UtcText, IsIso8601WithAsManyDecimalsAsItTakes) {
  const Utc day = std::chrono::sys_days{std::chrono::February / 29 / 2028};
  EXPECT_EQ(utc_text(day + 23h + 59min + 59s), "2028-02-29T23:59:59Z");
  EXPECT_EQ(utc_text(day + 40ms), "2028-02-29T00:00:00.040Z");
  EXPECT_EQ(utc_text(day + 1us), "2028-02-29T00:00:00.000001Z");
  EXPECT_EQ(utc_text(day + 1ns), "2028-02-29T00:00:00.000000001Z");
  EXPECT_EQ(parse_utc("2028-02-29T00:00:00.04Z"), day + 40ms);
  for (const Utc utc : {Utc{}, day + 123456789ns, Utc{} - 0ns}) EXPECT_EQ(parse_utc(utc_text(utc)), utc);
}

TEST(UtcText, AnythingElseIsRefused) {
  for (const char* text :
       {"", "Z", "2026-06-21T03:00:00", "2026-06-21 03:00:00Z", "2026-02-29T03:00:00Z", "2026-06-21T24:00:00Z",
        "2026-06-21T03:60:00Z", "2026-06-21T03:00:60Z", "2026-06-21T03:00:00.Z", "2026-06-21T03:00:00.1234567890Z",
        "2026-06-21T03:00:00.1 Z", "2262-06-21T03:00:00Z", "1969-06-21T03:00:00Z", "2026-06-21T03:00:00+00:00",
        "2026-06-21T03:00:00,5Z", "-026-06-21T03:00:00Z", "2026-6-021T03:00:00Z"})
    EXPECT_FALSE(parse_utc(text)) << text;
}

TEST(FixtureInfo, IsReadFromTheHeadOfTheFile) {
  const auto root = ConfigTable::parse(R"(format = 1
name = "clear-noon"
licence = "CC0-1.0"
provenance = "by hand"
start_utc = 2026-06-21T03:00:00Z
)",
                                       "fixture.toml");
  const auto info = read_fixture_info(*root);
  EXPECT_TRUE(root->finish());
  EXPECT_EQ(info.name, "clear-noon");
  EXPECT_EQ(info.licence, "CC0-1.0");
  EXPECT_EQ(info.provenance, "by hand");
  EXPECT_EQ(info.start_utc, parse_utc("2026-06-21T03:00:00Z"));
}

TEST(FixtureInfo, AnotherFormatAndMissingKeysAreNamedAllAtOnce) {
  const auto root = ConfigTable::parse("format = 2\nname = 3\n", "fixture.toml");
  (void)read_fixture_info(*root);
  const auto message = root->finish().error().message;
  EXPECT_THAT(message, HasSubstr("format = 2: expected 1, the format this program knows"));
  EXPECT_THAT(message, HasSubstr("name = 3"));
  EXPECT_THAT(message, HasSubstr("licence is missing"));
  EXPECT_THAT(message, HasSubstr("provenance is missing"));
  EXPECT_THAT(message, HasSubstr("start_utc is missing"));

  const auto without = ConfigTable::parse("name = \"x\"\n", "fixture.toml");
  (void)read_fixture_info(*without);
  EXPECT_THAT(without->finish().error().message, HasSubstr("format is missing: expected 1"));
}

}  // namespace
}  // namespace kasumi
