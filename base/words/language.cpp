#include "base/words/language.hpp"

#include <algorithm>

#include "base/words/texts.hpp"

namespace kasumi {

namespace {

const LanguageTexts& texts_of(Language language) {
  return language_texts()[static_cast<std::size_t>(language)];
}

}  // namespace

std::vector<Language> all_languages() {
  std::vector<Language> languages;
  for (std::size_t i = 0; i < language_texts().size(); ++i) languages.push_back(Language{i});
  return languages;
}

Result<Language> parse_language(std::string_view code) {
  for (const Language language : all_languages())
    if (code == code_of(language)) return language;
  return fail(FaultKind::bad_input, "language \"{}\": expected one of {}", code, language_codes());
}

std::string_view code_of(Language language) {
  return texts_of(language).code;
}

std::string_view name_of(Language language) {
  return texts_of(language).name;
}

std::string language_codes() {
  std::vector<std::string_view> codes;
  for (const Language language : all_languages()) codes.push_back(code_of(language));
  return fmt::format("{}", fmt::join(codes, ", "));
}

std::string_view text_of(std::string_view key, Language language) {
  const auto keys = text_keys();
  const auto found = std::ranges::lower_bound(keys, key);
  if (found == keys.end() || *found != key) return {};
  return texts_of(language).texts[static_cast<std::size_t>(found - keys.begin())];
}

}  // namespace kasumi
