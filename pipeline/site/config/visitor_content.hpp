// content.toml: what visitors may read about the building and its eras, in which languages.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "gles/model/model.hpp"
#include "pipeline/site/config/eras.hpp"

namespace kasumi {

using TextByLanguage = std::map<std::string, std::string>;  // ISO 639 code, UTF-8

// What a place of the building has to tell: a hot spot.
struct Story {
  std::string name;               // for operators and programs
  std::string node;               // of the model; empty: it is at `place`
  ModelBounds place;              // in the model's metres and axes; read where there is no node
  std::vector<std::string> eras;  // in these alone; empty: in all
  TextByLanguage title, text;     // in every language of the content
  std::string key;                // of content.toml, for messages: "story[2]"
};

struct VisitorEra {
  std::string name;  // as [[era]] of kasumi.toml has it
  TextByLanguage title, text;
};

struct VisitorContent {
  std::filesystem::path file;
  std::vector<std::string> languages;  // the first is the usual one
  std::vector<VisitorEra> eras;
  std::vector<Story> stories;
};

// A model, and the era in which it is shown.
struct ModelInEra {
  std::string era;  // empty: there are none
  const Model* model = nullptr;
};

// `models`: all that are shown; one that could not be read has no nodes and no triangles, and is not asked.
// Errors (bad_input, io): all problems at once.
Result<VisitorContent> read_visitor_content(const std::filesystem::path& file, const std::vector<ModelInEra>& models);

// Where the story is in that model; empty: it has no such node.
std::optional<ModelBounds> place_of(const Story& story, const Model& model);
bool is_told_in(const Story& story, const std::string& era);

}  // namespace kasumi
