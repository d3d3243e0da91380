// The building's layer, kept over a restart: where GL is software it takes half of what a start costs. Of the same
// content, program and minutes only; the start draws its own within seconds.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "base/clock.hpp"
#include "base/outside/abandonable.hpp"
#include "base/result.hpp"
#include "pipeline/show/scene/building_layer.hpp"
#include "pipeline/site/config/content.hpp"

namespace kasumi {

struct LayerState {
  ContentPtr content;  // what it shows
  Utc utc{};           // when it was on the glass
  LayerOfBefore layer;
};

// folder/layer.bin, some megabytes; a larger one is not kept. Error: io.
Result<> save(const LayerState& state, const std::filesystem::path& folder);
// Empty: nothing was saved there, or longer ago than counts. Errors: bad_input (damaged, of other content or of another
// version), io.
Result<std::optional<LayerOfBefore>> load_layer(const Content& content, const std::filesystem::path& folder, Utc now);

// Reads it while the start goes on: the disk may hang. What is refused is deleted, which the log says.
class LayerRecall {
 public:
  LayerRecall(ContentPtr content, Utc now);
  // BLOCKS for a fifth of a second at most. Empty: there is none for this content, or the disk has not answered yet;
  // once.
  std::optional<LayerOfBefore> take(const ContentPtr& content);

 private:
  ContentPtr content_;
  std::optional<Abandonable<std::optional<LayerOfBefore>>> reading_;
};

}  // namespace kasumi
