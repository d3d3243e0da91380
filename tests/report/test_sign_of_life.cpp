// The sign of life, given to servers that take it, refuse it, hang, chatter, or are somebody else.
#include <gmock/gmock.h>

#include <atomic>

#include "base/thread_annotations.hpp"
#include "base/utc_text.hpp"
#include "report/channels/sign_of_life.hpp"
#include "report/web/web_request.hpp"
#include "tests/report/certificates.hpp"

namespace kasumi::report {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr, testing::Not, testing::StartsWith;

// Whoever connects is answered with this; empty: with nothing, ever.
class Listener {
 public:
  explicit Listener(std::string answer)
      : answer_(std::move(answer)), fd_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t length = sizeof address;
    EXPECT_EQ(::bind(fd_.value(), reinterpret_cast<sockaddr*>(&address), length), 0);
    EXPECT_EQ(::listen(fd_.value(), 8), 0);
    ::getsockname(fd_.value(), reinterpret_cast<sockaddr*>(&address), &length);
    port = ntohs(address.sin_port);
    thread_ = std::thread([this] { serve(); });
  }
  ~Listener() {
    done_ = true;
    thread_.join();
  }
  std::string last() const {
    const MutexLock lock(mutex_);
    return last_;
  }
  int asked() const { return asked_; }
  int port = 0;

 private:
  void serve() {
    std::vector<UniqueFd> held;
    while (!done_) {
      pollfd ready{fd_.value(), POLLIN, 0};
      if (::poll(&ready, 1, 50) <= 0) continue;
      UniqueFd guest(::accept(fd_.value(), nullptr, nullptr));
      const auto request = heard_from(guest, 200);
      {
        const MutexLock lock(mutex_);
        last_ = request;
      }
      ++asked_;
      if (answer_.empty())
        held.push_back(std::move(guest));
      else
        sent(guest, answer_);
    }
  }
  std::string answer_;
  UniqueFd fd_;
  mutable Mutex mutex_;
  std::string last_;
  std::atomic<int> asked_ = 0;
  std::atomic<bool> done_ = false;
  std::thread thread_;
};

const std::string kTaken = "HTTP/1.1 200 OK\r\nContent-Length: 2\r\nConnection: close\r\n\r\nOK";

class SignsOfLife : public testing::Test {
 protected:
  SignOfLifeOptions to(int port, const std::string& scheme = "http") const {
    return {fmt::format("{}://127.0.0.1:{}/ping/secret", scheme, port), 5min, {}};
  }
  static bool ends(SignOfLife& sign) {
    const auto before = sign.given() + sign.failed();
    return within(15, [&] {
      sign.turn();
      return sign.given() + sign.failed() == before + 1;
    });
  }
  ManualClock clock{*parse_utc("2026-06-21T12:00:00Z")};
};

TEST_F(SignsOfLife, AreGivenNowAndThenAndOnlyWhileItIsWell) {
  const Listener listener(kTaken);
  SignOfLife sign(to(listener.port), clock);
  const auto pass = [&](const Heard& heard, Duration length) {
    for (const auto end = clock.now() + length; clock.now() < end; clock.advance(10s)) {
      const auto before = sign.given();
      sign.tell(heard);
      within(0.3, [&] {
        sign.turn();
        return sign.given() > before;
      });
    }
  };
  pass(kLostKiosk, 1min);
  EXPECT_EQ(listener.asked(), 0);
  sign.tell(kWellKiosk);
  ASSERT_TRUE(ends(sign));
  EXPECT_THAT(listener.last(), StartsWith("GET /ping/secret HTTP/1.1\r\n"));
  pass(kWellKiosk, 1min);
  EXPECT_EQ(listener.asked(), 1);
  clock.advance(4min);
  pass(kWellKiosk, 10s);
  EXPECT_EQ(listener.asked(), 2);
  clock.advance(1h);
  for (const auto& heard : {kLostKiosk, Heard{Contact::silent, {}, "", {}}, Heard{Contact::absent, {}, "", {}},
                            Heard{Contact::unreadable, {}, "", {}}})
    pass(heard, 10s);
  EXPECT_EQ(listener.asked(), 2);
  EXPECT_EQ(sign.given(), 2u);
}

