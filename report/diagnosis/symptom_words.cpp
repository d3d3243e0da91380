#include "report/diagnosis/symptom_words.hpp"

#include "base/words/texts.hpp"

namespace kasumi::report {

std::string_view sight_text(Sight sight, Language language) {
  return text_of(fmt::format("sight.{}", name_of(sight)), language);
}

SymptomWords symptom_words(Ill ill, Language language) {
  const auto entry = fmt::format("symptom.{}", name_of(ill));
  return {text_of(entry + ".what", language), text_of(entry + ".do", language)};
}

std::string detail_text(const Symptom& symptom, Language language) {
  if (symptom.more == 0) return symptom.detail;
  return fmt::format("{} ({})", symptom.detail,
                     filled_text("figure.more_of_kind", language, fmt::arg("count", symptom.more)));
}

}  // namespace kasumi::report
