#include <algorithm>
#include <filesystem>
#include <memory>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "base/files.hpp"
#include "gles/model/mip_levels.hpp"
#include "pipeline/command.hpp"
#include "pipeline/lab/look/model_facts.hpp"
#include "pipeline/lab/look/turntable.hpp"
#include "pipeline/site/config/fixture_file.hpp"
#include "pipeline/site/config/run_config.hpp"
#include "pipeline/site/config/sighting.hpp"
#include "pipeline/site/files/contact_sheet.hpp"
#include "pipeline/site/files/picture_sink.hpp"

namespace kasumi {

namespace {

namespace fs = std::filesystem;

struct LookArguments {
  std::vector<std::string> models;
  std::string scene, up = "y", camera, out;
};

// Every file of a folder that is a model by its name.
Result<> add_models_of(const fs::path& folder, std::vector<fs::path>& files) {
  static constexpr std::string_view kEndings[]{".glb", ".gltf", ".b3dm", ".i3dm", ".cmpt"};
  const std::size_t before = files.size();
  std::error_code error;
  for (auto it = fs::recursive_directory_iterator(folder, error); !error && it != fs::end(it); it.increment(error)) {
    std::string ending = it->path().extension().string();
    std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (it->is_regular_file() && std::ranges::find(kEndings, ending) != std::end(kEndings)) files.push_back(it->path());
  }
  if (error) return fail(FaultKind::io, "{}: {}", folder.string(), error.message());
  if (files.size() == before) return fail(FaultKind::bad_input, "{}: no .glb or .gltf in this folder", folder.string());
  std::sort(files.begin() + static_cast<std::ptrdiff_t>(before), files.end());
  return {};
}

// How many of them can be read.
Result<int> look_at_all(const std::vector<std::string>& models) {
  std::vector<fs::path> files;
  for (const auto& model : models) {
    if (!fs::is_directory(model))
      files.emplace_back(model);
    else if (auto added = add_models_of(model, files); !added)
      return fail(added.error());
  }
  std::size_t whole = 0;
  for (const auto& file : files) {
    const auto model = read_gltf(file);
    whole += model.has_value();
    if (!model) {
      fmt::print("refused: {}\n", model.error().message);
      continue;
    }
    const auto facts = facts_of(*model, UpAxis::y);
    fmt::print("read: {}: {} triangles\n", file.string(), model->triangle_count());
    for (const auto& note : model->notes) fmt::print("  left out or changed: {}\n", note);
    for (const auto& doubt : facts.doubts) fmt::print("  {}\n", doubt);
  }
  fmt::print("{} of {} models can be read ({:.0f} %)\n", whole, files.size(),
             100.0 * static_cast<double>(whole) / static_cast<double>(files.size()));
  return whole == files.size() ? 0 : 2;
}

Result<> draw(const LookArguments& arguments, const Model& model, UpAxis up, const Installation* kiosk) {
  constexpr const char* kSides[]{"south", "south-east", "east", "north-east",
                                 "north", "north-west", "west", "south-west"};
  auto context = open_headless_context();
  if (!context) return fail(context.error());
  const auto turned = turntable(**context, model, up);
  if (!turned) return fail(turned.error());
  fmt::print("the sheet is exposed for the model: {:.2f} times as for a landscape\n", turned->exposure);
  ContactSheet sheet;
  for (std::size_t i = 0; i < turned->views.size(); ++i)
    sheet.add(turned->views[i], fmt::format("from the {}{}", kSides[i],
                                            i == 0 ? fmt::format(", exposure x {:.2f}", turned->exposure) : ""));
  if (kiosk) {
    const auto seen = seen_from_kiosk(**context, *kiosk, model);
    if (!seen) return fail(seen.error());
    sheet.add(seen->whole, "as the kiosk sees it");
    if (!seen->enlarged.empty()) sheet.add(seen->enlarged, "the same, enlarged");
  }
  return write_png(arguments.out, sheet.drawn(4));
}

// A kiosk's configuration, or a recording's folder.
Result<Installation> installation_of(const fs::path& given) {
  if (fs::is_directory(given))
    return read_fixture(given).map([](Fixture fixture) { return std::move(fixture.installation); });
  const auto root = ConfigTable::read_file(given);
  if (!root) return fail(root.error());
  auto config = read_run_config(*root);
  if (auto sound = root->finish(); !sound) return fail(sound.error());
  return std::move(config.installation);
}

Result<int> look(const LookArguments& arguments) {
  const std::string& file = arguments.models.front();
  if (arguments.models.size() > 1 || fs::is_directory(file)) {
    if (!arguments.out.empty() || !arguments.camera.empty() || !arguments.scene.empty())
      return fail(FaultKind::bad_input,
                  "--out, --camera and --scene are for one model: expected no folder and no second");
    return look_at_all(arguments.models);
  }
  UpAxis up = arguments.up == "z" ? UpAxis::z : UpAxis::y;
  std::optional<Installation> kiosk;
  if (!arguments.camera.empty()) {
    auto installation = installation_of(arguments.camera);
    if (!installation) return fail(installation.error());
    kiosk = std::move(*installation);
    if (arguments.up == "y") up = kiosk->object.placement.up_axis;
    kiosk->object.placement.up_axis = up;
  }
  auto model = read_gltf(file, {}, arguments.scene);
  if (!model) return fail(model.error());
  fmt::print("{}\n", file);
  const auto facts = facts_of(*model, up);
  for (const auto& line : facts.lines) fmt::print("{}\n", line);
  for (const auto& doubt : facts.doubts) fmt::print("DOUBTFUL: {}\n", doubt);
  if (kiosk) fmt::print("{}\n", sight_object(*kiosk, model->bounds()).message);
  if (arguments.out.empty()) return 0;
  make_levels(*model);
  if (auto drawn = draw(arguments, *model, up, kiosk ? &*kiosk : nullptr); !drawn) return fail(drawn.error());
  fmt::print("written: {}\n", arguments.out);
  return 0;
}

}  // namespace

void add_look_command(CLI::App& app, Action& action) {
  auto* command = app.add_subcommand("look", "What a model holds, what of it is left out, and how it looks");
  auto arguments = std::make_shared<LookArguments>();
  command
      ->add_option("model", arguments->models,
                   "A .glb or .gltf; or folders or several models: then how many of them can be read")
      ->required();
  command->add_option("--scene", arguments->scene, "One of its scenes (eras), by name or number");
  command->add_option("--up", arguments->up, "Which of its axes points up, as [object] up says it")
      ->check(CLI::IsMember({"y", "z"}))
      ->capture_default_str();
  command->add_option("--camera", arguments->camera,
                      "The kiosk's configuration, or a recording: whether and how it sees the model");
  command->add_option("--out", arguments->out, "A sheet of eight views under a clear sky, and the kiosk's: PNG");
  command->callback([arguments, &action] { action = [arguments] { return look(*arguments); }; });
}

}  // namespace kasumi
