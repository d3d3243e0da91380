// The picture of the screen as the reporter asks for it: of a kiosk that answers, of one that does not, and of one that lies; and
// who may make it ask.
#include <gmock/gmock.h>

#include <thread>

#include "base/socket/local_socket.hpp"
#include "base/utc_text.hpp"
#include "report/page/screen_asking.hpp"
#include "tests/report/running_reporter.hpp"

namespace kasumi::report {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr, testing::Not, testing::StartsWith;

const Utc kNoon = *parse_utc("2026-06-21T12:00:00Z");

// A kiosk's socket: each caller is told the same bytes, and then hung up on unless they are to hold the line.
class Kiosk {
 public:
  Kiosk(const std::filesystem::path& folder, std::string bytes, bool holds = false)
      : bytes_(std::move(bytes)), holds_(holds) {
    std::filesystem::create_directories((screen_socket(folder)).parent_path());
    auto listening = listen_at(screen_socket(folder));
    EXPECT_TRUE(listening) << listening.error().message;
    if (listening) listening_ = std::move(*listening);
    serves_ = std::thread([this] {
      while (!done_)
        if (auto caller = accept_within(listening_, 20ms)) serve(std::move(caller));
    });
  }
  ~Kiosk() {
    done_ = true;
    serves_.join();
  }
  int callers() const { return callers_; }

