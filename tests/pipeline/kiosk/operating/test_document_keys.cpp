// Configuration in the documents is what the program accepts: each piece is put into a whole file and read by the reader
// of that file, which must find nothing more to complain of than before.
#include <algorithm>
#include <fstream>
#include <functional>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <toml++/toml.h>

#include "calib/mask/scene_mask.hpp"
#include "calib/mask/scene_planes.hpp"
#include "pipeline/install/calibration_report/scene_sights.hpp"
#include "pipeline/site/config/fixture_file.hpp"
#include "pipeline/site/config/run_config.hpp"
#include "pipeline/site/config/visitor_content.hpp"
#include "report/report_config.hpp"
#include "tests/house/document_code.hpp"
#include "tests/pipeline/kiosk/operating/kiosk.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

using house::DocumentCode;

struct Reader {
  std::filesystem::path file;  // where it looks for its configuration
  toml::table base;            // a file that it reads, to which a piece is added
  std::function<Result<>(const std::filesystem::path&)> read;
  std::set<std::string> usual;  // what it says about the base
  std::set<std::string> only;   // a base made for keys in these tables alone; empty: for all
};

// What a reader says about a file, a line each. Files that the page's reader has and this test lacks do not count.
std::set<std::string> problems_of(const Reader& reader, const toml::table& given) {
  std::ofstream(reader.file) << given << "\n";
  const auto done = reader.read(reader.file);
  std::set<std::string> problems;
  if (done) return problems;
  for (const auto& line : house::lines_of(done.error().message))
    if (line.find("(looked for ") == std::string::npos) problems.insert(line);
  return problems;
}

template <class T>
Result<> outcome_of(const Result<T>& read) {
  if (!read) return fail(read.error());
  return {};
}

// Every key and table of a file that explains itself, those in comments too: `#key = value`, `# key = value`.
std::string with_all_keys(const std::string& text) {
  static const std::regex kKey(R"((^|\n)# ?(\[\[?[a-z_.]+\]|[a-z0-9_]+ = ))");
  return std::regex_replace(text, kKey, "$1$2");
}

std::string example_file(const std::string& name) {
  return read_text_file(source_folder() / "systemd" / name).value();
}

// Adds a piece. A block's lens stands for the whole lens: other models have other keys.
void add_to(toml::table& file, const toml::table& piece, bool block) {
  for (const auto& [key, value] : piece) {
    auto* there = file.get(key);
    const bool whole = block && (key == "lens" || key == "vignetting" || key == "camera");
    if (there && there->is_table() && value.is_table() && !whole)
      add_to(*there->as_table(), *value.as_table(), block);
    else
      file.insert_or_assign(key, value);
  }
}

