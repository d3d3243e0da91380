// Mail: when it is time for one, what is in it, and a sendmail that fails, hangs or chatters.
#include <gmock/gmock.h>

#include "base/utc_text.hpp"
#include "report/channels/mail_channel.hpp"
#include "report/diagnosis/symptom_words.hpp"
#include "tests/report/running_reporter.hpp"

namespace kasumi::report {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr, testing::Not;

// A watch whose mails are taken at once.
struct Operator {
  explicit Operator(MailMemory memory = {}, Duration pause = 15min) : watch(pause, std::move(memory), clock) {}
  void sees(const Heard& heard, Duration length) {
    for (const auto end = clock.now() + length; clock.now() < end; clock.advance(5s)) {
      watch.look(heard);
      if (auto news = watch.due()) {
        watch.told(*news);
        at.push_back(clock.now().time_since_epoch());
        mails.push_back(std::move(*news));
      }
    }
  }
  ManualClock clock{*parse_utc("2026-06-21T12:00:00Z")};
  MailWatch watch;
  std::vector<MailNews> mails;
  std::vector<Duration> at;
};

TEST(MailWatch, WhatPassesIsNotToldAndWhatLastsIsOnce) {
  Operator me;
  me.sees(kWellKiosk, 10min);
  me.sees(kLostKiosk, 30s);
  me.sees(kWellKiosk, 10min);
  EXPECT_TRUE(me.mails.empty());
  me.sees(kLostKiosk, 2h);
  ASSERT_EQ(me.mails.size(), 1u);
  EXPECT_EQ(me.mails[0].sight, Sight::still);
  EXPECT_EQ(me.mails[0].wrong.at(0).ill, Ill::scene_lost);
  EXPECT_EQ(me.mails[0].wrong.at(0).detail, "unplugged");
  EXPECT_LE(me.at[0], 20min + 30s + 60s) << "within a minute";
  me.sees(kWellKiosk, 2h);
  ASSERT_EQ(me.mails.size(), 2u);
  EXPECT_TRUE(me.mails[1].wrong.empty());
  ASSERT_EQ(me.mails[1].over.size(), 1u);
  EXPECT_EQ(to_seconds(me.mails[1].over[0].to - me.mails[1].over[0].from), 2 * 3600 - 5);
}

// A loose plug: every change within the calm is the same trouble.
TEST(MailWatch, QuickFlappingIsOneTrouble) {
  Operator me;
  for (int i = 0; i < 12 * 60; ++i) {
    me.sees(kLostKiosk, 20s);
    me.sees(kWellKiosk, 40s);
  }
  ASSERT_EQ(me.mails.size(), 1u);
  me.sees(kWellKiosk, 1h);
  ASSERT_EQ(me.mails.size(), 2u);
  EXPECT_EQ(me.mails[1].over.at(0).times, 12 * 60);
}

TEST(MailWatch, SlowFlappingSendsFewMailsThatTellAll) {
  Operator me;
  for (int i = 0; i < 72; ++i) {  // a day
    me.sees(kLostKiosk, 10min);
    me.sees(kWellKiosk, 10min);
  }
  EXPECT_LE(me.mails.size(), 10u);
  EXPECT_GE(me.mails.size(), 5u) << "and not silence";
  me.sees(kWellKiosk, 5h);
  int told = 0;
  for (const auto& mail : me.mails) told += static_cast<int>(mail.over.size()) + mail.more_over;
  EXPECT_EQ(told, 72);
  for (std::size_t i = 1; i < me.at.size(); ++i) EXPECT_GE(to_seconds(me.at[i] - me.at[i - 1]), 15 * 60) << i;
  // Once it holds still, the next is told as fast as the first.
  me.sees(kWellKiosk, 24h);
  const auto before = me.clock.now().time_since_epoch();
  const auto mails = me.mails.size();
  me.sees(kLostKiosk, 2min);
  ASSERT_EQ(me.mails.size(), mails + 1);
  EXPECT_LE(me.at.back() - before, 60s);
}

TEST(MailWatch, AMachineThatStartsAgainAndAgainDoesNotWriteEachTime) {
  MailMemory memory;
  std::size_t mails = 0;
  for (int start = 0; start < 50; ++start) {
    Operator me(memory);
    me.clock.advance(start * 10min);
    me.sees(kLostKiosk, 9min);
    mails += me.mails.size();
    memory = parse_mail_memory(text_of(me.watch.memory()));
    EXPECT_EQ(memory, me.watch.memory());
  }
  EXPECT_EQ(mails, 1u);
  // What ended while it was away is told.
  Operator me(memory);
  me.clock.advance(24h);
  me.sees(kWellKiosk, 20min);
  ASSERT_EQ(me.mails.size(), 1u);
  EXPECT_EQ(me.mails[0].over.at(0).ill, Ill::scene_lost);
}

TEST(MailWatch, AClockThatIsSetBackHoldsNoMailBack) {
  MailMemory memory;
  memory.mailed = *parse_utc("2036-01-01T00:00:00Z");
  Operator me(memory);
  me.sees(kLostKiosk, 20min);
  EXPECT_EQ(me.mails.size(), 1u);
}

TEST(MailWatch, OpeningHoursAndNightsAreNoNews) {
  Operator me;
  const auto closed = heard_of(changed(kGoodStatus, "\"live\", \"reason\": \"\"", "\"dark\", \"reason\": \"closed\""));
  const auto night = heard_of(changed(kGoodStatus, "\"supposed\": false", "\"supposed\": true"));
  for (int day = 0; day < 3; ++day) {
    me.sees(kWellKiosk, 10h);
    me.sees(closed, 7h);
    me.sees(night, 7h);
  }
  EXPECT_TRUE(me.mails.empty());
  me.sees(night, 25h);
  EXPECT_EQ(me.mails.size(), 1u) << "a whole day is";
}

TEST(MailWatch, ATroubleWithoutAKnownReasonIsToldToo) {
  Operator me;
  me.sees(heard_of(changed(kGoodStatus, "\"live\", \"reason\": \"\"", "\"still\", \"reason\": \"of a later version\"")),
          5min);
  ASSERT_EQ(me.mails.size(), 1u);
  EXPECT_EQ(me.mails[0].wrong.at(0).ill, std::nullopt);
  EXPECT_EQ(me.mails[0].wrong.at(0).detail, "of a later version");
  EXPECT_EQ(parse_mail_memory(text_of(me.watch.memory())), me.watch.memory());
}

// It hides the building, not the picture.
TEST(MailWatch, AClockThatIsNotSetIsOneTrouble) {
  Operator me;
  auto text = changed(kGoodStatus, "\"live\", \"reason\": \"\"",
                      fmt::format("\"degraded\", \"reason\": \"{}\"", name_of(Trouble::time_unknown)));
  text = changed(changed(text, "\"building_drawn\": true", "\"building_drawn\": false"), "\"clock_trusted\": true",
                 "\"clock_trusted\": false");
  me.sees(heard_of(text), 2min);
  EXPECT_TRUE(me.mails.empty()) << "a network that comes up sets it";
  me.sees(heard_of(text), 2min);
  ASSERT_EQ(me.mails.size(), 1u);
  EXPECT_EQ(me.mails[0].sight, Sight::no_building);
  ASSERT_EQ(me.mails[0].wrong.size(), 1u);
  EXPECT_EQ(me.mails[0].wrong[0].ill, Ill::clock_unset);
}

TEST(MailWatch, MemoryThatIsBrokenIsNone) {
  EXPECT_EQ(parse_mail_memory(""), MailMemory());
  EXPECT_EQ(parse_mail_memory("told\nmailed yesterday\nheld_back 99999999999\n\n\xff told scene-lost\nno"),
            MailMemory());
  EXPECT_LE(parse_mail_memory("held_back 1000").held_back, 4);
}

MailNews every_trouble() {
  MailNews news{Sight::still, {}, {}, 3};
  const auto from = *parse_utc("2026-06-21T12:34:56Z");
  for (const Ill ill : kAllIlls) news.wrong.push_back({ill, std::string(3000, 'x') + " é日本語\"", from, from + 1h, 7});
  news.wrong.push_back({std::nullopt, "line\nbreak\n.\n", from, from, 1});
  news.over.push_back({Ill::hot, "", from, from + 90min, 2});
  return news;
}

// By a mail program's own reading.
TEST(MailText, IsAMailInEveryLanguage) {
  if (!is_installed("python3")) GTEST_SKIP() << "python3 is not installed";
  MailOptions options;
  options.to = {"me@example.org", "you@example.org"};
  options.from = "hill@example.org";
  const auto folder = report_folder("mail-text");
  for (const Language language : all_languages()) {
    const auto text = mail_text(every_trouble(), options, "Hügel\r\nBcc: x@y.z\r\n\r\n日本", language, 15min);
    ASSERT_TRUE(write_text_file(folder / "mail", text));
    const auto read =
        said_by("python3 -c 'import email, email.policy, sys\nm = email.message_from_binary_file(open(\"" +
                (folder / "mail").string() +
                "\", \"rb\"), policy=email.policy.SMTP)\n"
                "print(sorted(k.lower() for k in m.keys()))\nprint(m[\"to\"])\nprint(repr(m[\"subject\"]))\n"
                "print(m.defects)\nprint(m.get_content())'");
    EXPECT_THAT(read,
                HasSubstr("['auto-submitted', 'content-transfer-encoding', 'content-type', 'from', 'mime-version', "
                          "'subject', 'to']\nme@example.org, you@example.org\n"));
    EXPECT_THAT(read, HasSubstr(std::string(sight_text(Sight::still, language)) + "'\n[]\n"));
    EXPECT_THAT(read, HasSubstr(std::string(symptom_words(Ill::camera_soiled, language).what.substr(0, 20))));
    EXPECT_THAT(read, HasSubstr("2026-06-21 12:34 UTC"));
    for (std::size_t at = 0, end = 0; (end = text.find('\n', at)) != std::string::npos; at = end + 1)
      ASSERT_LE(end - at, 998u);
  }
}

TEST(MailText, AddressesAreAddresses) {
  for (const auto* good : {"me@example.org", "a.b+c@x"}) EXPECT_TRUE(is_mail_address(good)) << good;
  for (const auto* bad : {"", "me", "@x", "x@", "a@b@c", "a b@c", "a@b\nBcc: c@d", "a@b,c@d", "<a@b>", "-oQ/tmp@x"})
    EXPECT_FALSE(is_mail_address(bad)) << bad;
}

// A script that takes the place of sendmail, and what became of it.
class FakeSendmail {
 public:
  FakeSendmail(const std::string& name, const std::string& script) : folder(report_folder("sendmail-" + name)) {
    EXPECT_TRUE(write_text_file(folder / "sendmail", fmt::format("#!/bin/sh\ncd {}\n{}\n", folder.string(), script)));
    std::filesystem::permissions(folder / "sendmail", std::filesystem::perms(0755));
  }
  // The longest that anybody was held up, in s, while the kiosk is ill for `length` of the clock.
  double run(MailChannel& channel, ManualClock& clock, Duration length, Duration step = 1s) const {
    double longest_s = 0.0;
    for (const auto end = clock.now() + length; clock.now() < end; clock.advance(step)) {
      const auto began = std::chrono::steady_clock::now();
      channel.tell(kLostKiosk);
      longest_s = std::max(longest_s, std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count());
      std::this_thread::sleep_for(2ms);
    }
    return longest_s;
  }
  MailOptions options() const {
    MailOptions options;
    options.to = {"me@example.org"};
    options.command = {folder / "sendmail", "-i", "-t"};
    options.memory_file = folder / "memory";
    return options;
  }
  std::string file(const std::string& name) const { return read_text_file(folder / name).value_or(""); }
  const std::filesystem::path folder;
};

class Mail : public testing::Test {
 protected:
  ManualClock clock{*parse_utc("2026-06-21T12:00:00Z")};
};

TEST_F(Mail, IsHandedToSendmailWhole) {
  const FakeSendmail sendmail("good", "echo \"$@\" >arguments; cat >mail.part; mv mail.part mail");
  MailChannel channel(sendmail.options(), "Hill", Language::english, clock);
  sendmail.run(channel, clock, 50s);
  EXPECT_TRUE(within(10, [&] {
    channel.tell(kLostKiosk);
    return channel.sent() == 1;
  }));
  EXPECT_EQ(sendmail.file("arguments"), "-i -t\n");
  EXPECT_THAT(sendmail.file("mail"), HasSubstr("To: me@example.org\nSubject: [Hill] "));
  EXPECT_THAT(sendmail.file("mail"), HasSubstr("unplugged"));
  EXPECT_THAT(sendmail.file("memory"), HasSubstr("told scene-lost\n"));
  sendmail.run(channel, clock, 1h, 10s);
  EXPECT_EQ(channel.sent(), 1u);
}

TEST_F(Mail, ThatFailsIsToldOnceAndTriedAgain) {
  const FakeSendmail sendmail("failing", "echo x >>tries; echo 'no such relay' >&2; exit 69");
  testing::internal::CaptureStderr();
  MailChannel channel(sendmail.options(), "Hill", Language::english, clock);
  for (int i = 0; i < 6; ++i) {
    sendmail.run(channel, clock, 5min, 5s);
    within(5, [&] {
      channel.tell(kLostKiosk);
      return channel.failed() == static_cast<std::uint64_t>(i) + 1;
    });
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            fmt::format("<4>mail: {}: exit code 69: no such relay\n", (sendmail.folder / "sendmail").string()));
  EXPECT_EQ(sendmail.file("tries"), "x\nx\nx\nx\nx\nx\n");
  EXPECT_EQ(channel.sent(), 0u);
  EXPECT_EQ(sendmail.file("memory"), "") << "nothing was told";
}

TEST_F(Mail, ASendmailThatHangsIsKilledWithAllItStarted) {
  const FakeSendmail sendmail("hanging", "trap '' TERM; sleep 1000 & echo $! >child; wait; sleep 1000");
  testing::internal::CaptureStderr();
  MailChannel channel(sendmail.options(), "Hill", Language::english, clock);
  EXPECT_LT(sendmail.run(channel, clock, 50s), 2.0);
  ASSERT_TRUE(within(10, [&] { return !sendmail.file("child").empty(); }));
  const int child = std::stoi(sendmail.file("child"));
  EXPECT_EQ(::kill(child, 0), 0);
  EXPECT_LT(sendmail.run(channel, clock, 62s), 2.0);
  EXPECT_TRUE(within(10, [&] {
    channel.tell(kLostKiosk);
    return channel.failed() == 1;
  }));
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("has not ended in 60 s"));
  const auto is_gone = [&] {
    const auto status = read_text_file(fmt::format("/proc/{}/status", child)).value_or("");
    return status.empty() || status.find("State:\tZ") != std::string::npos;
  };
  EXPECT_TRUE(within(10, is_gone));
}

