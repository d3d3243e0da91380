// The texts that visitors and operators read: those of base/words/languages, compiled in.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "base/words/language.hpp"

namespace kasumi {

// The entry "mail.since" of a language's file. Empty: no such entry (tests/house finds who asks for one).
std::string_view text_of(std::string_view key, Language language);

// With its {placeholders} filled: filled_text("mail.times", language, fmt::arg("count", 3)).
template <class... Arguments>
std::string filled_text(std::string_view key, Language language, const Arguments&... arguments) {
  return fmt::format(fmt::runtime(text_of(key, language)), arguments...);
}

struct LanguageTexts {
  std::string_view code, name;              // "de", "Deutsch"
  std::span<const std::string_view> texts;  // in the order of text_keys()
};
std::span<const std::string_view> text_keys();    // sorted
std::span<const LanguageTexts> language_texts();  // English first

}  // namespace kasumi
