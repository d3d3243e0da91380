// Content fetched from web servers: from nginx, over kills and power cuts, and from servers that are slow, endless, or lie.
#include <gmock/gmock.h>

#include <regex>

#include "base/utc_text.hpp"
#include "report/web/content_pull.hpp"
#include "report/web/web_request.hpp"
#include "tests/report/web_server.hpp"

namespace kasumi::report {
namespace {

using namespace std::chrono_literals;
using testing::AllOf, testing::EndsWith, testing::HasSubstr, testing::MatchesRegex, testing::Not;
namespace fs = std::filesystem;

// No two pieces of it are alike, so that one in the wrong place shows.
std::string some_bundle(std::size_t bytes, std::uint32_t seed) {
  std::string text(bytes, '\0');
  for (char& c : text) c = static_cast<char>((seed = seed * 1664525u + 1013904223u) >> 24);
  return text;
}

struct Pulls : testing::Test {
  void SetUp() override {
    if (!is_installed("openssl") || !has_nginx()) GTEST_SKIP() << "openssl or nginx is not installed";
    folder = report_folder("pull");
    make_certificates(folder);
    fs::create_directories(folder / "www");
  }
  void offer(const std::string& text) const { ASSERT_TRUE(write_text_file(folder / "www/hill.kasumi", text)); }
  PullOptions from(const std::string& url, const std::string& trusting = "ca") const {
    return {url, 15min, trusting.empty() ? std::string() : (folder / (trusting + ".pem")).string(), folder / "state"};
  }
  std::string come() const { return read_text_file(folder / "state/content/fetched.kasumi").value_or("nothing"); }
  // Until the next exchange is over.
  static bool ends(ContentPull& pull, double longest_s = 60) {
    const auto done = [&] { return pull.fetched() + pull.unchanged() + pull.failed(); };
    const auto before = done();
    return within(longest_s, [&] {
      pull.turn();
      return done() > before;
    });
  }
  fs::path folder;
  ManualClock clock{*parse_utc("2026-06-21T18:00:00Z")};
};

TEST_F(Pulls, FetchEachVersionOnce) {
  const WebServer server(folder);
  offer("spring");
  ContentPull pull(from(server.url("hill.kasumi")), clock);
  ASSERT_TRUE(ends(pull));
  EXPECT_EQ(come(), "spring") << pull.status().problem;
  EXPECT_TRUE(pull.status().came);
  pull.turn();
  EXPECT_EQ(pull.unchanged(), 0u) << "not before its time";
  clock.advance(15min);
  ASSERT_TRUE(ends(pull));
  EXPECT_EQ(pull.unchanged(), 1u);
  offer("summer!");
  clock.advance(15min);
  ASSERT_TRUE(ends(pull));
  EXPECT_EQ(come(), "summer!");
  EXPECT_EQ(server.asked(), "200 - 6\n304 - 0\n200 - 7\n");
  // After a restart, too; and once more where somebody has taken it away.
  ContentPull next(from(server.url("hill.kasumi")), clock);
  ASSERT_TRUE(ends(next));
  EXPECT_EQ(next.unchanged(), 1u);
  fs::remove(folder / "state/content/fetched.kasumi");
  ContentPull last(from(server.url("hill.kasumi")), clock);
  ASSERT_TRUE(ends(last));
  EXPECT_EQ(come(), "summer!");
}

// The reporter itself, killed in the middle; of what it had written, the power cut leaves what was synced, and rubbish.
TEST_F(Pulls, KilledHalfWayGoOnWhereTheyWere) {
  const auto bundle = some_bundle(24 << 20, 1);
  offer(bundle);
  const WebServer server(folder, "own", "limit_rate 6m;");
  ASSERT_TRUE(write_text_file(
      folder / "report.toml",
      fmt::format("[content]\nurl = \"{}\"\nca_file = \"{}\"\nfolder = \"{}\"\n", server.url("hill.kasumi"),
                  (folder / "ca.pem").string(), (folder / "state").string())));
  const std::vector<std::string> command{report_program(), "run", "--config", folder / "report.toml"};
  const auto kept = [&] {
    const auto note = parse_pull_note(read_text_file(folder / "state/arriving.txt").value_or(""));
    return note ? note->bytes : 0;
  };
  std::uint64_t left = 0;
  {
    Child reporter(command, folder / "first.log");
    ASSERT_TRUE(within(60, [&] { return kept() >= 8 << 20; })) << read_text_file(folder / "first.log").value_or("");
    reporter.stop(SIGKILL);
    left = kept();
    ASSERT_LT(left, bundle.size());
    fs::resize_file(folder / "state/arriving.part", left);
    fs::resize_file(folder / "state/arriving.part", left + 5000);
    EXPECT_FALSE(fs::exists(folder / "state/content"));
  }
  Child reporter(command, folder / "second.log");
  ASSERT_TRUE(within(60, [&] { return fs::exists(folder / "state/content/fetched.kasumi"); }))
      << read_text_file(folder / "second.log").value_or("");
  EXPECT_TRUE(come() == bundle) << "not what was offered";
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  EXPECT_LT(reporter.memory_kb(), 20 * 1024) << "a bundle is not kept in memory";
#endif
  reporter.stop();
  EXPECT_THAT(server.asked(), HasSubstr(fmt::format("206 bytes={}- {}\n", left, bundle.size() - left)));
  EXPECT_FALSE(fs::exists(folder / "state/arriving.part"));
}

TEST_F(Pulls, BeginAnewWhereThereIsANewVersionMeanwhile) {
  offer(some_bundle(24 << 20, 1));
  {
    const WebServer server(folder, "own", "limit_rate 6m;");
    ContentPull pull(from(server.url("hill.kasumi")), clock);
    ASSERT_TRUE(within(60, [&] {
      pull.turn();
      return pull.status().bytes > 1 << 20;
    }));
    EXPECT_EQ(pull.status().of_bytes, 24u << 20);
  }
  const auto newer = some_bundle(3 << 20, 2);
  offer(newer);
  const WebServer server(folder);
  auto options = from(server.url("hill.kasumi"));
  // The same address, wherever it is today.
  const auto note = read_text_file(folder / "state/arriving.txt").value();
  ASSERT_TRUE(write_text_file(folder / "state/arriving.txt", options.url + note.substr(note.find('\n'))));
  ContentPull pull(options, clock);
  EXPECT_GT(pull.status().bytes, 1u << 20);
  ASSERT_TRUE(ends(pull));
  EXPECT_TRUE(come() == newer) << pull.status().problem;
  EXPECT_THAT(server.asked(), MatchesRegex("(.*\n)*200 bytes=[0-9]+- 3145728\n"));
}

TEST_F(Pulls, ComeFromNobodyElse) {
  offer("spring");
  const auto comes = [&](const std::string& who, const std::string& trusting) {
    const WebServer server(folder, who);
    ContentPull pull(from(server.url("hill.kasumi"), trusting), clock);
    EXPECT_TRUE(ends(pull));
    EXPECT_EQ(pull.status().problem.find("certificate") != std::string::npos, pull.failed() > 0);
    return pull.fetched() == 1;
  };
  EXPECT_FALSE(comes("own", "stranger"));
  EXPECT_FALSE(comes("own", ""));
  EXPECT_FALSE(comes("other", "ca"));
  EXPECT_EQ(come(), "nothing");
  EXPECT_TRUE(comes("own", "ca"));
}

TEST_F(Pulls, TakeNothingFromAServerThatLies) {
  PullBounds bounds;
  bounds.bytes = 20 << 20;
  bounds.slow = 2s;
  for (const auto& [way, why] : {std::pair{"endless", "more than 20 MB"},
                                 {"huge", "it has 8583 MB"},
                                 {"short", "transfer closed|Transferred a partial file"},
                                 {"header", "its header has no end|Failed writing|size"},
                                 {"slow", "Timeout was reached"},
                                 {"silent", "Timeout was reached"},
                                 {"tagless", "it gives no ETag"},
                                 {"elsewhere", "it answers 302"},
                                 {"part", "another part than it was asked for"},
                                 {"empty", "an empty file"},
                                 {"nonsense", "."},
                                 {"missing", "it answers 404"},
                                 {"verbose", "it answers 404"}}) {
    SCOPED_TRACE(way);
    fs::remove_all(folder / "state");
    const LyingServer server(folder, way);
    ContentPull pull(from(server.url()), clock, bounds);
    EXPECT_TRUE(ends(pull));
    EXPECT_EQ(pull.failed(), 1u);
    EXPECT_TRUE(std::regex_search(pull.status().problem, std::regex(why))) << pull.status().problem;
    EXPECT_EQ(come(), "nothing");
    EXPECT_LE(pull.status().bytes, 2000u) << "what is wrong is not kept";
    // It is asked again, not at once.
    pull.turn();
    EXPECT_EQ(pull.failed(), 1u);
    clock.advance(1min);
  }
}

TEST_F(Pulls, WaitLongerAfterEachFailure) {
  const int nobody = free_port();
  testing::internal::CaptureStderr();
  ContentPull pull(from(fmt::format("https://127.0.0.1:{}/x.kasumi", nobody)), clock);
  for (const auto wait : {0min, 1min, 2min, 4min, 8min, 15min, 15min}) {
    clock.advance(wait - 1s);
    pull.turn();
    const auto before = pull.failed();
    clock.advance(1s);
    within(0.3, [&] {
      pull.turn();
      return false;
    });
    EXPECT_EQ(pull.failed(), before + 1) << wait.count();
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            fmt::format("<4>content: 127.0.0.1:{}: Couldn't connect to server (Connection refused)\n", nobody));
}

TEST_F(Pulls, LeaveRoomOnTheDisk) {
  const WebServer server(folder);
  offer("spring");
  PullBounds bounds;
  bounds.free_bytes = std::uint64_t{1} << 60;
  ContentPull pull(from(server.url("hill.kasumi")), clock, bounds);
  ASSERT_TRUE(ends(pull));
  EXPECT_THAT(pull.status().problem, HasSubstr("MB of the disk are free"));
  EXPECT_EQ(come(), "nothing");
}

TEST_F(Pulls, KeepWhatHasComeWhileTheDiskIsFull) {
  const auto bundle = some_bundle(24 << 20, 1);
  offer(bundle);
  const WebServer server(folder, "own", "limit_rate 6m;");
  const auto options = from(server.url("hill.kasumi"));
  {
    ContentPull pull(options, clock);
    ASSERT_TRUE(within(60, [&] {
      pull.turn();
      return pull.status().bytes > 1 << 20;
    }));
  }
  PullBounds full;
  full.free_bytes = std::uint64_t{1} << 60;
  ContentPull refused(options, clock, full);
  ASSERT_TRUE(ends(refused));
  EXPECT_THAT(refused.status().problem, HasSubstr("MB of the disk are free"));
  const auto kept = refused.status().bytes;
  EXPECT_GT(kept, 1u << 20);
  ContentPull pull(options, clock);
  ASSERT_TRUE(ends(pull));
  EXPECT_TRUE(come() == bundle) << pull.status().problem;
  EXPECT_THAT(server.asked(), HasSubstr(fmt::format("206 bytes={}- {}\n", kept, bundle.size() - kept)));
}

TEST(PullAnswers, AreReadWithDistrust) {
  const auto of = [](std::initializer_list<const char*> lines) {
    PullAnswer answer;
    for (const auto* line : lines) take_header(line, answer);
    return answer;
  };
  const auto part =
      of({"HTTP/2 206\r\n", "etag: \"a-1\"\r\n", "Content-Range: bytes 5-9/10\r\n", "CONTENT-LENGTH: 5\r\n"});
  EXPECT_EQ(part.code, 206);
  EXPECT_EQ(part.tag, "\"a-1\"");
  EXPECT_EQ(part.first, 5u);
  EXPECT_EQ(part.of_bytes, 10u);
  EXPECT_EQ(part.bytes, 5u);
  // A later status line begins anew, as after "100 Continue".
  EXPECT_EQ(of({"HTTP/1.1 100 Continue", "ETag: \"a\"", "HTTP/1.1 200 OK"}).tag, "");
  for (const auto* line :
       {"ETag: a", "ETag: \"", "ETag: \"a\nb\"", "ETag: \"a\" \"b\"", "ETag:", "Content-Range: bytes 5-8/10",
        "Content-Range: bytes 9-5/10", "Content-Range: bytes */10", "Content-Range: bytes 5-9/*", "Content-Length: -1",
        "Content-Length: 99999999999999999999", "Content-Length: 1x"}) {
    const auto odd = of({"HTTP/1.1 200 OK", line});
    EXPECT_TRUE(odd.tag.empty() && !odd.bytes && !odd.first && !odd.of_bytes) << line;
  }
  EXPECT_EQ(of({"nonsense"}).code, 0);
  EXPECT_TRUE(is_strong("\"a\""));
  EXPECT_FALSE(is_strong("W/\"a\""));
}

TEST(PullNotes, AreReadBackOrNotAtAll) {
  const PullNote note{"https://example.org/hill.kasumi", "\"a\"", 4096};
  EXPECT_EQ(parse_pull_note(text_of(note)), note);
  for (const auto* text : {"", "https://x/\n\"a\"\n", "https://x/\n\"a\"\n4096", "https://x/\n\"a\"\n-1\n",
                           "x\n\"a\"\n1\n", "https://x/\na\n1\n", "https://x/\n\"a\"\n1\nmore\n"})
    EXPECT_FALSE(parse_pull_note(text)) << text;
}

}  // namespace
}  // namespace kasumi::report