TEST_F(Mail, ASlowAndAChatteringSendmailHoldNobodyUp) {
  const FakeSendmail slow("slow", "sleep 4; cat >mail; sleep 1");
  MailChannel patient(slow.options(), "Hill", Language::english, clock);
  EXPECT_LT(slow.run(patient, clock, 50s), 2.0);
  EXPECT_TRUE(within(10, [&] {
    patient.tell(kLostKiosk);
    return patient.sent() == 1;
  }));
  EXPECT_THAT(slow.file("mail"), HasSubstr("unplugged"));
  const FakeSendmail chattering("chattering", "exec yes");
  testing::internal::CaptureStderr();
  MailChannel channel(chattering.options(), "Hill", Language::english, clock);
  EXPECT_LT(chattering.run(channel, clock, 3min), 2.0);
  EXPECT_TRUE(within(10, [&] {
    channel.tell(kLostKiosk);
    return channel.failed() == 1;
  }));
  EXPECT_LT(testing::internal::GetCapturedStderr().size(), 1000u);
}

TEST_F(Mail, AProgramThatIsNotThereIsToldAtTheStart) {
  auto options = FakeSendmail("missing", "").options();
  options.command = {"/nowhere/sendmail"};
  testing::internal::CaptureStderr();
  MailChannel channel(options, "Hill", Language::english, clock);
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            "<4>mail: /nowhere/sendmail: no such program: no mail can be sent\n");
}

}  // namespace
}  // namespace kasumi::report
