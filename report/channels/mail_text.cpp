#include "report/channels/mail_text.hpp"

#include <algorithm>

#include "base/utc_text.hpp"
#include "base/words/texts.hpp"
#include "report/diagnosis/symptom_words.hpp"

namespace kasumi::report {

namespace {

constexpr std::size_t kLine = 76, kLongestLine = 900, kLongestDetail = 2000;

bool begins_character(char c) {
  return (static_cast<unsigned char>(c) & 0xc0u) != 0x80u;
}

// At most so many bytes, whole characters.
std::string_view first_bytes(std::string_view text, std::size_t most) {
  if (text.size() <= most) return text;
  while (most > 0 && !begins_character(text[most])) --most;
  return text.substr(0, most);
}

// RFC 2047: what is not ASCII in words of at most 75 characters, each of whole UTF-8 characters.
std::string in_header(std::string_view text) {
  const bool plain = std::ranges::all_of(text, [](char c) { return c >= 0x20 && c < 0x7f; });
  if (plain && text.size() < kLine && text.find("=?") == std::string_view::npos) return std::string(text);
  constexpr std::string_view kBegin = "=?UTF-8?Q?", kEnd = "?=";
  std::string coded(kBegin);
  std::size_t length = kBegin.size();
  while (!text.empty()) {
    std::size_t n = 1;
    while (n < text.size() && !begins_character(text[n])) ++n;
    std::string one;
    for (const char c : text.substr(0, n)) {
      const bool safe = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
      one += safe ? std::string(1, c) : fmt::format("={:02X}", static_cast<unsigned char>(c));
    }
    if (length + one.size() + kEnd.size() > 75) {
      coded += fmt::format("{}\n {}", kEnd, kBegin);
      length = kBegin.size();
    }
    coded += one;
    length += one.size();
    text.remove_prefix(n);
  }
  return coded + std::string(kEnd);
}

// Lines that are indented by so much, broken at spaces.
std::string wrapped(std::string_view text, std::string_view first, std::string_view others) {
  std::string lines(first);
  std::size_t length = first.size();
  bool begun = false;
  const auto new_line = [&] {
    lines += fmt::format("\n{}", others);
    length = others.size();
    begun = false;
  };
  while (!text.empty()) {
    const auto end = std::min(text.find(' '), text.size());
    auto word = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (begun && length + 1 + word.size() > kLine) new_line();
    for (; word.size() > kLongestLine; new_line()) {
      const auto part = first_bytes(word, kLongestLine);
      lines += part;
      word.remove_prefix(part.size());
    }
    if (begun) lines += ' ';
    lines += word;
    length += word.size() + 1;
    begun = true;
  }
  return lines + "\n";
}

// "2026-11-24 14:10 UTC"
std::string minute_text(Utc utc) {
  auto text = utc_text(std::chrono::floor<std::chrono::minutes>(utc)).substr(0, 16);
  std::ranges::replace(text, 'T', ' ');
  return text + " UTC";
}

std::string times_text(const Episode& episode, Language language) {
  return episode.times > 1 ? ", " + filled_text("mail.times", language, fmt::arg("count", episode.times))
                           : std::string();
}

std::string header_text(const MailOptions& options, const std::string& name, std::string_view subject) {
  std::string text;
  if (!options.from.empty()) text += fmt::format("From: {}\n", options.from);
  text += fmt::format("To: {}\n", fmt::join(options.to, ",\n "));
  text += fmt::format("Subject: {}\n", in_header(fmt::format("[{}] {}", first_bytes(name, 100), subject)));
  return text +
         "Auto-Submitted: auto-generated\nMIME-Version: 1.0\nContent-Type: text/plain; charset=utf-8\n"
         "Content-Transfer-Encoding: 8bit\n\n";
}

}  // namespace

bool is_mail_address(std::string_view text) {
  const auto at = text.find('@');
  if (text.size() > 200 || at == std::string_view::npos || at == 0 || at + 1 == text.size()) return false;
  if (text.find('@', at + 1) != std::string_view::npos || text.front() == '-') return false;
  return std::ranges::all_of(text, [](char c) {
    return c > 0x20 && c < 0x7f && std::string_view(",;:<>()[]\"\\").find(c) == std::string_view::npos;
  });
}

std::string mail_text(const MailNews& news, const MailOptions& options, const std::string& name, Language language,
                      Duration next) {
  const auto seen = sight_text(news.sight, language);
  auto text = header_text(options, name, seen);
  text += wrapped(seen, "", "");
  text += fmt::format(
      "\n{}\n", news.wrong.empty() ? text_of("figure.nothing_wrong", language) : text_of("figure.wrong", language));
  for (const auto& episode : news.wrong) {
    const auto words = episode.ill ? symptom_words(*episode.ill, language) : SymptomWords{};
    text += "\n" + wrapped(episode.ill ? words.what : text_of("mail.no_reason", language), "- ", "  ");
    if (!episode.detail.empty()) text += wrapped(first_bytes(episode.detail, kLongestDetail), "  ", "  ");
    text += wrapped(filled_text("mail.since", language, fmt::arg("time", minute_text(episode.from))) +
                        times_text(episode, language),
                    "  ", "  ");
    if (!episode.ill) continue;
    text += wrapped(words.what_to_do, "  -> ", "     ");
    text += fmt::format("     {}\n", command_for(*episode.ill));
  }
  if (!news.over.empty()) text += fmt::format("\n{}\n", text_of("mail.over", language));
  for (const auto& episode : news.over) {
    const auto what = episode.ill ? symptom_words(*episode.ill, language).what : seen;
    text += "\n" + wrapped(what, "- ", "  ");
    text += wrapped(filled_text("mail.from_to", language, fmt::arg("from", minute_text(episode.from)),
                                fmt::arg("to", minute_text(episode.to))) +
                        times_text(episode, language),
                    "  ", "  ");
  }
  if (news.more_over > 0)
    text += "\n" + wrapped(filled_text("mail.more", language, fmt::arg("count", news.more_over)), "", "");
  text += "\n" + wrapped(filled_text("mail.next", language,
                                     fmt::arg("minutes", std::chrono::ceil<std::chrono::minutes>(next).count())),
                         "", "");
  return text;
}

std::string trial_mail(const MailOptions& options, const std::string& name, Language language, Sight sight) {
  return header_text(options, name, text_of("mail.trial", language)) +
         wrapped(text_of("mail.trial_says", language), "", "") + "\n" + wrapped(sight_text(sight, language), "", "");
}

}  // namespace kasumi::report
