#include "report/show.hpp"

#include "report/diagnosis/symptom_words.hpp"

namespace kasumi::report {

std::string state_text(const Heard& heard, Language language) {
  const auto diagnosis = diagnose(heard);
  auto text = fmt::format("{}\n", sight_text(diagnosis.sight, language));
  for (const auto& symptom : diagnosis.symptoms) {
    const auto words = symptom_words(symptom.ill, language);
    text += fmt::format("\n{}\n", words.what);
    if (!symptom.detail.empty()) text += fmt::format("  {}\n", detail_text(symptom, language));
    text += fmt::format("  -> {}\n     {}\n", words.what_to_do, command_for(symptom.ill));
  }
  return text;
}

}  // namespace kasumi::report
