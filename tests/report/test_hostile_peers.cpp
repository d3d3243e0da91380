// Row 28: peers that are slow, huge, malformed, many, or curious. All on this machine, bounded in number and time.
#include <gmock/gmock.h>

#include <random>

#include "report/page/tokens.hpp"
#include "tests/report/running_reporter.hpp"

namespace kasumi::report {
namespace {

using testing::AnyOf, testing::HasSubstr, testing::StartsWith;

constexpr double kMostMemory_kb = 20 * 1024;

class HostilePeers : public testing::Test {
 protected:
  static void SetUpTestSuite() { reporter_ = std::make_unique<RunningReporter>("hostile"); }
  static void TearDownTestSuite() {
    EXPECT_EQ(reporter_->child().stop(), 0);
    reporter_.reset();
  }
  static RunningReporter& reporter() { return *reporter_; }
  static double refused(const std::string& why) {
    const auto text = reporter().metrics(), name = "kasumi_report_refused_total{why=\"" + why + "\"} ";
    const auto at = text.find(name);
    return at == std::string::npos ? 0.0 : std::stod(text.substr(at + name.size()));
  }
  static void expect_well() {
    EXPECT_THAT(reporter().metrics(), HasSubstr("kasumi_up "));
    // Sanitizers multiply memory; what they find counts then.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    EXPECT_LT(reporter().child().memory_kb(), kMostMemory_kb);
#endif
  }
  // The answer to whatever a peer says.
  static std::string answer_to(const std::string& bytes, int longest_ms = 3000) {
    const auto fd = connected(reporter().port);
    sent(fd, bytes);
    return heard_from(fd, longest_ms);
  }

