#include "base/words/language.hpp"

#include <array>

namespace kasumi {

namespace {

constexpr std::array kCodes{"en", "de", "fr", "it", "es", "ja"};

}  // namespace

Result<Language> parse_language(std::string_view code) {
  for (const Language language : kLanguages)
    if (code == code_of(language)) return language;
  return fail(FaultKind::bad_input, "language \"{}\": expected one of {}", code, fmt::join(kCodes, ", "));
}

std::string_view code_of(Language language) {
  return kCodes[static_cast<std::size_t>(language)];
}

}  // namespace kasumi