 private:
  void serve(UniqueFd caller) {
    ++callers_;
    (void)write_within(caller, bytes_, 1s);
    if (holds_) held_.push_back(std::move(caller));
  }
  std::string bytes_;
  bool holds_;
  UniqueFd listening_;
  std::vector<UniqueFd> held_;
  std::atomic<bool> done_ = false;
  std::atomic<int> callers_ = 0;
  std::thread serves_;
};

ScreenAnswer some_picture() {
  return {Image<Rgb8>(32, 18, Rgb8(10, 20, 30)), kNoon, {}};
}

TEST(ScreenAsking, GetsWhatTheKioskGives) {
  const auto folder = report_folder("screen");
  ManualClock clock(kNoon);
  ScreenAsking asking(screen_socket(folder), clock);
  EXPECT_EQ(asking.ask().outcome, ScreenOutcome::off) << "no socket";
  {
    const Kiosk kiosk(folder, screen_answer_bytes(some_picture()));
    const auto reply = asking.ask();
    EXPECT_EQ(reply.outcome, ScreenOutcome::picture) << reply.why;
    EXPECT_EQ(reply.answer.picture.elements(), some_picture().picture.elements());
    EXPECT_EQ(reply.answer.utc, kNoon);
    clock.advance(20s);
    const auto soon = asking.ask();
    EXPECT_EQ(soon.outcome, ScreenOutcome::wait);
    EXPECT_EQ(soon.answer.wait, 40s);
    EXPECT_EQ(kiosk.callers(), 1) << "the kiosk is not asked";
    clock.advance(40s);
  }
  EXPECT_EQ(asking.ask().outcome, ScreenOutcome::off) << "the socket of a kiosk that ended";
  {
    const Kiosk kiosk(folder, "wait 30\n");  // somebody else asked, or it was before our start
    EXPECT_EQ(asking.ask().answer.wait, 30s);
    clock.advance(10s);
    EXPECT_EQ(asking.ask().answer.wait, 20s);
    EXPECT_EQ(kiosk.callers(), 1);
    clock.advance(20s);
  }
  const Kiosk kiosk(folder, "nothing\n");
  EXPECT_EQ(asking.ask().outcome, ScreenOutcome::nothing);
}

TEST(ScreenAsking, BelievesNothingElse) {
  const auto folder = report_folder("screen-lies");
  const auto whole = screen_answer_bytes(some_picture());
  for (const std::string& lie :
       {std::string(), std::string("\n"), std::string(1 << 20, 'x'),
        std::string("picture 160 90 2026-06-21T12:00:00Z\n"), std::string("picture 99999 99999 2026-06-21T12:00:00Z\n"),
        whole.substr(0, whole.size() - 1), std::string("wait 1000000000000\n"),
        std::string("picture 32 18 never\n") + whole}) {
    ManualClock clock(kNoon);
    ScreenAsking asking(screen_socket(folder), clock);
    const Kiosk kiosk(folder, lie);
    const auto reply = asking.ask();
    EXPECT_EQ(reply.outcome, ScreenOutcome::no_answer) << lie.substr(0, 60);
    EXPECT_FALSE(reply.why.empty());
    EXPECT_TRUE(reply.answer.picture.empty());
  }
}

// Silent, or with half an answer: over in time, and then not tried again for a minute.
TEST(ScreenAsking, AKioskThatHangsCostsLittle) {
  const auto folder = report_folder("screen-hangs");
  const auto whole = screen_answer_bytes(some_picture());
  for (const std::string& part : {std::string(), std::string("pict"), whole.substr(0, 100)}) {
    ManualClock clock(kNoon);
    ScreenAsking asking(screen_socket(folder), clock);
    const Kiosk kiosk(folder, part, true);
    const auto began = std::chrono::steady_clock::now();
    EXPECT_EQ(asking.ask().outcome, ScreenOutcome::no_answer);
    EXPECT_LT(std::chrono::steady_clock::now() - began, ScreenAsking::kAnswerDeadline + 2s);
    EXPECT_EQ(asking.ask().outcome, ScreenOutcome::wait);
    EXPECT_EQ(kiosk.callers(), 1);
  }
}

class ScreenButton : public testing::Test {
 protected:
  static std::string body(const std::string& answer) {
    return answer.substr(std::min(answer.find("\r\n\r\n"), answer.size()));
  }
  static std::string with_screen(const std::string& status) {
    return changed(status, "\"pid\"", "\"screen_picture\": {\"allowed\": true, \"taken\": 0}, \"pid\"");
  }
  // Once the reporter has read that the kiosk allows it.
  static std::string button(RunningReporter& reporter) {
    reporter.tell(with_screen(kGoodStatus));
    std::string action;
    EXPECT_TRUE(within(10, [&] { return !(action = form_action(reporter.get("/"))).empty(); }));
    return action;
  }
};

TEST_F(ScreenButton, ShowsThePictureAndReadingNeverTakesOne) {
  RunningReporter reporter("screen-button", "screen_picture = true\n");
  const Kiosk kiosk(reporter.folder, screen_answer_bytes(some_picture()));
  const auto action = button(reporter);
  for (const auto& path : {std::string("/"), std::string("/screen"), action})
    EXPECT_THAT(body(reporter.get(path)), Not(HasSubstr("<img"))) << path;
  EXPECT_EQ(kiosk.callers(), 0) << "GET never takes one";
  const auto answer = reporter.post(action, "Accept-Language: fr\r\n");
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(answer, HasSubstr("Cache-Control: no-store"));
  EXPECT_THAT(answer, HasSubstr("img-src data:;"));
  EXPECT_EQ(picture_in(answer).elements(), some_picture().picture.elements());
  EXPECT_THAT(answer, HasSubstr("<html lang=\"en\">")) << "as the form said";
  EXPECT_EQ(kiosk.callers(), 1);
  EXPECT_THAT(reporter.post(action), HasSubstr("possible in</strong>"));
  EXPECT_EQ(kiosk.callers(), 1);
  for (const auto& file : std::filesystem::recursive_directory_iterator(reporter.folder))
    EXPECT_THAT(file.path().extension().string(), testing::AnyOf(".json", ".toml", ".sock", "")) << "nothing is kept";
}

TEST_F(ScreenButton, IsPressedByNobodyElse) {
  const auto mine = new_token().value();
  RunningReporter reporter(
      "screen-guarded",
      fmt::format("screen_picture = true\n[[http.tokens]]\nname = \"me\"\nhash = \"{}\"\n", mine.hash));
  const auto authorization = "Authorization: Bearer " + mine.token + "\r\n";
  reporter.tell(with_screen(kGoodStatus));
  const Kiosk kiosk(reporter.folder, screen_answer_bytes(some_picture()));
  std::string action;
  ASSERT_TRUE(within(10, [&] { return !(action = form_action(reporter.get("/", authorization))).empty(); }));
  EXPECT_THAT(reporter.post(action), StartsWith("HTTP/1.1 401"));
  // A page elsewhere that knows the address, but not the key; a browser would send the token with it.
  for (const auto* guess : {"/screen", "/screen?key=", "/screen?language=en&key=aaaaaaaaaaaaaaaaaaaaaaaaaa"})
    EXPECT_THAT(reporter.post(guess, authorization), StartsWith("HTTP/1.1 403")) << guess;
  for (const auto* other : {"/", "/metrics", "/style.css", "/nowhere"})
    EXPECT_THAT(reporter.post(other, authorization), StartsWith("HTTP/1.1 405")) << other;
  EXPECT_EQ(kiosk.callers(), 0);
  EXPECT_THAT(reporter.post(action, authorization), HasSubstr("<img"));
}

TEST_F(ScreenButton, IsNotThereUnlessBothSidesWantIt) {
  RunningReporter silent("screen-off");
  silent.tell(with_screen(kGoodStatus));
  const Kiosk kiosk(silent.folder, screen_answer_bytes(some_picture()));
  EXPECT_THAT(silent.get("/"), Not(HasSubstr("id=\"screen\"")));
  EXPECT_THAT(silent.get("/screen"), StartsWith("HTTP/1.1 404"));
  EXPECT_THAT(silent.post("/screen"), StartsWith("HTTP/1.1 405"));
  EXPECT_EQ(kiosk.callers(), 0);
  const RunningReporter alone("screen-alone", "screen_picture = true\n");
  EXPECT_THAT(alone.get("/"), HasSubstr("Switched off at the kiosk"));
  EXPECT_EQ(form_action(alone.get("/")), "");
}

}  // namespace
}  // namespace kasumi::report
