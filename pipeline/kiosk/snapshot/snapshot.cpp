#include "pipeline/kiosk/snapshot/snapshot.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "base/outside/json_depth.hpp"
#include "base/outside/json_text.hpp"
#include "base/utc_text.hpp"

namespace kasumi {
namespace {

constexpr int kLargestSide = 16384;  // of a screen; an answer that claims more is not from the appliance

}  // namespace

std::string snapshot_request_line(SnapshotKind kind) {
  return kind == SnapshotKind::sharp ? "sharp\n" : "blurred\n";
}

Result<SnapshotKind> parse_snapshot_request(std::string_view line) {
  if (line == "blurred") return SnapshotKind::blurred;
  if (line == "sharp") return SnapshotKind::sharp;
  return fail(FaultKind::bad_input, "a request for a snapshot: expected \"blurred\" or \"sharp\"");
}

std::string snapshot_answer(const Snapshot& snapshot) {
  const nlohmann::ordered_json json = {{"kind", snapshot.kind == SnapshotKind::sharp ? "sharp" : "blurred"},
                                       {"width", snapshot.picture.width()},
                                       {"height", snapshot.picture.height()},
                                       {"shown", snapshot.shown},
                                       {"reason", snapshot.reason},
                                       {"words", snapshot.words},
                                       {"building", snapshot.building},
                                       {"refused", snapshot.refused},
                                       {"utc", utc_text(std::chrono::floor<std::chrono::seconds>(snapshot.utc))},
                                       {"screen", {snapshot.screen_width, snapshot.screen_height}}};
  std::string answer = text_of_json(json) + "\n";
  for (const Rgb8& pixel : snapshot.picture.elements())
    for (const std::uint8_t value : {pixel.r, pixel.g, pixel.b}) answer += static_cast<char>(value);
  return answer;
}

Result<SnapshotHeader> parse_snapshot_header(std::string_view line) try {
  const auto json = parse_json(modest_json(line));
  SnapshotHeader header;
  auto& snapshot = header.snapshot;
  snapshot.kind = json.at("kind").get<std::string>() == "sharp" ? SnapshotKind::sharp : SnapshotKind::blurred;
  snapshot.shown = json.at("shown").get<std::string>();
  snapshot.reason = json.at("reason").get<std::string>();
  snapshot.words = json.at("words").get<std::string>();
  snapshot.building = json.at("building").get<bool>();
  snapshot.refused = json.at("refused").get<bool>();
  snapshot.utc = parse_utc(json.at("utc").get<std::string>()).value_or(Utc{});
  snapshot.screen_width = json.at("screen").at(0).get<int>();
  snapshot.screen_height = json.at("screen").at(1).get<int>();
  const int width = json.at("width").get<int>(), height = json.at("height").get<int>();
  if (width < 0 || height < 0 || width > kLargestSide || height > kLargestSide)
    return fail(FaultKind::bad_input, "a picture of {} x {}", width, height);
  snapshot.picture = Image<Rgb8>(width, height);
  header.picture_bytes = 3 * snapshot.picture.elements().size();
  return header;
} catch (const nlohmann::json::exception& error) {
  return fail(FaultKind::bad_input, "{}", error.what());
}

std::string snapshot_text(const Snapshot& snapshot) {
  std::string text = fmt::format("shown: {}{}{}, {}\n", snapshot.shown, snapshot.reason.empty() ? "" : ": ",
                                 snapshot.reason, snapshot.building ? "with the building" : "without the building");
  if (!snapshot.words.empty()) text += fmt::format("words on the glass: {}\n", snapshot.words);
  text += fmt::format("taken: {}, of a screen of {} x {}\n",
                      utc_text(std::chrono::floor<std::chrono::seconds>(snapshot.utc)), snapshot.screen_width,
                      snapshot.screen_height);
  return text;
}

}  // namespace kasumi
