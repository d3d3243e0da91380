// What a kiosk shows: read completely before any of it is used.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "base/image.hpp"
#include "gles/model/model.hpp"
#include "gles/picture/flat_picture.hpp"
#include "pipeline/site/config/run_config.hpp"
#include "pipeline/site/config/visitor_content.hpp"

namespace kasumi {

// A file of the content as it was when it was read.
struct ContentFile {
  std::filesystem::path path;  // as it was named
  std::uintmax_t bytes = 0;
  std::int64_t changed_ns = 0;  // since the epoch of the file system's clock
  friend bool operator==(const ContentFile&, const ContentFile&) = default;
};
// The file as it is now; empty: it cannot be found.
std::optional<ContentFile> content_file(const std::filesystem::path& path);

// Why this is not the content that is configured (pipeline/kiosk/start/kept_content.hpp).
struct InsteadOfConfigured {
  Utc kept_utc{};                    // when it had been shown for long enough
  std::vector<std::string> refused;  // what is wrong with the configured one
};

// What differs between the eras, read with all the others: a change needs no disk.
struct EraContent {
  std::filesystem::path model_file;
  std::string scene;
  StillContent still_options;
  std::shared_ptr<const Model> model;
  std::shared_ptr<const Image<Rgba8>> still;
};

struct Content {
  RunConfig config;  // [object] and [still] as this era has them
  // With its levels; stays in memory: GL contexts come and go. Never null.
  std::shared_ptr<const Model> model = std::make_shared<const Model>();
  std::shared_ptr<const Image<Rgba8>> still;  // the curated picture; where it is transparent, the sky of the day shows
  std::shared_ptr<const std::vector<EraContent>> eras;  // as in config.eras; null: there are none
  std::size_t era = 0;                                  // of them, the one that this is
  std::shared_ptr<const VisitorContent> visitor;        // null: there is none
  std::vector<ContentFile> files;                       // the configuration first, then all that it names
  std::optional<InsteadOfConfigured> instead;           // empty: this is what is configured
};
using ContentPtr = std::shared_ptr<const Content>;

// The curated picture. Errors: those of read_photograph().
Result<Image<Rgba8>> read_still(const std::filesystem::path& file);

// Reads configuration, calibration, model and curated picture, which BLOCKS for seconds. Errors (bad_input): all
// problems of all files at once.
// With `copies`, files are looked for there first, by their whole names below that folder.
Result<ContentPtr> read_content(const std::filesystem::path& config_file, const std::filesystem::path& copies = {});

// The same within a deadline: a disk may never answer, and its reader is abandoned then. Error (io) beside those above:
// it took longer. Exceptions become faults.
Result<ContentPtr> read_content_within(std::chrono::nanoseconds longest, const std::filesystem::path& config_file);

// The same content as it is shown at that time: itself while nothing changes. `further`: so many eras after that one, and
// on from the first after the last. Thread-safe, and quick.
ContentPtr in_its_era(const ContentPtr& content, Utc now, std::size_t further = 0);
// Every model that is shown, with its era. They belong to the content.
std::vector<ModelInEra> shown_models(const Content& content);
// One for each era, so that all can be tried; without eras the content itself.
std::vector<ContentPtr> all_eras(const ContentPtr& content);
// What the reader left out of the models of all eras, each once, for the terminal.
std::vector<std::string> model_notes(const Content& content);
// Its name; empty: there are no eras.
std::string era_name(const Content& content);

}  // namespace kasumi