 private:
  static std::unique_ptr<RunningReporter> reporter_;
};
std::unique_ptr<RunningReporter> HostilePeers::reporter_;

TEST_F(HostilePeers, Row28TraversalFindsNothing) {
  const double before = refused("404");
  for (const auto* path : {"/../../../etc/passwd", "/..%2f..%2fetc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "//etc/passwd",
                           "/metrics/../../etc/passwd", "/metrics/", "/metrics%00.html", "/.git/config",
                           "/status.json/..", "/%c0%ae%c0%ae/etc/passwd", "/\\..\\..\\etc\\passwd"}) {
    const auto answer = reporter().get(path);
    EXPECT_THAT(answer, AnyOf(StartsWith("HTTP/1.1 404"), StartsWith("HTTP/1.1 400"))) << path;
    EXPECT_THAT(answer, testing::Not(HasSubstr("root:")));
  }
  EXPECT_GT(refused("404"), before);
  expect_well();
}

TEST_F(HostilePeers, Row28OnlyReadingIsUnderstood) {
  for (const auto* method : {"POST", "PUT", "DELETE", "OPTIONS", "TRACE", "CONNECT", "PATCH", "BREW"}) {
    const auto answer =
        answer_to(fmt::format("{} /metrics HTTP/1.1\r\nHost: localhost\r\nContent-Length: 0\r\n\r\n", method));
    EXPECT_THAT(answer, StartsWith("HTTP/1.1 405")) << method;
  }
  expect_well();
}

// A page elsewhere that leads a browser here by a name of its own.
TEST_F(HostilePeers, Row28AForeignNameIsRefused) {
  const auto answer = answer_to("GET /metrics HTTP/1.1\r\nHost: rebound.example:80\r\nConnection: close\r\n\r\n");
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 421"));
  EXPECT_GE(refused("foreign name"), 1.0);
}

TEST_F(HostilePeers, Row28WhatIsNoRequestIsRefused) {
  std::mt19937 random(7);
  const double before = refused("unanswered");
  for (int i = 0; i < 200; ++i) {
    std::string bytes(1 + random() % 600, '\0');
    for (char& c : bytes) c = static_cast<char>(random());
    answer_to(bytes + "\r\n\r\n", 300);
  }
  for (const auto* bytes :
       {"\r\n\r\n", "GET\r\n\r\n", "GET /metrics\r\n\r\n", "GET /metrics HTTP/9.9\r\n\r\n",
        "\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03",
        "GET /metrics HTTP/1.1\r\nContent-Length: 99999999999999999999\r\nHost: localhost\r\n\r\n",
        "GET /metrics HTTP/1.1\r\nTransfer-Encoding: chunked\r\nHost: localhost\r\n\r\nffffffffffffffff\r\n"})
    answer_to(bytes, 300);
  EXPECT_GT(refused("unanswered"), before);
  expect_well();
}

TEST_F(HostilePeers, Row28HeaderBombsAreCutOff) {
  // One header without end, headers without end, a request line without end: 64 MB each, if anybody took them.
  for (const std::string& bomb :
       {std::string("x: ") + std::string(8192, 'y'), std::string("a: b\r\n"), std::string(8192, 'z')}) {
    const auto fd = connected(reporter().port);
    sent(fd, bomb[0] == 'z' ? "GET /" : "GET / HTTP/1.1\r\nHost: localhost\r\n");
    std::string mouthful;
    while (mouthful.size() < 65536) mouthful += bomb;
    int taken = 0;
    while (taken < 1024 && sent(fd, mouthful)) ++taken;
    EXPECT_LT(taken, 1024) << "more was read than the kernel keeps";
    EXPECT_THAT(heard_from(fd, 3000), testing::Not(StartsWith("HTTP/1.1 200")));
  }
  expect_well();
}

TEST_F(HostilePeers, Row28ABodyIsNotReadAtAll) {
  const auto fd = connected(reporter().port);
  sent(fd, "POST /metrics HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1000000000\r\n\r\n");
  const std::string megabyte(1 << 20, 'x');
  int taken = 0;
  while (taken < 64 && sent(fd, megabyte)) ++taken;
  EXPECT_LT(taken, 64);
  expect_well();
}

TEST_F(HostilePeers, Row28AThousandConnectionsKeepNobodyOut) {
  const double before = refused("crowded");
  std::vector<UniqueFd> crowd;
  for (int i = 0; i < 1000; ++i) {
    auto fd = connected(reporter().port);
    if (fd) sent(fd, "GET /metrics HTTP/1.1\r\nHost: loc");  // and no more
    crowd.push_back(std::move(fd));
    if (i % 100 != 99) continue;
    EXPECT_THAT(reporter().metrics(), HasSubstr("kasumi_up")) << "among " << i + 1;
  }
  EXPECT_GT(refused("crowded"), before + 800);
  expect_well();
}

// One byte every few seconds looks alive; the whole request has its deadline.
TEST_F(HostilePeers, Row28DripsAreCutOffInTime) {
  std::vector<UniqueFd> drips;
  for (int i = 0; i < 8; ++i) {
    drips.push_back(connected(reporter().port));
    sent(drips.back(), "GET /metrics HTTP/1.1\r\nX: ");
  }
  const auto began = std::chrono::steady_clock::now();
  const auto seconds = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count(); };
  const auto is_open = [](const UniqueFd& fd) {
    pollfd ready{fd.value(), POLLIN, 0};
    return ::poll(&ready, 1, 0) == 0;
  };
  while (seconds() < 40 && std::ranges::any_of(drips, is_open)) {
    for (const auto& drip : drips) sent(drip, "y");
    std::this_thread::sleep_for(std::chrono::seconds(2));
  }
  EXPECT_LT(seconds(), 30);
  EXPECT_GT(seconds(), 12) << "an honest peer on a slow line needs some time";
  EXPECT_GE(refused("slow"), 8.0);
  expect_well();
}

// A peer that asks and does not read the answers.
TEST_F(HostilePeers, Row28WhoDoesNotReadGetsNoMore) {
  const auto fd = connected(reporter().port);
  const std::string request = "GET /metrics HTTP/1.1\r\nHost: localhost\r\n\r\n";
  for (int i = 0; i < 10000 && ::send(fd.value(), request.data(), request.size(), MSG_NOSIGNAL | MSG_DONTWAIT) > 0;
       ++i) {
  }
  expect_well();
}

TEST_F(HostilePeers, Row28GuessedAndReplayedTokensAreCountedAndRefused) {
  const auto mine = new_token().value(), old = new_token().value();
  RunningReporter guarded("guarded",
                          fmt::format("[[http.tokens]]\nname = \"me\"\nhash = \"{}\"\n[[http.tokens]]\nname = \"old\"\n"
                                      "hash = \"{}\"\nuntil_utc = 2020-01-01T00:00:00Z\n",
                                      mine.hash, old.hash));
  EXPECT_THAT(guarded.get("/metrics"), StartsWith("HTTP/1.1 401"));
  EXPECT_THAT(guarded.get("/metrics?token=" + mine.token), StartsWith("HTTP/1.1 401")) << "addresses end up in logs";
  EXPECT_THAT(guarded.get("/metrics", "Authorization: Bearer " + mine.token + "\r\n"), StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(guarded.get("/metrics", "Authorization: Bearer " + old.token + "\r\n"), StartsWith("HTTP/1.1 401"));
  EXPECT_THAT(guarded.get("/metrics", "Cookie: token=" + mine.token + "\r\n"), StartsWith("HTTP/1.1 401"));
  for (int i = 0; i < 100; ++i)
    EXPECT_THAT(guarded.get("/metrics", fmt::format("Authorization: Bearer {}\r\n", i)),
                testing::Not(StartsWith("HTTP/1.1 200")));
  const auto figures = guarded.get("/metrics", "Authorization: Bearer " + mine.token + "\r\n");
  EXPECT_THAT(figures, HasSubstr("kasumi_report_refused_total{why=\"expired token\"} 1\n"));
  EXPECT_THAT(figures, HasSubstr("kasumi_report_refused_total{why=\"no token\"} 3\n"));
  EXPECT_THAT(figures, HasSubstr("why=\"wrong token\""));
  EXPECT_THAT(guarded.log(), testing::IsEmpty()) << "peers do not fill the log";
}

}  // namespace
}  // namespace kasumi::report
