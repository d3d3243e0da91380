#include "pipeline/site/config/visitor_content.hpp"

#include <algorithm>
#include <set>

#include "base/table/config_table.hpp"
#include "base/words/nearest_word.hpp"

namespace kasumi {

namespace {

constexpr std::size_t kMostLanguages = 24, kMostStories = 200;
constexpr std::size_t kMostTitleBytes = 400, kMostTextBytes = 10'000;  // the panel's layout is bounded by them
constexpr double kFarthestPlace_m = 100e3;

bool is_language_code(const std::string& code) {
  return (code.size() == 2 || code.size() == 3) &&
         std::ranges::all_of(code, [](char c) { return c >= 'a' && c <= 'z'; });
}

std::vector<std::string> read_languages(const ConfigTable& root) {
  auto codes = root.texts("languages");
  const std::set<std::string> each(codes.begin(), codes.end());
  if (codes.empty() || codes.size() > kMostLanguages || each.size() != codes.size() ||
      !std::ranges::all_of(codes, is_language_code)) {
    root.problem("languages", fmt::format(R"(1 to {} codes of ISO 639, each once, like ["en", "de"])", kMostLanguages));
    return {};
  }
  return codes;
}

// A table of one text for each language.
TextByLanguage read_translations(const ConfigTable& table, std::string_view key,
                                 const std::vector<std::string>& languages, std::size_t most_bytes) {
  TextByLanguage texts;
  const auto of = table.optional_table(key);
  if (!of) {
    if (!table.has(key)) table.problem(key, fmt::format("a text in each of \"{}\"", fmt::join(languages, "\", \"")));
    return texts;
  }
  for (const auto& language : languages) {
    const auto text = of->if_text(language);
    if (!text || text->find_first_not_of(" \t\r\n") == std::string::npos)
      of->problem(language, "a text in this language, which `languages` lists");
    else if (text->size() > most_bytes)
      of->problem(language, fmt::format("{} bytes at most", most_bytes));
    else
      texts[language] = *text;
  }
  return texts;
}

std::vector<std::string> names_of(const std::vector<ModelInEra>& models) {
  std::vector<std::string> names;
  for (const auto& shown : models)
    if (!shown.era.empty()) names.push_back(shown.era);
  return names;
}

std::string an_era(const std::string& typed, const std::vector<std::string>& names) {
  if (names.empty()) return "no era, since kasumi.toml has no [[era]]";
  return fmt::format("the name of an [[era]] of kasumi.toml: \"{}\"{}", fmt::join(names, "\", \""),
                     did_you_mean(typed, names));
}

std::string read_name(const ConfigTable& table, std::set<std::string>& names) {
  auto name = table.text("name");
  if (table.has("name") && !table.if_text("name")) return name;
  if (table.has("name") && (name.empty() || !names.insert(name).second))
    table.problem("name", "a name that no other has");
  return name;
}

// In each of its eras; without eras of its own a story is told wherever its node is.
void check_node(const ConfigTable& table, const Story& story, const std::vector<ModelInEra>& models) {
  std::vector<std::string> known;
  const Model* without = nullptr;
  bool found = false;
  for (const auto& shown : models) {
    if (!is_told_in(story, shown.era) || shown.model->triangle_count() == 0) continue;
    if (place_of(story, *shown.model)) {
      found = true;
      continue;
    }
    without = shown.model;
    for (const auto& node : without->nodes) known.push_back(node.name);
  }
  if (!without || (story.eras.empty() && found)) return;
  table.problem("node", fmt::format("the name of a node of {}{}", without->name, did_you_mean(story.node, known)));
}

Story read_story(const ConfigTable& table, const VisitorContent& content, const std::vector<ModelInEra>& models,
                 std::set<std::string>& names) {
  Story story;
  story.name = read_name(table, names);
  story.eras = table.texts("eras");
  const auto eras = names_of(models);
  for (const auto& era : story.eras)
    if (std::ranges::find(eras, era) == eras.end()) table.problem("eras", an_era(era, eras));
  story.title = read_translations(table, "title", content.languages, kMostTitleBytes);
  story.text = read_translations(table, "text", content.languages, kMostTextBytes);
  const bool has_place = table.has("place_m");
  if (table.has("node") == has_place) {
    table.ignore("node");
    table.ignore("place_m");
    table.problem("node", "either the name of a node of the model, or place_m = [x, y, z] in its metres");
    return story;
  }
  if (has_place) {
    const auto at = table.numbers("place_m", 3, {-kFarthestPlace_m, kFarthestPlace_m});
    const glm::vec3 place(at[0], at[1], at[2]);
    story.place = {place, place};
    (void)table.if_text("node");  // a key that is known
    return story;
  }
  story.node = table.text("node");
  (void)table.if_text("place_m");
  if (table.if_text("node")) check_node(table, story, models);
  return story;
}

}  // namespace

bool is_told_in(const Story& story, const std::string& era) {
  return story.eras.empty() || std::ranges::find(story.eras, era) != story.eras.end();
}

std::optional<ModelBounds> place_of(const Story& story, const Model& model) {
  if (story.node.empty()) return story.place;
  const auto found = std::ranges::find(model.nodes, story.node, &ModelNode::name);
  return found == model.nodes.end() ? std::nullopt : std::optional(found->bounds);
}

Result<VisitorContent> read_visitor_content(const std::filesystem::path& file, const std::vector<ModelInEra>& models) {
  const auto root = ConfigTable::read_file(file);
  if (!root) return fail(root.error());
  VisitorContent content;
  content.file = file;
  content.languages = read_languages(*root);
  const auto eras = root->tables("era"), stories = root->tables("story");
  if (stories.size() > kMostStories) root->problem("story", fmt::format("{} stories at most", kMostStories));
  if (content.languages.empty() || stories.size() > kMostStories) {  // the rest would be noise
    root->ignore("era");
    root->ignore("story");
    if (auto whole = root->finish(); !whole) return fail(whole.error());
  }
  const auto known = names_of(models);
  std::set<std::string> era_names, story_names;
  for (const auto& table : eras) {
    VisitorEra era;
    era.name = read_name(table, era_names);
    if (!era.name.empty() && std::ranges::find(known, era.name) == known.end())
      table.problem("name", an_era(era.name, known));
    era.title = read_translations(table, "title", content.languages, kMostTitleBytes);
    era.text = table.has("text") ? read_translations(table, "text", content.languages, kMostTextBytes) : era.text;
    (void)table.if_text("text");
    content.eras.push_back(std::move(era));
  }
  for (std::size_t i = 0; i < stories.size(); ++i) {
    content.stories.push_back(read_story(stories[i], content, models, story_names));
    content.stories.back().key = fmt::format("story[{}]", i);
  }
  if (auto whole = root->finish(); !whole) return fail(whole.error());
  return content;
}

}  // namespace kasumi
