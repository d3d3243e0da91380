// The languages' files: that each is what is compiled in, that every entry is used, and that faults are named.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <toml++/toml.h>

#include "base/words/texts.hpp"
#include "tests/house/repository.hpp"
#include "tests/house/source_files.hpp"

namespace kasumi::house {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

fs::path languages_folder() {
  return source_folder() / "base/words/languages";
}

void flatten(const toml::table& table, const std::string& section, std::map<std::string, std::string>& entries) {
  for (const auto& [key, value] : table) {
    const auto name = section + std::string(key.str());
    if (const auto* inner = value.as_table()) flatten(*inner, name + ".", entries);
    if (const auto text = value.value<std::string>()) entries[name] = *text;
  }
}

TEST(Translations, AreWhatTheFilesSay) {
  std::size_t files = 0;
  for (const auto& entry : fs::directory_iterator(languages_folder())) {
    ++files;
    const auto language = parse_language(entry.path().stem().string());
    ASSERT_TRUE(language) << entry.path();
    std::map<std::string, std::string> entries;
    flatten(toml::parse_file(entry.path().string()), {}, entries);
    EXPECT_EQ(name_of(*language), entries["name"]);
    entries.erase("name");
    EXPECT_EQ(entries.size(), text_keys().size()) << entry.path();
    for (const auto& [key, text] : entries) EXPECT_EQ(kasumi::text_of(key, *language), text) << key;
  }
  EXPECT_EQ(files, all_languages().size());
}

// Sections whose keys are names of an enumeration are compared with it in tests/report/test_diagnosis.cpp.
TEST(Translations, EveryEntryIsUsedAndEveryUsedOneExists) {
  const std::regex use(R"re("((?:screen|figure|page|mail|hand|hint)\.[a-z_]+)"[,;:)} ])re");
  std::set<std::string> used, known;
  for (const auto* room : {"base", "history", "pipeline", "report"})
    for (const auto& file : source_files(room)) {
      const auto code = read_text_file(source_folder() / file.name).value();
      for (auto at = std::sregex_iterator(code.begin(), code.end(), use); at != std::sregex_iterator(); ++at)
        if (!(*at)[1].str().ends_with(".sock")) used.insert((*at)[1]);
    }
  for (const auto key : text_keys())
    if (!key.starts_with("sight.") && !key.starts_with("symptom.")) known.emplace(key);
  EXPECT_EQ(used, known);
}

struct EmbeddingRun {
  bool done = false;
  std::string said, made;
};

EmbeddingRun embedding_of(const fs::path& folder) {
  std::string files;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".toml") files += (files.empty() ? "" : ";") + entry.path().string();
  const auto made = folder / "texts.cpp", said = folder / "said";
  const auto command = fmt::format("cmake '-DOUT={}' '-DLANGUAGES={}' -P '{}' >'{}' 2>&1", made.string(), files,
                                   (source_folder() / "base/words/embed_languages.cmake").string(), said.string());
  EmbeddingRun run;
  run.done = std::system(command.c_str()) == 0;
  run.said = read_text_file(said).value();
  if (run.done) run.made = read_text_file(made).value();
  return run;
}

fs::path copied_languages() {
  const auto folder = test_output_folder() / "languages";
  fs::remove_all(folder);
  fs::create_directories(folder.parent_path());
  fs::copy(languages_folder(), folder);
  return folder;
}

TEST(Translations, AFaultIsNamedByFileAndKey) {
  struct Fault {
    const char *was, *is;
    std::vector<std::string> said;
  };
  for (const auto& [was, is, said] : std::vector<Fault>{
           {"\nsince = ", "\n# since = ", {"fr.toml: mail.since: missing", "Since {time}"}},
           {"\nsince = ", "\nsinse = ", {"fr.toml: mail.since: missing", "fr.toml: mail.sinse: en.toml has no such"}},
           {"Depuis {time}",
            "Depuis {temps}",
            {"fr.toml: mail.since: has the placeholders {temps}", "en.toml has {time}"}},
           {"Du {from} au", "Du au", {"fr.toml: mail.from_to: has the placeholders {to}", "en.toml has {from}, {to}"}},
           {"Depuis {time}", "Depuis", {"fr.toml: mail.since: has the placeholders none", "en.toml has {time}"}},
           {"Depuis {time}", "Depuis {time} {", {"fr.toml: mail.since: expected braces"}},
           {"Depuis {time}", "\\tDepuis {time}", {"fr.toml: mail.since: expected quotes and backslashes"}},
           {"Depuis {time}", "", {"fr.toml: mail.since: empty"}},
           {"\nsince = ", "\nsince = \"{time}\"\nsince = ", {"fr.toml: mail.since: stands there twice"}},
           {"\nsince = ", "\nsince : ", {"fr.toml: line", "expected [section]", "since :"}},
           {"place = ", "# place = ", {"fr.toml: place: missing"}}}) {
    SCOPED_TRACE(is);
    const auto folder = copied_languages();
    auto text = read_text_file(folder / "fr.toml").value();
    const auto at = text.find(was);
    ASSERT_NE(at, std::string::npos) << was;
    text.replace(at, std::string(was).size(), is);
    std::ofstream(folder / "fr.toml") << text;
    const auto run = embedding_of(folder);
    EXPECT_FALSE(run.done);
    for (const auto& words : said) EXPECT_THAT(run.said, HasSubstr(words));
  }
}

TEST(Translations, AFileMoreIsALanguageMore) {
  const auto folder = copied_languages();
  auto text = read_text_file(folder / "de.toml").value();
  text.replace(text.find("\"Deutsch\""), 9, "\"Nederlands\"");
  text.replace(text.find("place = 2"), 9, "place = 10");
  std::ofstream(folder / "nl.toml") << text;
  const auto run = embedding_of(folder);
  EXPECT_TRUE(run.done) << run.said;
  EXPECT_THAT(run.made, testing::ContainsRegex("\"ja\", \"日本語\", k_ja},\n    .\"nl\", \"Nederlands\", k_nl},"));
  fs::rename(folder / "nl.toml", folder / "dutch.toml");
  EXPECT_THAT(embedding_of(folder).said, HasSubstr("dutch.toml: expected the file to be named by the language's code"));
}

}  // namespace
}  // namespace kasumi::house
