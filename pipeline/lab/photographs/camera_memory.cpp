#include "pipeline/lab/photographs/camera_memory.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include "base/files.hpp"
#include "base/table/config_table.hpp"
#include "base/table/toml_text.hpp"

namespace kasumi {
namespace {

constexpr double kSameCircle = 0.03;  // of the radius
constexpr int kEnough = 2;            // pictures that show a camera
constexpr std::size_t kMostSuns = 32;

bool same_circle(const ImageCircle& a, const ImageCircle& b) {
  return std::max(glm::distance(a.centre, b.centre), std::abs(a.radius_px - b.radius_px)) < kSameCircle * b.radius_px;
}

std::string circle_text(const ImageCircle& circle) {
  return fmt::format("[{}, {}, {}]", toml_number(circle.centre.x), toml_number(circle.centre.y),
                     toml_number(circle.radius_px));
}

std::string toml_of(const RememberedCamera& camera) {
  const auto number = [](const char* key, double value) { return fmt::format("{} = {}\n", key, toml_number(value)); };
  std::string text = fmt::format("\n[[cameras]]\nwidth = {}\nheight = {}\ncircle_px = {}\n", camera.width,
                                 camera.height, circle_text(camera.circle.circle));
  text += number("circle_sigma_px", camera.circle.circle.sigma_px);
  text += number("circle_confidence", camera.circle.confidence);
  if (camera.circle.horizon) text += fmt::format("horizon_px = {}\n", circle_text(*camera.circle.horizon));
  text += number("pixel_aspect", camera.circle.pixel_aspect);
  text += fmt::format("pictures = {}\n", camera.pictures);
  if (camera.tones > 0) {
    text += number("tone_exponent", std::exp(camera.belief.log_exponent));
    text += number("sigma_tone_exponent", std::exp(camera.belief.log_exponent) * camera.belief.sigma_log_exponent);
    text += fmt::format("tones = {}\n", camera.tones);
  }
  if (const auto& turn = camera.turn) {
    text += number("azimuth_up_deg", to_degrees(turn->azimuth_up));
    text += number("sigma_azimuth_up_deg", to_degrees(turn->sigma));
    text +=
        fmt::format("mirrored = {}\nmirror_known = {}\nsuns = {}\n", turn->mirrored, turn->mirror_known, turn->suns);
  }
  const auto angles = [](const Direction& at) {
    return fmt::format("[{}, {}]", toml_number(to_degrees(zenith_angle(at))),
                       toml_number(to_degrees(azimuth_angle(at))));
  };
  for (const SunPair& sun : camera.suns)
    text += fmt::format("[[cameras.sights]]\nseen_deg = {}\nstood_deg = {}\n", angles(sun.seen), angles(sun.stood));
  return text;
}

constexpr Range kPixels{-1e5, 1e5}, kShare{0.0, 1.0}, kPositive{1e-3, 1e5};
constexpr Range kCount{1.0, 1e9};

ImageCircle read_circle(const ConfigTable& table, const char* key) {
  const auto numbers = table.numbers(key, 3, kPixels);
  if (table.has(key) && !(numbers[2] >= 1.0)) table.problem(key, "[x, y, radius] with a radius >= 1");
  return {{numbers[0], numbers[1]}, std::max(1.0, numbers[2])};
}

// [zenith angle, azimuth]
Direction read_direction(const ConfigTable& table, const char* key) {
  const auto angles = table.numbers(key, 2, {-360.0, 360.0});
  return direction_from(from_degrees(angles[0]), from_degrees(angles[1]));
}

RememberedCamera read_camera_of(const ConfigTable& table) {
  RememberedCamera camera;
  camera.width = table.integer("width", kCount);
  camera.height = table.integer("height", kCount);
  camera.circle.circle = read_circle(table, "circle_px");
  camera.circle.circle.sigma_px = table.number("circle_sigma_px", {0.0, 1e5});
  camera.circle.confidence = table.number("circle_confidence", kShare);
  if (table.has("horizon_px")) camera.circle.horizon = read_circle(table, "horizon_px");
  camera.circle.pixel_aspect = table.number("pixel_aspect", {0.2, 5.0}, 1.0);
  camera.pictures = table.integer("pictures", kCount);
  if (table.has("tone_exponent")) {
    const double exponent = table.number("tone_exponent", {0.1, 10.0});
    camera.belief.log_exponent = std::log(std::max(exponent, 0.1));
    camera.belief.sigma_log_exponent = table.number("sigma_tone_exponent", kPositive) / std::max(exponent, 0.1);
    camera.tones = table.integer("tones", kCount);
  }
  if (table.has("azimuth_up_deg")) {
    AzimuthFit turn;
    turn.azimuth_up = from_degrees(table.number("azimuth_up_deg", {0.0, 360.0}));
    turn.sigma = from_degrees(table.number("sigma_azimuth_up_deg", {0.0, 360.0}));
    turn.mirrored = table.flag("mirrored");
    turn.mirror_known = table.flag("mirror_known");
    turn.suns = table.integer("suns", kCount);
    camera.turn = turn;
  }
  for (const ConfigTable& sight : table.tables("sights"))
    camera.suns.push_back({read_direction(sight, "seen_deg"), read_direction(sight, "stood_deg")});
  return camera;
}

// Of cameras, const or not; null: none has this circle.
template <class Cameras>
auto* find_camera(Cameras& cameras, int width, int height, const ImageCircle& circle) {
  const auto camera = std::ranges::find_if(cameras, [&](const RememberedCamera& one) {
    return one.width == width && one.height == height && same_circle(one.circle.circle, circle);
  });
  return camera == cameras.end() ? nullptr : &*camera;
}

// A remembered camera votes for its circle as two pictures do, or as one if it is known by a single one.
void add_known(std::vector<SizedCircle>& pictures, const RememberedCamera& camera) {
  for (int i = 0; i < std::min(camera.pictures, kEnough); ++i)
    pictures.push_back({camera.width, camera.height, camera.circle});
}

}  // namespace

Result<CameraMemory> CameraMemory::read(const std::filesystem::path& file) {
  CameraMemory memory;
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return memory;
  const auto table = ConfigTable::read_file(file);
  if (!table) return fail(table.error());
  for (const ConfigTable& camera : table->tables("cameras")) memory.cameras_.push_back(read_camera_of(camera));
  if (auto whole = table->finish(); !whole) return fail(whole.error());
  return memory;
}

Result<> CameraMemory::write(const std::filesystem::path& file) const {
  std::string text = "# What `kasumi estimate --camera-memory` learnt of these cameras from their pictures.\n";
  for (const RememberedCamera& camera : cameras_) text += toml_of(camera);
  return write_text_file(file, text);
}

void CameraMemory::learn_circles(const std::map<std::filesystem::path, SizedCircle>& pictures) {
  std::vector<SizedCircle> all;
  for (const RememberedCamera& camera : cameras_) add_known(all, camera);
  const std::size_t first = all.size();
  for (const auto& [file, picture] : pictures) all.push_back(picture);
  found_ = pictures;
  const auto circles = circles_of_fixed_cameras(all);
  for (std::size_t i = first; i < circles.size(); ++i) {
    if (!circles[i] || circles[i]->confidence < kLeastCircleConfidence) continue;
    if (auto* known = find_camera(cameras_, all[i].width, all[i].height, circles[i]->circle)) {
      ++known->pictures;
      if (circles[i]->horizon && !known->circle.horizon) known->circle.horizon = circles[i]->horizon;
    } else {
      RememberedCamera camera;
      camera.width = all[i].width;
      camera.height = all[i].height;
      camera.circle = *circles[i];
      camera.circle.others.clear();
      camera.pictures = 1;
      cameras_.push_back(std::move(camera));
    }
  }
}

void CameraMemory::learn(const std::vector<CameraSight>& pictures) {
  for (RememberedCamera& camera : cameras_) camera.before = camera.belief;
  for (const CameraSight& picture : pictures) {
    if (!picture.circle.found) continue;
    const auto& [width, height, found] = picture.circle;
    auto* camera = find_camera(cameras_, width, height, found->circle);
    if (!camera) continue;
    if (picture.tone) camera->told.insert_or_assign(picture.file, *picture.tone);
    if (picture.sun) camera->suns.push_back(*picture.sun);
  }
  for (RememberedCamera& camera : cameras_) {
    camera.belief = belief_beside(camera, {});
    camera.tones += static_cast<int>(camera.told.size());
    if (camera.suns.size() > kMostSuns)
      camera.suns.erase(camera.suns.begin(), camera.suns.end() - static_cast<std::ptrdiff_t>(kMostSuns));
    if (const auto turn = fit_azimuth(camera.suns); turn && (!camera.turn || turn->suns >= camera.turn->suns))
      camera.turn = turn;
  }
}

CameraMemory CameraMemory::without_turns() const {
  CameraMemory memory = *this;
  for (RememberedCamera& camera : memory.cameras_) camera.turn.reset();
  return memory;
}

CameraBelief CameraMemory::belief_beside(const RememberedCamera& camera, const std::filesystem::path& file) {
  std::vector<ToneSight> others;
  for (const auto& [of, tone] : camera.told)
    if (of != file) others.push_back(tone);
  return belief_after(others, camera.told.empty() ? camera.belief : camera.before);
}

std::optional<FoundCircle> CameraMemory::circle_of(const SizedCircle& alone) const {
  std::vector<SizedCircle> all;
  for (const RememberedCamera& camera : cameras_)
    if (camera.width == alone.width && camera.height == alone.height) add_known(all, camera);
  if (all.empty()) return alone.found;
  all.push_back(alone);
  return circles_of_fixed_cameras(all).back();
}

const SizedCircle* CameraMemory::found_in(const std::filesystem::path& file) const {
  const auto found = found_.find(file);
  return found == found_.end() ? nullptr : &found->second;
}

const RememberedCamera* CameraMemory::camera_of(int width, int height, const ImageCircle& circle) const {
  const auto* camera = find_camera(cameras_, width, height, circle);
  return camera && camera->pictures >= kEnough ? camera : nullptr;
}

bool CameraMemory::knows(int width, int height, const ImageCircle& circle) const {
  return find_camera(cameras_, width, height, circle) != nullptr;
}

}  // namespace kasumi