std::vector<Reader> all_readers() {
  std::vector<Reader> readers;
  const auto add = [&](const std::string& name, toml::table base, auto read) {
    const auto folder = operating_folder("document_keys/" + std::to_string(readers.size()));
    readers.push_back({folder / name, std::move(base), std::move(read), {}, {}});
    readers.back().usual = problems_of(readers.back(), readers.back().base);
  };
  const auto kiosk = [](const std::filesystem::path& file) -> Result<> {
    const auto root = ConfigTable::read_file(file);
    if (!root) return fail(root.error());
    read_run_config(*root);
    return root->finish();
  };
  const auto base = toml::parse(example_file("kasumi.toml") +
                                "\n[[landmarks]]\nname = \"a\"\ndistance_m = 2400.0\n"
                                "[site.fog]\nextinction_per_m = 0.002\nbase_altitude_m = 941.0\nscale_height_m = 30.0\n"
                                "[scene.noise]\nfull_scale_electrons = 10000.0\nread_electrons = 3.0\n");
  add("kasumi.toml", base, kiosk);
  // Keys that go with one choice only: of a lens, a landmark, a camera, a screen, a place.
  for (const char* lens :
       {"model = \"equidistant\"\nfov_deg = 180.0\ncircle_px = [241.4, 238.1, 230.0]\n",
        "model = \"opencv_fisheye\"\nfocal_px = [147.0, 147.0]\ncentre_px = [241.4, 238.1]\nk = [0.0, 0.0, 0.0, 0.0]\n",
        "model = \"scaramuzza\"\npolynomial = [-150.0, 0.0, 0.002]\ncentre_px = [241.4, 238.1]\n",
        "model = \"scaramuzza\"\nocamcalib = \"calib_results.txt\"\n"}) {
    auto variant = base;
    variant["sky"].as_table()->insert_or_assign("lens", toml::parse(lens));
    add("kasumi.toml", std::move(variant), kiosk);
    readers.back().only = {"sky.lens"};
  }
  for (const auto& [table, chosen] :
       {std::pair{"landmarks", "[[landmarks]]\nname = \"a\"\ndistance_m = 2400.0\nregion_px = [610, 402, 24, 8]\n"},
        {"sky.camera", "[sky.camera]\nsource = \"libcamera\"\ncamera = \"a\"\n"},
        {"sky.camera", "[sky.camera]\nsource = \"replay\"\nfixture = \"a\"\n"},
        {"display", "[display]\nkind = \"headless\"\n"},
        {"scene", "[scene]\ndepth_map = \"depth.png\"\n"},
        {"object", "[object]\nlatitude_deg = 34.3\nlongitude_deg = 135.6\naltitude_m = 940.0\n"}}) {
    auto variant = base;
    if (std::string(table) == "object")
      for (const char* key : {"east_m", "north_m", "up_m"}) variant["object"].as_table()->erase(key);
    add_to(variant, toml::parse(chosen), true);
    add("kasumi.toml", std::move(variant), kiosk);
    readers.back().only = {table};
  }
  add("fixture.toml", toml::parse(read_text_file(source_folder() / "fixtures/demo/fixture.toml").value()),
      [](const std::filesystem::path& file) { return outcome_of(read_fixture(file.parent_path())); });
  const auto reporter = [](const std::filesystem::path& file) { return outcome_of(report::read_report_config(file)); };
  const auto told = with_all_keys(example_file("report.toml"));
  add("report.toml", toml::parse(told), reporter);
  add("report.toml", toml::parse(std::regex_replace(told, std::regex(R"((^|\n)(ca|cert|key)_file = [^\n]*)"), "")),
      reporter);
  readers.back().only = {"mqtt"};
  add("landmarks.toml", {},
      [](const std::filesystem::path& file) { return outcome_of(read_scene_sights(file, KnownCalibration{})); });
  add("strokes.toml", {}, [](const std::filesystem::path& file) { return outcome_of(read_strokes(file, 1280, 720)); });
  add("content.toml",
      toml::parse("languages = [\"en\"]\n[[era]]\nname = \"summer\"\ntitle.en = \"a\"\ntext.en = \"b\"\n"
                  "[[story]]\nname = \"a\"\nplace_m = [1, 2, 3]\ntitle.en = \"a\"\ntext.en = \"b\"\n"),
      [](const std::filesystem::path& file) {
        static const Model unread;
        return outcome_of(read_visitor_content(file, {{"summer", &unread}}));
      });
  add("planes.toml", {}, [](const std::filesystem::path& file) { return outcome_of(read_scene_planes(file)); });
  return readers;
}

const std::vector<Reader>& readers() {
  static const auto all = all_readers();
  return all;
}

// What each reader says of a piece that it did not say before; empty: one of them takes it.
std::string refusal_of(const toml::table& piece, bool block) {
  std::string shortest;
  for (const auto& reader : readers()) {
    if (!reader.only.empty()) continue;
    auto file = reader.base;
    add_to(file, piece, block);
    std::string said;
    for (const auto& problem : problems_of(reader, file))
      if (!reader.usual.contains(problem)) said += problem + "\n";
    if (said.empty()) return {};
    if (shortest.empty() || said.size() < shortest.size()) shortest = said;
  }
  return shortest;
}

// A key as prose names it: `[display] planes = "off"`, `object.shadows = false`, `[state] folder`, `[[landmarks]]`.
struct Named {
  std::string table, key, value;
  bool has_placeholders = false;  // of the value: `[x, y, width, height]`
};