TEST_F(SignsOfLife, ThatFailAreToldOnceWithoutTheirSecretAndTriedAgain) {
  const int nobody = free_port();
  testing::internal::CaptureStderr();
  SignOfLife sign(to(nobody), clock);
  for (int i = 0; i < 4; ++i) {
    sign.tell(kWellKiosk);
    ASSERT_TRUE(ends(sign));
    clock.advance(61s);  // sooner than the next would be
  }
  EXPECT_EQ(sign.failed(), 4u);
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            fmt::format("<4>sign of life: 127.0.0.1:{}: Couldn't connect to server (Connection refused)\n", nobody));
}

TEST_F(SignsOfLife, OnlyAnAnswerThatSaysSoIsTaken) {
  std::string endless = "HTTP/1.1 200 OK\r\n\r\n";
  endless.resize(1 << 20, 'x');
  for (const auto& [answer, why] :
       {std::pair{std::string("HTTP/1.1 302 Found\r\nLocation: file:///etc/passwd\r\nContent-Length: 0\r\n\r\n"),
                  "it answers 302"},
        {"HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n", "it answers 404"},
        {"nonsense\r\n\r\n", ""},
        {endless, ""}}) {
    const Listener listener(answer);
    testing::internal::CaptureStderr();
    SignOfLife sign(to(listener.port), clock);
    sign.tell(kWellKiosk);
    EXPECT_TRUE(ends(sign));
    EXPECT_EQ(sign.failed(), 1u);
    const auto told = testing::internal::GetCapturedStderr();
    EXPECT_THAT(told, HasSubstr(why));
    EXPECT_THAT(told, Not(HasSubstr("secret")));
  }
}

TEST_F(SignsOfLife, AServerThatSaysNothingHoldsNobodyUp) {
  const Listener listener("");
  testing::internal::CaptureStderr();
  SignOfLife sign(to(listener.port), clock, 4s);
  sign.tell(kWellKiosk);
  double longest_s = 0.0;
  EXPECT_TRUE(within(15, [&] {
    const auto began = std::chrono::steady_clock::now();
    sign.tell(kWellKiosk);
    sign.turn();
    longest_s = std::max(longest_s, std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count());
    return sign.failed() == 1;
  }));
  EXPECT_LT(longest_s, 2.0);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("Timeout was reached"));
}

TEST_F(SignsOfLife, GoToNobodyElse) {
  if (!is_installed("openssl")) GTEST_SKIP() << "openssl is not installed";
  const auto folder = report_folder("sign-tls");
  make_certificates(folder);
  const auto given_to = [&](const std::string& who, const std::string& trusting) {
    const int port = free_port();
    const Child server({"openssl", "s_server", "-www", "-quiet", "-accept", fmt::format("127.0.0.1:{}", port), "-cert",
                        folder / (who + ".pem"), "-key", folder / (who + ".key")},
                       folder / "server.log");
    EXPECT_TRUE(within(20, [&] { return bool(connected(port)); }));
    auto options = to(port, "https");
    if (!trusting.empty()) options.ca_file = folder / (trusting + ".pem");
    testing::internal::CaptureStderr();
    SignOfLife sign(options, clock);
    sign.tell(kWellKiosk);
    EXPECT_TRUE(ends(sign));
    const auto told = testing::internal::GetCapturedStderr();
    EXPECT_EQ(told.find("certificate") != std::string::npos, sign.failed() > 0) << told;
    return sign.given() == 1;
  };
  EXPECT_TRUE(given_to("own", "ca"));
  EXPECT_FALSE(given_to("own", "stranger"));
  EXPECT_FALSE(given_to("own", ""));
  EXPECT_FALSE(given_to("other", "ca"));
}

TEST_F(SignsOfLife, AddressesAreOfTheWeb) {
  for (const auto* good : {"https://hc-ping.com/abc", "http://10.0.0.1:8000/x?y=z", "https://[::1]/"})
    EXPECT_TRUE(is_web_address(good)) << good;
  for (const auto* bad : {"", "https://", "file:///etc/passwd", "ftp://x/", "https:///x", "http://a b", "https://x\n"})
    EXPECT_FALSE(is_web_address(bad)) << bad;
}

}  // namespace
}  // namespace kasumi::report
