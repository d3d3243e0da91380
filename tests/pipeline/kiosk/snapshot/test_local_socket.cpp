// The socket between appliance and `kasumi snapshot`: deadlines, and answers that are not ours.
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/socket/local_socket.hpp"
#include "pipeline/kiosk/snapshot/snapshot.hpp"
#include "tests/must.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

std::filesystem::path socket_path(const std::string& name) {
  const auto folder = test_output_folder();
  std::filesystem::create_directories(folder);
  return folder / (name + ".sock");
}

TEST(LocalSocket, NobodyThereIsToldApartFromNotAllowed) {
  const auto path = socket_path("nobody");
  std::filesystem::remove(path);
  EXPECT_EQ(connect_to(path).error().kind, FaultKind::disconnected);
  { ASSERT_TRUE(listen_at(path)); }
  EXPECT_EQ(connect_to(path).error().kind, FaultKind::disconnected) << "an earlier process left it there";
  EXPECT_TRUE(listen_at(path)) << "and the next takes its place";
  EXPECT_EQ(connect_to(socket_path(std::string(200, 'x'))).error().kind, FaultKind::io);
}

TEST(LocalSocket, AFolderMayBeDeeperThanTheKernelsAddress) {
  const auto folder = test_output_folder() / std::string(60, 'd') / std::string(60, 'e');
  std::filesystem::create_directories(folder);
  const auto path = folder / "deep.sock";
  ASSERT_GT(path.string().size(), 107U);
  {
    const auto listening = must(listen_at(path));
    const auto caller = must(connect_to(path));
    EXPECT_TRUE(accept_within(*listening, 1s));
  }
  EXPECT_EQ(connect_to(path).error().kind, FaultKind::disconnected) << "an earlier process left it there";
  EXPECT_EQ(connect_to(folder / "none" / "deep.sock").error().kind, FaultKind::disconnected);
}

TEST(LocalSocket, IsOnlyForItsAccountAndItsGroup) {
  const auto path = socket_path("mode");
  const auto listening = must(listen_at(path));
  EXPECT_EQ(std::filesystem::status(path).permissions(), static_cast<std::filesystem::perms>(0660));
}

TEST(LocalSocket, NoFileIsReplacedByIt) {
  const auto path = socket_path("file");
  ASSERT_TRUE(std::filesystem::create_directories(path) || std::filesystem::exists(path));
  EXPECT_EQ(listen_at(path).error().kind, FaultKind::io);
  EXPECT_TRUE(std::filesystem::is_directory(path));
}

TEST(LocalSocket, WhoSaysNothingIsNotWaitedForLongerThanTold) {
  const auto path = socket_path("silent");
  const auto listening = must(listen_at(path));
  EXPECT_FALSE(accept_within(*listening, 10ms));
  const auto caller = must(connect_to(path));
  const auto heard = accept_within(*listening, 1s);
  ASSERT_TRUE(heard);
  const auto began = std::chrono::steady_clock::now();
  EXPECT_EQ(read_line_within(heard, 16, 50ms).error().kind, FaultKind::timeout);
  ASSERT_TRUE(write_within(*caller, "blur", 1s));
  EXPECT_EQ(read_line_within(heard, 16, 50ms).error().kind, FaultKind::timeout) << "half a line is none";
  // Nobody reads: once its buffer is full, writing ends in time, too.
  EXPECT_EQ(write_within(heard, std::string(50'000'000, 'x'), 100ms).error().kind, FaultKind::timeout);
  EXPECT_LT(std::chrono::steady_clock::now() - began, 3s);
  ASSERT_TRUE(write_within(*caller, std::string(100, 'y'), 1s));
  EXPECT_EQ(read_line_within(heard, 16, 1s).error().kind, FaultKind::bad_input) << "too long a line";
}

TEST(LocalSocket, CarriesAWholeAnswer) {
  const auto path = socket_path("whole");
  const auto listening = must(listen_at(path));
  Snapshot snapshot;
  snapshot.picture = Image<Rgb8>(500, 300);
  for (std::size_t i = 0; i < snapshot.picture.elements().size(); ++i)
    snapshot.picture.elements()[i] = Rgb8(i % 251, i % 13, 10);  // 10: line ends among the bytes
  snapshot.kind = SnapshotKind::sharp;
  snapshot.words = "two\nlines \"quoted\" \xff";
  snapshot.shown = "live";
  std::thread serves([&] {
    const auto caller = accept_within(*listening, 5s);
    EXPECT_TRUE(write_within(caller, snapshot_answer(snapshot), 5s));
  });
  const auto socket = connect_to(path);
  ASSERT_TRUE(socket);
  const auto line = read_line_within(*socket, 10000, 5s);
  ASSERT_TRUE(line);
  const auto header = parse_snapshot_header(*line);
  ASSERT_TRUE(header) << header.error().message;
  EXPECT_EQ(header->snapshot.kind, SnapshotKind::sharp);
  EXPECT_EQ(header->picture_bytes, 450'000u);
  EXPECT_THAT(header->snapshot.words, HasSubstr("two\nlines \"quoted\""));
  const auto bytes = read_bytes_within(*socket, header->picture_bytes, 5s);
  serves.join();
  ASSERT_TRUE(bytes);
  EXPECT_EQ(static_cast<std::uint8_t>((*bytes)[3 * 250]), 250);
  EXPECT_EQ(read_bytes_within(*socket, 1, 1s).error().kind, FaultKind::disconnected);
}

TEST(SnapshotAnswer, ThatIsNotOursIsRefused) {
  for (const char* line :
       {"", "{}", "[1]", "HTTP/1.1 200 OK", R"({"kind":"blurred"})",
        R"({"kind":"blurred","width":100000,"height":100000,"shown":"","reason":"","words":"","building":true,)"
        R"("refused":false,"utc":"","screen":[1,1]})"})
    EXPECT_FALSE(parse_snapshot_header(line)) << line;
  EXPECT_FALSE(parse_snapshot_request("sharper"));
}

}  // namespace
}  // namespace kasumi
