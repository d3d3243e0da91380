#include "pipeline/show/stage/words_on_glass.hpp"

#include "pipeline/show/stage/words.hpp"

namespace kasumi {

std::vector<std::string> words_that_cannot_be_read(const RunConfig& config) {
  constexpr int kWidth = 1280, kHeight = 720;  // letters grow with the screen
  const CaptionStyle style = style_of(config.messages, kWidth, kHeight);
  std::vector<std::string> faults;
  const auto read = [&](const std::string& where, const std::string& text) {
    const auto found = caption_faults(text, style);
    if (!found) faults.push_back(fmt::format("{}: {}", where, found.error().message));
    if (found)
      for (const auto& fault : *found) faults.push_back(fmt::format("{}: {}", where, fault));
  };
  if (!config.still.caption.empty()) read("still.caption", config.still.caption);
  for (const Era& era : config.eras)
    if (era.caption) read(fmt::format("era \"{}\": caption", era.name), *era.caption);
  const auto read_messages = [&](const std::string& where, Language language) {
    std::string messages;
    if (config.messages.show_faults)
      for (const Message message : kMessages) messages += std::string(message_text(message, language)) + " ";
    if (messages.empty()) return;
    CaptionStyle all = style;
    all.language = code_of(language);
    all.most_lines = 100;
    if (const auto found = caption_faults(messages, all))
      for (const auto& fault : *found) faults.push_back(fmt::format("{}: {}", where, fault));
  };
  read_messages("words.language", config.messages.language);
  if (config.visitor)
    for (const auto language : config.visitor->languages.empty() ? all_languages() : config.visitor->languages)
      if (language != config.messages.language)
        read_messages(fmt::format("visitor.languages: {}", code_of(language)), language);
  return faults;
}

}  // namespace kasumi