std::optional<Named> named_in(const std::string& code) {
  static const std::regex kTable(R"(\[\[?([a-z_.]+)\]\]?(?: ([a-z0-9_]+)(?: = (.+))?)?)"),
      kKey(R"((?:([a-z_.]+)\.)?([a-z0-9_]+) = (.+))"), kQuoted(R"("[^"]*")"), kWord(R"([A-Za-z][A-Za-z0-9_]*|\.\.\.)");
  std::smatch part;
  if (!std::regex_match(code, part, kTable) && !std::regex_match(code, part, kKey)) return std::nullopt;
  Named named{part[1], part[2], part[3]};
  const auto bare = std::regex_replace(named.value, kQuoted, "");
  for (std::sregex_iterator word(bare.begin(), bare.end(), kWord), last; word != last; ++word)
    if (const auto text = word->str(); text != "true" && text != "false" && text != "T" && text != "Z")
      named.has_placeholders = true;
  return named;
}

// The tables of a file, by name with points, and its own.
void list_tables(const toml::table& file, const std::string& prefix, std::set<std::string>& found) {
  found.insert(prefix);
  for (const auto& [key, value] : file) {
    const auto name = prefix + (prefix.empty() ? "" : ".") + std::string(key.str());
    if (const auto* table = value.as_table()) list_tables(*table, name, found);
    if (const auto* tables = value.as_array(); tables && tables->is_array_of_tables())
      list_tables(*tables->get(0)->as_table(), name, found);
  }
}

// The table of this name, which is made where it is missing; of several, the first.
toml::table* table_in(toml::table& file, const std::string& name) {
  auto* table = &file;
  std::istringstream parts(name);
  for (std::string part; std::getline(parts, part, '.');) {
    if (!table->contains(part)) table->insert(part, toml::table{});
    auto* node = table->get(part);
    if (auto* tables = node->as_array(); tables && tables->is_array_of_tables()) node = tables->get(0);
    table = node->as_table();
    if (!table) return nullptr;
  }
  return table;
}

// What is wrong with a key in a sentence: no reader knows it, or where it is known its value is refused.
std::string key_refusal(const Named& named) {
  std::string refused = "no reader knows it";
  for (const auto& reader : readers()) {
    std::set<std::string> places{named.table};
    if (named.table.empty()) list_tables(reader.base, "", places);
    for (const auto& place : places) {
      if (!reader.only.empty() && !reader.only.contains(place)) continue;
      auto file = reader.base;
      auto* table = table_in(file, place);
      if (!table) continue;
      const bool any = named.value.empty() || named.has_placeholders;
      if (!named.key.empty()) {
        try {
          add_to(*table, toml::parse(named.key + " = " + (any ? "1" : named.value)), false);
        } catch (const toml::parse_error& error) {
          return std::string(error.description());
        }
      }
      bool known = true;
      std::string said;
      for (const auto& problem : problems_of(reader, file)) {
        if (reader.usual.contains(problem)) continue;
        if (problem.find("unknown key") != std::string::npos) known = false;
        said += problem + "\n";
      }
      if (known && (any || said.empty())) return {};
      if (known) refused = said;
    }
  }
  return refused;
}

// A block with one of its keys or tables in comments as if its `#` were removed.
struct Variant {
  std::string block;
  Named key;  // empty for a table
};

std::vector<Variant> variants_of(const std::string& block) {
  static const std::regex kKey(R"(# ?([a-z0-9_]+) = (.*))"), kTable(R"((# ?)?\[\[?([a-z_.]+)\]\]?\s*(#.*)?)"),
      kMark("^# ?");
  const auto lines = house::lines_of(block);
  std::vector<Variant> variants;
  std::string within;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    std::smatch part;
    const bool table = std::regex_match(lines[i], part, kTable);
    if (table) within = part[2];
    if (table ? !part[1].matched : !std::regex_match(lines[i], part, kKey)) continue;
    auto changed = lines;
    auto end = i + 1;
    while (table && end < lines.size() && lines[end].starts_with("#") && !std::regex_match(lines[end], kTable)) ++end;
    for (auto at = i; at < end; ++at)
      if (at == i || std::regex_match(lines[at], kKey)) changed[at] = std::regex_replace(lines[at], kMark, "");
    Variant variant;
    if (!table) variant.key = {within, part[1], part[2]};
    for (const auto& line : changed) variant.block += line + "\n";
    variants.push_back(std::move(variant));
    i = end - 1;
  }
  return variants;
}

std::string refusal_of(const std::string& block) {
  try {
    return refusal_of(toml::parse(block), true);
  } catch (const toml::parse_error& error) {
    return fmt::format("{}\n", error.description());
  }
}

