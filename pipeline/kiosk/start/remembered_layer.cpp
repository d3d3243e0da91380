#include "pipeline/kiosk/start/remembered_layer.hpp"

#include <algorithm>
#include <cstring>
#include <sstream>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "base/files.hpp"
#include "base/utc_text.hpp"
#include "pipeline/kiosk/start/file_hash.hpp"

namespace kasumi {

namespace {

// Any version; the version that is written.
constexpr std::string_view kEveryLayerKind = "kasumi-layer-", kLayerKind = "kasumi-layer-1";
constexpr std::size_t kMostLayerBytes = 32 << 20;
constexpr Duration kLongestLayerAge = std::chrono::minutes(10);  // clouds move on
constexpr std::chrono::milliseconds kRecallPatience{200};        // drawing the layer takes longer

std::filesystem::path layer_file(const std::filesystem::path& folder) {
  return folder / "layer.bin";
}

// Changes with the program and with each file of the content.
std::string key_of(const Content& content) {
  auto files = content.files;
  if (const auto program = content_file("/proc/self/exe")) files.push_back(*program);
  FileHash hash;
  for (const auto& file : files) hash.add(fmt::format("{} {} {}\n", file.path.string(), file.bytes, file.changed_ns));
  hash.add(fmt::format("{} {}", content.era, content.instead.has_value()));
  return hash.hex();
}

// A line of text without its hash: all but the texels.
std::string head_of(const LayerState& state) {
  const auto& [layer, sun, turbidity, near_ground, past_hills] = state.layer;
  const auto& [box, detail, halves] = layer;
  return fmt::format("{} {} {} {} {} {} {} {} {} {} {} {} {} {} {} {} {} {:d}", kLayerKind, key_of(*state.content),
                     utc_text(state.utc), sun.x, sun.y, sun.z, turbidity, near_ground, past_hills, box.left, box.top,
                     box.right, box.bottom, detail.point_spread_px, detail.chroma_columns, detail.chroma_rows,
                     detail.sharpening, detail.jpeg_blocks);
}

std::span<const std::uint8_t> bytes_of(const Image<glm::u16vec4>& halves) {
  const auto& texels = halves.elements();
  return {reinterpret_cast<const std::uint8_t*>(texels.data()), texels.size() * sizeof(glm::u16vec4)};
}

std::string hash_of_layer(std::string_view head, std::span<const std::uint8_t> texels) {
  FileHash hash;
  hash.add(head);
  hash.add(texels);
  return hash.hex();
}

struct ReadLayer {
  std::string key;
  Utc utc{};
  LayerOfBefore layer;
};

// One line of text that ends with the hash of all else, then the texels in the machine's order of bytes.
Result<ReadLayer> read_layer_of(const std::vector<std::uint8_t>& bytes) {
  const auto damaged = fail(FaultKind::bad_input, "damaged");
  const auto end = std::ranges::find(bytes, std::uint8_t{'\n'});
  if (end == bytes.end()) return damaged;
  const std::string line(bytes.begin(), end);
  const auto last = line.rfind(' ');
  if (last == std::string::npos) return damaged;
  if (line.starts_with(kEveryLayerKind) && !line.starts_with(std::string(kLayerKind) + " "))
    return fail(FaultKind::bad_input, "of another version of kasumi");
  const std::span<const std::uint8_t> texels(end + 1, bytes.end());
  if (line.substr(last + 1) != hash_of_layer(line.substr(0, last), texels)) return damaged;
  ReadLayer read;
  auto& [layer, sun, turbidity, near_ground, past_hills] = read.layer;
  auto& [box, detail, halves] = layer;
  std::istringstream words(line);
  std::string kind, utc;
  words >> kind >> read.key >> utc >> sun.x >> sun.y >> sun.z >> turbidity >> near_ground >> past_hills >> box.left >>
      box.top >> box.right >> box.bottom >> detail.point_spread_px >> detail.chroma_columns >> detail.chroma_rows >>
      detail.sharpening >> detail.jpeg_blocks;
  const auto when = parse_utc(utc);
  constexpr int kMostSide = 1 << 14;  // pixels of any camera's picture
  const bool sound = box.left >= 0 && box.top >= 0 && !box.empty() && box.right <= kMostSide && box.bottom <= kMostSide;
  if (!words || kind != kLayerKind || !when || !sound) return damaged;
  read.utc = *when;
  const auto width = box.right - box.left, height = box.bottom - box.top;
  if (texels.size() != sizeof(glm::u16vec4) * static_cast<std::size_t>(width) * static_cast<std::size_t>(height))
    return damaged;
  halves = Image<glm::u16vec4>(width, height);
  std::memcpy(halves.elements().data(), texels.data(), texels.size());
  return read;
}

std::optional<LayerOfBefore> recall(const Content& content, Utc now) {
  const auto& folder = *content.config.state_folder;
  auto kept = load_layer(content, folder, now);
  if (kept) return std::move(*kept);
  spdlog::info("the building's layer of before is not used: {}", kept.error().message);
  std::error_code ignored;
  if (kept.error().kind == FaultKind::bad_input) std::filesystem::remove(layer_file(folder), ignored);
  return std::nullopt;
}

}  // namespace

Result<> save(const LayerState& state, const std::filesystem::path& folder) {
  const auto texels = bytes_of(state.layer.layer.halves);
  if (texels.size() > kMostLayerBytes) return {};
  const auto head = head_of(state);
  const auto line = fmt::format("{} {}\n", head, hash_of_layer(head, texels));
  std::vector<std::uint8_t> bytes(line.begin(), line.end());
  bytes.insert(bytes.end(), texels.begin(), texels.end());
  return write_file(layer_file(folder), bytes);
}

Result<std::optional<LayerOfBefore>> load_layer(const Content& content, const std::filesystem::path& folder, Utc now) {
  const auto file = layer_file(folder);
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return std::optional<LayerOfBefore>();
  constexpr std::size_t kMostHead = 1000;  // bytes of the line before the texels
  const auto bytes = read_file(file, {.most_bytes = kMostLayerBytes + kMostHead});
  if (!bytes) return fail(bytes.error());
  auto kept = read_layer_of(*bytes);
  if (!kept) return fail(FaultKind::bad_input, "{}: {}", file.string(), kept.error().message);
  if (kept->key != key_of(content))
    return fail(FaultKind::bad_input, "{}: of other content or another program", file.string());
  if (kept->utc > now || now - kept->utc > kLongestLayerAge) return std::optional<LayerOfBefore>();
  return std::optional(std::move(kept->layer));
}

LayerRecall::LayerRecall(ContentPtr content, Utc now) : content_(std::move(content)) {
  if (!content_->config.state_folder) return;
  try {
    reading_.emplace([content = content_, now] { return recall(*content, now); });
  } catch (const std::system_error&) {  // no thread is left: it is drawn
  }
}

std::optional<LayerOfBefore> LayerRecall::take(const ContentPtr& content) {
  auto reading = std::exchange(reading_, std::nullopt);
  if (!reading || content != std::exchange(content_, nullptr)) return std::nullopt;
  try {
    return reading->take(kRecallPatience).value_or(std::nullopt);
  } catch (const std::exception& thrown) {
    spdlog::info("the building's layer of before is not used: {}", thrown.what());
    return std::nullopt;
  }
}

}  // namespace kasumi
