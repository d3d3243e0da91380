#include "pipeline/landmark_state.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "base/files.hpp"

namespace kasumi {

namespace {

using Json = nlohmann::json;

std::filesystem::path file_in(const std::filesystem::path& folder) {
  return folder / "landmarks.json";
}

std::string text_of(const std::optional<PictureBox>& box) {
  return box ? fmt::format("{},{},{},{}", box->x, box->y, box->width, box->height) : "-";
}

// What an installer says of each: another box or distance is another landmark.
std::vector<std::string> said_of(const std::vector<ContrastLandmark>& landmarks) {
  std::vector<std::string> all;
  for (const auto& one : landmarks)
    all.push_back(fmt::format("{} at {:.1f} m, {:.1f} m up, {} against {}, sky {}, {} +- {}", one.name, one.distance_m,
                              one.rise_m, text_of(one.surface), text_of(one.against), text_of(one.sky), one.contrast,
                              one.contrast_sigma));
  return all;
}

std::vector<double> numbers(const Json& json, const char* key) {
  std::vector<double> values;
  if (!json.is_object() || !json.contains(key) || !json[key].is_array()) return values;
  for (const auto& value : json[key])
    if (value.is_number()) values.push_back(value.get<double>());
  return values;
}

}  // namespace

Result<> save(const LandmarkWatch& watch, const std::filesystem::path& folder) {
  Json json = {{"landmarks", said_of(watch.landmarks())}};
  for (const auto& channel : watch.learnt())
    json["channels"].push_back({{"contrasts", channel.mean}, {"covariance", channel.covariance}});
  return write_text_file(file_in(folder), json.dump(1) + "\n");
}

Result<bool> resume(LandmarkWatch& watch, const std::filesystem::path& folder) {
  const auto file = file_in(folder);
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return false;
  const auto text = read_text_file(file);
  if (!text) return fail(FaultKind::bad_input, "{}", text.error().message);
  const auto json = Json::parse(*text, nullptr, false);
  if (!json.is_object() || json.value("landmarks", Json()) != Json(said_of(watch.landmarks())))
    return fail(FaultKind::bad_input, "{}: of other landmarks than the configuration's; what they were is learnt anew",
                file.string());
  std::vector<LearntContrasts> learnt;
  for (const auto& channel : json.value("channels", Json::array()))
    learnt.push_back({numbers(channel, "contrasts"), numbers(channel, "covariance")});
  if (!watch.resume(learnt))
    return fail(FaultKind::bad_input, "{}: damaged; the landmarks' contrasts are learnt anew", file.string());
  return true;
}

}  // namespace kasumi
