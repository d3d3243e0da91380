// The power goes at any moment while a bundle arrives, and with it whatever had not been written through: what is there
// then is a whole bundle or the beginning of one, byte for byte, and the rest of it can still come (fault 22).
#include <gtest/gtest.h>

#include <random>

#include "report/web/arriving_bundle.hpp"
#include "tests/base/power_cut.hpp"
#include "tests/report/running_reporter.hpp"

namespace kasumi::report {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kSyncBytes = 1000;
const std::string kAddress = "https://example.org/hill.kasumi";

// No two pieces of it are alike.
std::string bundle_of(std::size_t bytes, unsigned seed) {
  std::mt19937 random(seed);
  std::string text(bytes, '\0');
  for (char& c : text) c = static_cast<char>(random());
  return text;
}

// From where it is to its end, as it comes over a network.
void add_rest(ArrivingBundle& arriving, const std::string& whole, std::size_t until) {
  while (arriving.bytes() < until) {
    const auto n = std::min<std::size_t>(300, until - arriving.bytes());
    ASSERT_TRUE(arriving.add({whole.data() + arriving.bytes(), n}));
  }
}

TEST(ArrivingBundles, Row22APowerCutLeavesAWholeBundleOrItsBeginning) {
  const auto folder = report_folder("arriving");
  const std::map<std::string, std::string> versions{{"\"spring\"", bundle_of(4500, 1)},
                                                    {"\"summer\"", bundle_of(6100, 2)}};
  fs::create_directories(folder / "disk");
  const PowerCut power(folder / "disk");
  {
    ArrivingBundle arriving(folder / "disk", kAddress, 0, kSyncBytes);
    const auto& spring = versions.at("\"spring\"");
    ASSERT_TRUE(arriving.begin("\"spring\"", spring.size()));
    add_rest(arriving, spring, spring.size());
    ASSERT_TRUE(arriving.finish());
    ASSERT_TRUE(arriving.begin("\"summer\"", 0));
    add_rest(arriving, versions.at("\"summer\""), 3300);
    arriving.keep();
  }
  {
    ArrivingBundle arriving(folder / "disk", kAddress, 0, kSyncBytes);
    ASSERT_EQ(arriving.bytes(), 3300u);
    ASSERT_TRUE(arriving.resume(6100));
    add_rest(arriving, versions.at("\"summer\""), 6100);
    ASSERT_TRUE(arriving.finish());
  }
  std::map<std::string, int> found;
  for (std::size_t calls = 0; calls <= power.calls(); ++calls)
    for (const auto left : PowerCut::kAll) {
      SCOPED_TRACE(fmt::format("cut after {} of {} calls, left over {}", calls, power.calls(), static_cast<int>(left)));
      power.lay_out(calls, left, folder / "found");
      ArrivingBundle there(folder / "found", kAddress, 0, kSyncBytes);
      const auto lies = read_text_file(folder / "found/content/fetched.kasumi").value_or("");
      // What has its name is whole, whether or not it is known by now which one it is.
      EXPECT_TRUE(lies.empty() || lies == versions.at("\"spring\"") || lies == versions.at("\"summer\""));
      if (!there.whole_tag().empty()) {
        EXPECT_EQ(lies, versions.at(there.whole_tag())) << "else it would never come again";
      }
      if (calls == power.calls()) {
        EXPECT_EQ(there.whole_tag(), "\"summer\"") << "it was told that it had come";
      }
      ++found[there.tag().empty() ? "whole " + there.whole_tag() : "part of " + there.tag()];
      if (there.tag().empty()) continue;
      const auto& whole = versions.at(there.tag());
      ASSERT_LE(there.bytes(), whole.size());
      ASSERT_TRUE(there.resume(whole.size()));
      add_rest(there, whole, whole.size());
      ASSERT_TRUE(there.finish());
      EXPECT_EQ(read_text_file(folder / "found/content/fetched.kasumi").value_or(""), whole);
    }
  for (const auto& [what, times] : found)
    std::printf("22 power cut while content arrives: %s, %d times\n", what.c_str(), times);
  EXPECT_GT(found["part of \"spring\""], 10);
  EXPECT_GT(found["part of \"summer\""], 10);
  EXPECT_GT(found["whole \"spring\""], 0);
}

// Each time that something is about to be written, not at its beginning alone: others fill the disk meanwhile, and a
// server need not say how much comes.
TEST(ArrivingBundles, Row21LeaveRoomOnTheDiskAllTheWay) {
  constexpr std::uint64_t kLeft = 10'000, kAll = 5 * kSyncBytes;
  const auto folder = report_folder("arriving-full");
  std::uint64_t left = 0;
  const auto arriving_bundle = [&] {
    return ArrivingBundle(folder, kAddress, kLeft, kSyncBytes,
                          [&left](const fs::path&) { return Result<std::uint64_t>(left); });
  };
  const auto refused = [](const Result<>& done) {
    return !done && done.error().kind == FaultKind::io &&
           done.error().message.find("MB are needed") != std::string::npos;
  };
  const auto piece = bundle_of(kSyncBytes, 1);
  {
    auto arriving = arriving_bundle();
    left = kLeft + kAll - 1;
    EXPECT_TRUE(refused(arriving.begin("\"spring\"", kAll)));
    EXPECT_FALSE(fs::exists(folder / "arriving.part"));
    left += 1;
    ASSERT_TRUE(arriving.begin("\"spring\"", kAll));
    left = kLeft;
    EXPECT_TRUE(arriving.add(piece));
    left -= 1;
    EXPECT_TRUE(refused(arriving.add(piece)));
    arriving.keep();
  }
  auto arriving = arriving_bundle();
  ASSERT_EQ(arriving.bytes(), 2 * kSyncBytes) << "what came is kept until there is room again";
  left = kLeft + kAll - arriving.bytes() - 1;
  EXPECT_TRUE(refused(arriving.resume(kAll)));
  left += 1;
  EXPECT_TRUE(arriving.resume(kAll));
}

}  // namespace
}  // namespace kasumi::report
