// The languages that visitors and operators are spoken to in: one for each file in base/words/languages.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"

namespace kasumi {

// The others: parse_language().
enum class Language : std::size_t { english };

// In the order in which people choose from them, English first.
std::vector<Language> all_languages();
// Of ISO 639: "en", "de". Error (bad_input): any other code.
Result<Language> parse_language(std::string_view code);
std::string_view code_of(Language language);
// In itself: "Deutsch".
std::string_view name_of(Language language);
// "en, de, fr".
std::string language_codes();

}  // namespace kasumi