// What is wrong with a block of TOML; empty: nothing. A key in comments may need another choice than the block's: then it
// is taken where that is made.
std::string block_refusal(const std::string& block) {
  auto found = refusal_of(block);
  if (!found.empty()) return found;
  for (const auto& variant : variants_of(block)) {
    const auto refused = refusal_of(variant.block);
    if (!refused.empty() && (variant.key.key.empty() || !key_refusal(variant.key).empty())) found += refused;
  }
  return found;
}

// What the keys of a page meet that does not take them.
std::vector<std::string> key_refusals_in(const std::string& name, const std::string& document, int& pieces) {
  static const std::set<std::string> kOthers{"kernel.sysrq"};  // the kernel's own
  static const std::regex kTable(R"(\[\[?[a-z_.]+\]\]?\s*(#[^\n]*)?\n[^]*)");
  std::vector<std::string> found;
  for (const auto& code : house::code_in(document)) {
    std::string refused;
    if (code.block) {
      if (code.language != "toml" && (!code.language.empty() || !std::regex_match(code.text, kTable))) continue;
      refused = block_refusal(code.text);
    } else {
      const auto named = named_in(code.text);
      if (!named || kOthers.contains(named->table + "." + named->key)) continue;
      refused = key_refusal(*named);
    }
    ++pieces;
    if (!refused.empty())
      found.push_back(fmt::format("{}:{}: {}: {}", name, code.line, code.block ? "block" : code.text, refused));
  }
  return found;
}

TEST(DocumentKeys, AreTakenByTheProgram) {
  int pieces = 0;
  for (const auto& [name, text] : house::texts_ending_in(house::repository_files(), {".md"})) {
    if (name == "CHANGELOG.md") continue;  // the past had other keys
    EXPECT_THAT(key_refusals_in(name, text, pieces), testing::IsEmpty());
  }
  EXPECT_GT(pieces, 90) << "the documents were not read";
}

TEST(DocumentKeys, OfTheExamplesAreTakenEachByItself) {
  // Eras belong together: test_example.cpp reads them.
  const auto kiosk =
      std::regex_replace(example_file("kasumi.toml"), std::regex(R"(\n# \[\[era\]\](\n# [^\n]*)+)"), "\n");
  EXPECT_EQ(block_refusal(kiosk), "");
  EXPECT_EQ(block_refusal(example_file("report.toml")), "");
}

TEST(DocumentKeys, AnOffenderWouldBeFound) {
  const auto count = [](const std::string& text) {
    int pieces = 0;
    return key_refusals_in("a.md", text, pieces).size();
  };
  for (const std::string good :
       {"`sky_model = \"automatic\"`", "`[site] sky_model = \"dome\"`", "`object.shadows = false`", "`[state] folder`",
        "`[[landmarks]]`", "`circle_px = [x, y, radius]`", "`[mail]`", "`tls = false`", "`kernel.sysrq = 0`",
        "`a == b`", "    [mail]\n    to = [\"a@example.org\"]\n",
        "```toml\n[site]\nlatitude_deg = 3.0\n# ground_albedo = 0.2  # a\n```\n",
        "```toml\n[[hidden]]\npoints = [1, 2, 3, 4]\n```\n", "```\nn = 1.0003\n```\n"})
    EXPECT_EQ(count(good), 0u) << good;
  for (const std::string bad :
       {"`sky_model = \"auto\"`", "`[site] sky_model = \"auto\"`", "`object.shadow = false`", "`[state] folders`",
        "`[display] sky_model = \"dome\"`", "`[[landmark]]`", "`circles_px = [x, y, radius]`", "`[mails]`", "`tls = 1`",
        "    [mail]\n    too = [\"a@example.org\"]\n", "```toml\n[site]\nlatitude_deg = 300.0\n```\n",
        "```toml\n[site]\nlatitude_deg = 3.0\n# ground_albedo = 2.0  # a\n```\n",
        "```toml\n[[hidden]]\npoints = [1]\n```\n", "```toml\n[site]\n# [site.fog]\n# extinction = 2.0\n```\n",
        "```toml\n[site\n```\n"})
    EXPECT_EQ(count(bad), 1u) << bad;
}

}  // namespace
}  // namespace kasumi
