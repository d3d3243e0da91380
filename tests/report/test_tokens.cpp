// Who is admitted, and what guessing costs.
#include <gmock/gmock.h>

#include <set>

#include "base/utc_text.hpp"
#include "report/page/tokens.hpp"

namespace kasumi::report {
namespace {

using namespace std::chrono_literals;

class TokenTests : public testing::Test {
 protected:
  ManualClock clock{*parse_utc("2026-06-21T09:00:00Z")};
  NewToken mine = new_token().value(), other = new_token().value();
  Tokens tokens{{{"other", other.hash, std::nullopt}, {"mine", mine.hash, *parse_utc("2026-06-22T00:00:00Z")}}, clock};
};

TEST_F(TokenTests, TheRightOneIsAdmittedAsBearerAndAsPassword) {
  EXPECT_EQ(tokens.admit("Bearer " + mine.token), Admission::admitted);
  EXPECT_EQ(tokens.admit("Bearer " + other.token), Admission::admitted);
}

TEST_F(TokenTests, ABrowserSendsItAsPassword) {
  // "kiosk:" and the token, by RFC 4648.
  constexpr std::string_view kLetters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const auto both = "kiosk:" + mine.token;
  std::string encoded;
  for (std::size_t i = 0; i < both.size(); i += 3) {
    unsigned group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (i + k < both.size() ? static_cast<unsigned char>(both[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) encoded += i + k <= both.size() ? kLetters[group >> (18 - 6 * k) & 63u] : '=';
  }
  EXPECT_EQ(tokens.admit("Basic " + encoded), Admission::admitted);
}

TEST_F(TokenTests, EverythingElseIsRefused) {
  EXPECT_EQ(tokens.admit(""), Admission::none);
  for (const std::string& header : {std::string("Bearer "), "Bearer " + mine.token.substr(1), std::string("bearer"),
                                    mine.token, std::string("Basic ####"), "Digest " + mine.token,
                                    "Bearer " + std::string(100000, 'x'), "Bearer " + mine.hash}) {
    clock.advance(1s);
    EXPECT_EQ(tokens.admit(header), Admission::wrong) << header.substr(0, 40);
  }
}

// A token that somebody overheard and plays again: no longer than it is valid, and not after it was taken out.
TEST_F(TokenTests, AnExpiredOneIsRefusedHoweverOftenItIsReplayed) {
  EXPECT_EQ(tokens.admit("Bearer " + mine.token), Admission::admitted);
  clock.advance(24h);
  EXPECT_EQ(tokens.admit("Bearer " + mine.token), Admission::expired);
  EXPECT_EQ(tokens.admit("Bearer " + mine.token), Admission::expired);
  EXPECT_EQ(tokens.admit("Bearer " + other.token), Admission::admitted);
  Tokens rotated({{"mine", new_token().value().hash, std::nullopt}}, clock);
  EXPECT_EQ(rotated.admit("Bearer " + mine.token), Admission::wrong);
}

TEST_F(TokenTests, GuessesAreBoundedAndDoNotKeepOutWhoIsKnown) {
  ASSERT_EQ(tokens.admit("Bearer " + mine.token), Admission::admitted);
  clock.advance(1s);
  int looked = 0;
  for (int i = 0; i < 100; ++i) looked += tokens.admit(fmt::format("Bearer {}", i)) == Admission::wrong;
  EXPECT_EQ(looked, 5);
  EXPECT_EQ(tokens.admit("Bearer 101"), Admission::too_many);
  EXPECT_EQ(tokens.admit("Bearer " + mine.token), Admission::admitted);
  clock.advance(1s);
  EXPECT_EQ(tokens.admit("Bearer 102"), Admission::wrong);
}

TEST_F(TokenTests, Row28GuessesFromElsewhereDoNotKeepTheOwnerOut) {
  for (int i = 0; i < 100; ++i) tokens.admit(fmt::format("Bearer {}", i), "203.0.113.7");
  EXPECT_EQ(tokens.admit("Bearer x", "203.0.113.7"), Admission::too_many);
  EXPECT_EQ(tokens.admit("bearer " + mine.token, "192.0.2.1"), Admission::admitted) << "in any case of letters";
  clock.advance(1s);
  // From so many places that all guesses of a second are used up: who was here before still is.
  for (int i = 0; i < 2000; ++i) tokens.admit("Bearer x", fmt::format("198.51.{}.{}", i / 250, i % 250));
  EXPECT_EQ(tokens.admit("Bearer " + other.token, "192.0.2.2"), Admission::too_many);
  clock.advance(1s);
  for (int i = 0; i < 2000; ++i) tokens.admit("Bearer x", fmt::format("198.51.{}.{}", i / 250, i % 250));
  EXPECT_EQ(tokens.admit("Bearer " + other.token, "192.0.2.1"), Admission::admitted);
}

TEST(NewTokens, AreLongDifferentAndKeptAsYescrypt) {
  std::set<std::string> made;
  for (int i = 0; i < 20; ++i) made.insert(new_token().value().token);
  EXPECT_EQ(made.size(), 20U);
  const auto token = new_token().value();
  EXPECT_EQ(token.token.size(), 26U);
  EXPECT_TRUE(token.hash.starts_with("$y$")) << token.hash;
  EXPECT_TRUE(is_usable_hash(token.hash));
  for (const auto* hash : {"", "secret", "$", "$y$", "$0$abc", "*0", "$nosuch$salt$hash",
                           // Those would take minutes, or all memory.
                           "$y$jZT$salt$hash", "$2b$31$abcdefghijklmnopqrstuu", "$6$rounds=99999999$salt$hash",
                           "$sha1$99999999$salt$hash", "$7$ZU....salt$hash"})
    EXPECT_FALSE(is_usable_hash(hash)) << hash;
}

}  // namespace
}  // namespace kasumi::report
