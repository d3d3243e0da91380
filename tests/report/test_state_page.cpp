// The state page: what it says, that nothing told by the kiosk can act in it, and how a browser and a screen reader take it.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "base/utc_text.hpp"
#include "history/history_ring.hpp"
#include "report/diagnosis/symptom_words.hpp"
#include "report/page/state_page.hpp"
#include "tests/browser.hpp"
#include "tests/report/running_reporter.hpp"

namespace kasumi::report {
namespace {

using std::chrono::minutes;
using testing::HasSubstr, testing::Not;

// A day until `now` with ten minutes without a camera in it, and air that clears.
std::vector<HistoryLine> day_until(Utc now) {
  std::vector<HistoryLine> lines;
  for (int i = 0; i < 1400; ++i) {
    HistoryLine line;
    line.number = static_cast<std::uint32_t>(i + 1);
    line.utc = std::chrono::floor<minutes>(now) - minutes{1400 - i};
    const bool away = i >= 900 && i < 910, night = i < 200;
    line.shown = night ? Shown::dark : away ? Shown::still : Shown::live;
    line.trouble = night ? Trouble::closed : away ? Trouble::scene_lost : Trouble::none;
    if (i > 250) {
      line.turbidity = 4.0 - 0.001 * i;
      line.sigma_turbidity = 0.2;
      line.aod_550 = 0.3 - 0.0001 * i;
      line.sigma_aod_550 = 0.02;
    }
    lines.push_back(line);
  }
  return lines;
}

StatePage page_of(const std::string& status) {
  const auto now = *parse_utc("2026-06-21T12:00:00Z");
  return {"Hill", heard_of(status), day_until(now), now, minutes{120}};
}

TEST(StatePages, SayWhatIsWrongAndWhatToDo) {
  for (const Language language : all_languages()) {
    const auto html = state_page(page_of(kLostStatus), language);
    EXPECT_THAT(html, HasSubstr(fmt::format("<html lang=\"{}\">", code_of(language))));
    EXPECT_THAT(html, HasSubstr(std::string(sight_text(Sight::still, language))));
    EXPECT_THAT(html, HasSubstr("unplugged"));
    EXPECT_THAT(html, HasSubstr("2.41 ± 0.05"));
    EXPECT_THAT(html, HasSubstr("0.120 ± 0.010"));
    EXPECT_THAT(html, HasSubstr("<polyline"));
    EXPECT_THAT(html, HasSubstr("2026-06-21 14:00 UTC+2")) << "whoever reads it may sit in another zone";
  }
  const auto german = state_page(page_of(kLostStatus), *parse_language("de"));
  EXPECT_THAT(german, HasSubstr("Kabel, Hub und Strom prüfen."));
  EXPECT_THAT(german, HasSubstr("<td>05:40</td><td>05:49</td><td>Besucher sehen das Standbild.</td>"));
  EXPECT_THAT(state_page(page_of(kGoodStatus), Language::english), HasSubstr("Nothing is wrong."));
}

// A kiosk that allows pictures of its screen.
const std::string kScreenStatus =
    changed(kGoodStatus, "\"pid\"", "\"screen_picture\": {\"allowed\": true, \"taken\": 3}, \"pid\"");

TEST(StatePages, ShowTheScreenOnRequest) {
  auto page = page_of(kScreenStatus);
  EXPECT_THAT(state_page(page, Language::english), Not(HasSubstr("<form"))) << "off unless it is configured";
  page.screen = ScreenPart{"secret", {}};
  for (const Language language : all_languages()) {
    const auto html = state_page(page, language);
    EXPECT_EQ(form_action(html), fmt::format("/screen?language={}&key=secret", code_of(language)));
    EXPECT_THAT(html, Not(HasSubstr("<img")));
  }
  EXPECT_THAT(state_page(page, Language::english), HasSubstr("Taken since the kiosk’s start: 3"));
  ScreenAnswer answer{Image<Rgb8>(32, 18), *parse_utc("2026-06-21T11:59:58Z"), {}};
  for (std::size_t i = 0; i < answer.picture.elements().size(); ++i)
    answer.picture.elements()[i] = Rgb8(i % 251, 7 * i % 256, 255 - i % 256);
  page.screen->reply = ScreenReply{ScreenOutcome::picture, answer, {}};
  for (const Language language : all_languages()) {
    const auto html = state_page(page, language);
    EXPECT_EQ(picture_in(html).elements(), answer.picture.elements());
    EXPECT_THAT(html, HasSubstr("width=\"160\" height=\"90\""));
    EXPECT_THAT(html, HasSubstr("2026-06-21 13:59:58")) << "by the wall clock";
  }
  page.screen->reply->answer.picture = Image<Rgb8>(18, 31, Rgb8(1, 2, 3));
  const auto upright = state_page(page, Language::english);
  EXPECT_THAT(upright, HasSubstr("width=\"92\" height=\"160\""));
  EXPECT_EQ(picture_in(upright).elements(), page.screen->reply->answer.picture.elements());
}

TEST(StatePages, SayWhyThereIsNoPictureOfTheScreen) {
  auto page = page_of(kGoodStatus);
  page.screen = ScreenPart{"secret", {}};
  auto html = state_page(page, *parse_language("de"));
  EXPECT_THAT(html, HasSubstr("An der Station ausgeschaltet"));
  EXPECT_THAT(html, Not(HasSubstr("<form")));
  page = page_of(kScreenStatus);
  const auto said = [&](ScreenReply reply) {
    page.screen = ScreenPart{"secret", std::move(reply)};
    return state_page(page, Language::english);
  };
  EXPECT_THAT(said({ScreenOutcome::wait, {{}, {}, std::chrono::seconds(37)}, {}}),
              HasSubstr("possible in</strong> 37 s"));
  EXPECT_THAT(said({ScreenOutcome::nothing, {}, {}}), HasSubstr("Nothing is on the screen."));
  EXPECT_THAT(said({}), HasSubstr("Switched off at the kiosk"));
  html = said({ScreenOutcome::no_answer, {}, "<b>no answer in time"});
  EXPECT_THAT(html, HasSubstr("The kiosk gave no picture.</strong> <q lang=\"en\">&lt;b&gt;no answer in time</q>"));
}

TEST(StatePages, OfASilentKioskClaimNothing) {
  auto page = page_of(kGoodStatus);
  page.heard = {Contact::silent, std::nullopt, "/run/kasumi/status.json: not written for 20 s", {}};
  const auto html = state_page(page, Language::english);
  EXPECT_THAT(html, HasSubstr("What visitors see is not known."));
  EXPECT_THAT(html, Not(HasSubstr("2.41")));
}

TEST(StatePages, NothingThatTheKioskTellsActsInIt) {
  const auto evil = changed(kLostStatus, "unplugged", "<script>alert(1)</script>' onload=\\\"x\\\" &amp;");
  auto page = page_of(evil);
  page.name = "<img src=x>";
  const auto html = state_page(page, Language::english);
  EXPECT_THAT(html, Not(HasSubstr("<script")));
  EXPECT_THAT(html, Not(HasSubstr("<img")));
  EXPECT_THAT(html, HasSubstr("&lt;script&gt;alert(1)&lt;/script&gt;&#39; onload=&quot;x&quot; &amp;amp;"));
}

TEST(StatePages, SpeakTheLanguageThatIsAskedFor) {
  EXPECT_EQ(wanted_language("ja", "de", *parse_language("fr")), *parse_language("ja"));
  EXPECT_EQ(wanted_language("", "pt-BR, de-CH;q=0.8, en", *parse_language("fr")), *parse_language("de"));
  EXPECT_EQ(wanted_language("xx", "", *parse_language("fr")), *parse_language("fr"));
  EXPECT_EQ(wanted_language("", std::string(10000, ','), *parse_language("it")), *parse_language("it"));
}

// A reporter with a day behind it, by the machine's clock.
std::unique_ptr<RunningReporter> with_a_day(const std::string& name, const std::string& more = {}) {
  auto reporter = std::make_unique<RunningReporter>(name, more);
  auto ring = HistoryRing::open(reporter->folder / kHistoryFile);
  EXPECT_TRUE(ring);
  auto text = read_text_file(reporter->folder / kHistoryFile).value();
  for (const auto& line : day_until(std::chrono::system_clock::now()))
    text.replace((1 + line.number % kHistoryLines) * kHistoryLineBytes, kHistoryLineBytes, history_text(line));
  EXPECT_TRUE(write_text_file(reporter->folder / kHistoryFile, text));
  reporter->tell(kLostStatus);
  EXPECT_TRUE(within(10, [&] { return reporter->get("/").find("unplugged") != std::string::npos; }));
  return reporter;
}

TEST(StatePages, AreServedWithTheirStyleAndNoScript) {
  const auto reporter = with_a_day("page");
  const auto page = reporter->get("/", "Accept-Language: fr\r\n");
  EXPECT_THAT(page, HasSubstr("Content-Type: text/html; charset=utf-8"));
  EXPECT_THAT(page, HasSubstr("Content-Security-Policy: default-src 'none'"));
  EXPECT_THAT(page, HasSubstr("<html lang=\"fr\">"));
  EXPECT_THAT(page, Not(HasSubstr("<script")));
  EXPECT_THAT(page, Not(HasSubstr("Set-Cookie")));
  EXPECT_THAT(page, Not(HasSubstr("style=\"")));
  EXPECT_THAT(page, Not(HasSubstr("https://")));
  EXPECT_THAT(reporter->get("/style.css"), HasSubstr("text/css"));
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  EXPECT_LT(reporter->child().memory_kb(), 20 * 1024);
#endif
}

// In a real browser, at a telephone's width, with axe-core's rules for WCAG 2.2 AA.
TEST(StatePages, ABrowserFindsThemAccessibleAndNarrowEnough) {
  if (!is_installed("chromium")) GTEST_SKIP() << "chromium is not installed";
  if (!std::filesystem::exists(axe_core())) GTEST_SKIP() << "axe-core is not there: ./bootstrap browser";
  const auto reporter = with_a_day("browser", "screen_picture = true\n");
  const auto lost = changed(kLostStatus, "\"pid\"", "\"screen_picture\": {\"allowed\": true, \"taken\": 1}, \"pid\"");
  for (const Language language : all_languages()) {
    // An appliance that goes on telling.
    reporter->tell(
        changed(lost, "\"pictures\": 9000", fmt::format("\"pictures\": {}", 9001 + static_cast<int>(language))));
    EXPECT_TRUE(within(10, [&] { return reporter->get("/").find("<button>") != std::string::npos; }));
    // The page as it is served, its style within, and the rules beside it.
    auto html = reporter->get(fmt::format("/?language={}", code_of(language)));
    html.erase(0, html.find("\r\n\r\n") + 4);
    html =
        changed(html, "<link rel=\"stylesheet\" href=\"style.css\">", fmt::format("<style>{}</style>", page_style()));
    const auto result = seen_by_axe(reporter->folder, html);
    ASSERT_TRUE(result.is_object());
    EXPECT_GT(result["passes"], 20) << "the rules did not run";
    EXPECT_EQ(result["violations"].dump(), "[]") << code_of(language);
    EXPECT_LE(result["wide"], 0) << "it must not scroll sideways";
  }
}

// For docs/: KASUMI_STATE_PAGES names a folder, which gets a PNG of each.
TEST(StatePages, AreSeenByDayInTroubleOnATelephoneAndDark) {
  const char* folder = std::getenv("KASUMI_STATE_PAGES");
  if (!folder) GTEST_SKIP() << "only for docs/make-pictures";
  auto unseen = changed(changed(kGoodStatus, "\"live\", \"reason\": \"\"", "\"nothing\", \"reason\": \"no screen\""),
                        "\"display\": {\"up\": true, \"description\": \"HDMI-A-1\", \"cause\": \"\"",
                        "\"display\": {\"up\": false, \"cause\": \"HDMI-A-1: nothing is connected\"");
  const std::pair<const char*, std::tuple<std::string, Language, const char*>> pages[] = {
      {"day", {kGoodStatus, Language::english, "--window-size=900,1250"}},
      {"trouble", {kLostStatus, Language::english, "--window-size=900,1250"}},
      {"telephone", {kLostStatus, *parse_language("de"), "--window-size=500,1250"}},
      {"dark", {unseen, Language::english, "--window-size=900,1250 --blink-settings=preferredColorScheme=0"}}};
  for (const auto& [name, page] : pages) {
    const auto& [status, language, how] = page;
    const auto html = changed(state_page(page_of(status), language), "<link rel=\"stylesheet\" href=\"style.css\">",
                              fmt::format("<style>{}</style>", page_style()));
    ASSERT_TRUE(write_text_file(std::filesystem::path(folder) / "page.html", html));
    ASSERT_EQ(
        std::system(browser(folder, fmt::format("{} --screenshot={}/{}.png", how, folder, name), "page.html").c_str()),
        0);
  }
}

}  // namespace
}  // namespace kasumi::report
