// A name of a type means one thing in its namespace: two definitions in one program are undefined behaviour that
// neither compiler nor linker reports. And it says which thing: a word that stands in many names distinguishes none.
#include <algorithm>
#include <cctype>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "base/outside/json_text.hpp"
#include "tests/house/repository.hpp"

namespace kasumi::house {
namespace {

bool has_ctags() {
  return std::system("command -v ctags-universal >/dev/null") == 0;
}

// What Universal Ctags finds in these texts: a JSON object a line for each struct, class, union, enum and typedef that
// is defined, not declared.
std::vector<nlohmann::json> types_in(const Texts& texts) {
  const auto folder = test_output_folder() / "one_name";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  std::ofstream list(folder / "files");
  for (const auto& [name, text] : texts) {
    std::filesystem::create_directories((folder / name).parent_path());
    std::ofstream(folder / name) << text;
    list << name << '\n';
  }
  list.close();
  const auto command = fmt::format(
      "cd '{}' && ctags-universal --quiet --options=NONE --output-format=json --language-force=C++ --kinds-C++=csgut "
      "--fields=+nKpS --fields-C++=+{{specialization}} -L files -o tags",
      folder.string());
  if (std::system(command.c_str()) != 0) return {};
  std::vector<nlohmann::json> types;
  for (const auto& line : lines_of(read_text_file(folder / "tags").value()))
    if (auto tag = parse_json(line); tag["_type"] == "tag") types.push_back(std::move(tag));
  std::filesystem::remove_all(folder);
  return types;
}

// "using Rows = std::vector<int>;" from the line where it begins: the same alias twice is one type.
std::string alias_at(const std::string& text, int line) {
  const auto lines = lines_of(text);
  std::string alias;
  for (auto at = static_cast<std::size_t>(line - 1); at < lines.size(); ++at) {
    std::istringstream words(lines[at].substr(0, lines[at].find("//")));
    for (std::string word; words >> word;) alias += (alias.empty() ? "" : " ") + word;
    if (alias.find(';') != std::string::npos) break;
  }
  return alias.substr(0, alias.find(';'));
}

// "kasumi::Haze: a.hpp:3 b.hpp:5" of each name that several files define in one namespace, in the order of names.
// Nested and local types belong to what they stand in, and those of unnamed namespaces to their file.
std::vector<std::string> defined_twice(const Texts& texts, const std::vector<nlohmann::json>& types) {
  std::map<std::string, std::map<std::string, int>> places;            // by name: file and line
  std::map<std::string, std::map<std::string, std::string>> meanings;  // by name and file: what it is
  for (const auto& type : types) {
    const auto scope = type.value("scope", "");
    if (type.value("scopeKind", "namespace") != "namespace" || scope.find("__anon") != std::string::npos) continue;
    const auto name = fmt::format("{}{}{}{}", scope, scope.empty() ? "" : "::", type["name"].get<std::string>(),
                                  type.value("specialization", ""));
    const auto file = type["path"].get<std::string>();
    const int line = type["line"];
    places[name][file] = line;
    meanings[name][file] = type["kind"] == "typedef" ? alias_at(texts.at(file), line) : file;
  }
  std::vector<std::string> found;
  for (const auto& [name, files] : places) {
    const auto& first = meanings[name].begin()->second;
    if (std::ranges::all_of(meanings[name], [&](const auto& one) { return one.second == first; })) continue;
    auto& said = found.emplace_back(name + ":");
    for (const auto& [file, line] : files) said += fmt::format(" {}:{}", file, line);
  }
  return found;
}

std::vector<std::string> defined_twice(const Texts& texts) {
  return defined_twice(texts, types_in(texts));
}

constexpr std::size_t kMostWithAWord = 25;  // chosen: a list that is still read to its end

// "Sky": the names of types in which that word stands, "SkyMask" and "LowSky".
std::map<std::string, std::set<std::string>> names_by_word(const std::vector<nlohmann::json>& types) {
  std::map<std::string, std::set<std::string>> names;
  for (const auto& type : types) {
    const auto name = type["name"].get<std::string>();
    for (std::size_t at = 0; at < name.size();) {
      auto end = at + 1;
      while (end < name.size() && std::isupper(static_cast<unsigned char>(name[end])) == 0) ++end;
      if (name.find("__anon") == std::string::npos) names[name.substr(at, end - at)].insert(name);
      at = end;
    }
  }
  return names;
}

// "26 names with Sky: LowSky SkyMask ..." of each word that stands in too many, the worst first.
std::vector<std::string> worn_words(const std::vector<nlohmann::json>& types) {
  std::vector<std::pair<std::size_t, std::string>> worn;
  for (const auto& [word, names] : names_by_word(types)) {
    if (names.size() <= kMostWithAWord) continue;
    auto& said = worn.emplace_back(names.size(), fmt::format("{} names with {}:", names.size(), word)).second;
    for (const auto& name : names) said += " " + name;
  }
  std::ranges::stable_sort(worn, std::greater{}, &std::pair<std::size_t, std::string>::first);
  std::vector<std::string> said;
  for (auto& [count, words] : worn) said.push_back(std::move(words));
  return said;
}

TEST(OneName, HasNoWordThatManyHave) {
  if (!has_ctags()) GTEST_SKIP() << "no ctags-universal (Debian: universal-ctags)";
  auto texts = texts_ending_in(repository_files(), {".hpp", ".cpp"});
  std::erase_if(texts, [](const auto& file) { return file.first.starts_with("tests/"); });
  const auto types = types_in(texts);
  EXPECT_GT(types.size(), 1500u) << "the files were not read";
  EXPECT_THAT(worn_words(types), testing::IsEmpty()) << "name the new type by its role instead";
}

TEST(OneName, AWornWordWouldBeFound) {
  if (!has_ctags()) GTEST_SKIP() << "no ctags-universal (Debian: universal-ctags)";
  std::string text;
  for (char letter = 'A'; letter < 'Z'; ++letter)
    text += fmt::format("struct {0}aSky {{}};\nstruct {0}aSun {{}};\n", letter);
  EXPECT_THAT(worn_words(types_in({{"a.hpp", text}})), testing::IsEmpty()) << "25 of each";
  text += "namespace b { struct AaSky {}; }\n";
  EXPECT_THAT(worn_words(types_in({{"a.hpp", text}})), testing::IsEmpty()) << "one name twice";
  text += "class Air { enum class SkyKind { open }; };\n";
  EXPECT_THAT(worn_words(types_in({{"a.hpp", text}})),
              testing::ElementsAre(testing::StartsWith("26 names with Sky: ")));
}

TEST(OneName, IsOneType) {
  if (!has_ctags()) GTEST_SKIP() << "no ctags-universal (Debian: universal-ctags)";
  const auto texts = texts_ending_in(repository_files(), {".hpp", ".cpp"});
  const auto types = types_in(texts);
  EXPECT_GT(types.size(), 2000u) << "the files were not read";
  EXPECT_THAT(defined_twice(texts, types), testing::IsEmpty());
}

TEST(OneName, AnOffenderWouldBeFound) {
  if (!has_ctags()) GTEST_SKIP() << "no ctags-universal (Debian: universal-ctags)";
  const auto both = [](const std::string& one, const std::string& other) {
    return defined_twice({{"a/one.hpp", one}, {"b/other.hpp", other}});
  };
  const std::string haze = "namespace kasumi {\nstruct Haze {\n  int depth = 0;\n};\n}\n";
  EXPECT_THAT(both(haze, "namespace kasumi {\n" + haze.substr(haze.find('\n') + 1)),
              testing::ElementsAre("kasumi::Haze: a/one.hpp:2 b/other.hpp:2"));
  for (const std::string other : {"class Haze final : public Air {};", "union Haze { int a; };",
                                  "enum class Haze { kThin };", "using Haze = std::vector<int>;", "typedef int Haze;",
                                  "struct [[nodiscard]] Haze {};", "template <class T>\nstruct Haze {};"})
    EXPECT_THAT(both(haze, "namespace kasumi {\n" + other + "\n}\n"), testing::SizeIs(1)) << other;
  EXPECT_THAT(both("namespace a::b { struct C {}; }", "namespace a { namespace b { struct C {}; } }"),
              testing::SizeIs(1));
  EXPECT_THAT(both("struct C {};", "struct C {};"), testing::SizeIs(1));
  const std::string cells = "namespace a {\nusing Cells = std::map<int, std::vector<int>>;\n}\n";
  EXPECT_THAT(both(cells, "namespace a {\nusing Cells =\n    std::map<int, std::vector<long>>;\n}\n"),
              testing::SizeIs(1));
  EXPECT_THAT(defined_twice({{"a/one.cpp", haze}, {"b/other.cpp", haze}}), testing::SizeIs(1));

  EXPECT_THAT(both(cells, "namespace a {\nusing Cells =\n    std::map<int, std::vector<int>>;  // rows\n}\n"),
              testing::IsEmpty());
  EXPECT_THAT(both("template <class T> struct Of;\ntemplate <> struct Of<int> {};",
                   "template <> struct Of<long> {};\ntemplate <class T> struct Of<T*> {};"),
              testing::IsEmpty());
  EXPECT_THAT(both("namespace a { struct C {}; }", "namespace b { struct C {}; }"), testing::IsEmpty());
  for (const std::string other :
       {"struct Haze;", "class Haze;", "enum class Haze : int;", "struct Air { struct Haze {}; };",
        "namespace {\nstruct Haze {};\n}", "inline void f() { struct Haze {}; }", "using other::Haze;",
        "struct Air { friend struct Haze; };", "Haze haze();  // struct Haze {};"})
    EXPECT_THAT(both(haze, "namespace kasumi {\n" + other + "\n}\n"), testing::IsEmpty()) << other;
}

}  // namespace
}  // namespace kasumi::house
