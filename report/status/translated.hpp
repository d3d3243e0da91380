// A text in every language that operators are spoken to in.
#pragma once

#include <string_view>

#include "base/words/language.hpp"

namespace kasumi::report {

struct Translated {
  std::string_view english, german, french, italian, spanish, japanese;

  constexpr std::string_view in(Language language) const {
    switch (language) {
      case Language::english: return english;
      case Language::german: return german;
      case Language::french: return french;
      case Language::italian: return italian;
      case Language::spanish: return spanish;
      case Language::japanese: return japanese;
    }
    return english;
  }
};

}  // namespace kasumi::report
