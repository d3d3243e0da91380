// The languages that visitors and operators are spoken to in.
#pragma once

#include <string_view>

#include "base/result.hpp"

namespace kasumi {

enum class Language { english, german, french, italian, spanish, japanese };
inline constexpr Language kLanguages[] = {Language::english, Language::german,  Language::french,
                                          Language::italian, Language::spanish, Language::japanese};

// ISO 639: "en", "de", "fr", "it", "es", "ja". Error (bad_input): any other code.
Result<Language> parse_language(std::string_view code);
std::string_view code_of(Language language);

}  // namespace kasumi
