// What visitors see, what is wrong and what to do about it, in the operators' language.
#pragma once

#include <string>
#include <string_view>

#include "base/words/language.hpp"
#include "report/diagnosis/diagnosis.hpp"

namespace kasumi::report {

// "Visitors see the live view with the building."
std::string_view sight_text(Sight sight, Language language);

struct SymptomWords {
  std::string_view what;        // a sentence
  std::string_view what_to_do;  // a sentence or two
};
SymptomWords symptom_words(Ill ill, Language language);
// The kiosk's own words, and how many more of the kind there are: "a.toml: x: unknown key (and 3 more)".
std::string detail_text(const Symptom& symptom, Language language);

}  // namespace kasumi::report
