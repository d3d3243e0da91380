#include "tests/pipeline/kiosk/appliance/rig.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "base/files.hpp"
#include "capture/codec/encode.hpp"
#include "capture/fixture/fixture_writer.hpp"
#include "pipeline/site/files/picture_sink.hpp"
#include "tests/pipeline/recorded.hpp"

namespace kasumi {

namespace {

constexpr int kWidth = 320, kHeight = 180;
constexpr int kCorner = 16;  // pixels each way that carry the number
constexpr int kLevels = 8;   // of each channel
constexpr int kLevelStep = 256 / kLevels;
constexpr Utc kStart = std::chrono::sys_days{std::chrono::June / 21 / 2026} + 3h;

Rgb8 colour_of(int number) {
  const auto level = [&](int digit) {
    return static_cast<std::uint8_t>(digit % kLevels * kLevelStep + kLevelStep / 2);
  };
  // A checksum, so that no other colour is mistaken for a number.
  return {level(number), level(number / kLevels), level(number + number / kLevels)};
}

void check(const Result<>& done) {
  if (!done) ADD_FAILURE() << done.error().message;
}

// The generator's first scene frame, numbered.
void write_scene(const std::filesystem::path& folder, const std::filesystem::path& generated) {
  const auto rows = read_index(generated / "scene").value();
  const auto bytes = read_file(generated / "scene" / rows[0].payload).value();
  Frame frame{rows[0].metadata, payload_of(bytes)};
  auto picture = to_rgb(decode(frame, YuvEncoding::bt601_full).value().view());
  auto writer = FixtureWriter::create(folder / "scene").value();
  for (int number = 0; number < kSceneFrames; ++number) {
    for (int y = 0; y < kCorner; ++y)
      for (int x = 0; x < kCorner; ++x) picture.at(x, y) = colour_of(number);
    auto numbered = encode_frame(picture, four_cc("RGB3")).value();
    numbered.metadata.captured_at = rows[0].metadata.captured_at + number * kSceneInterval;
    numbered.metadata.utc = rows[0].metadata.utc + number * kSceneInterval;
    numbered.metadata.sequence = static_cast<std::uint32_t>(number);
    numbered.metadata.exposure_s = rows[0].metadata.exposure_s;
    numbered.metadata.gain = rows[0].metadata.gain;
    check(writer.append(numbered));
  }
}

// Cycles through the generator's sky frames at the scene's rate: a loop without a gap.
void write_sky(const std::filesystem::path& folder, const std::filesystem::path& generated) {
  const auto rows = read_index(generated / "sky").value();
  auto writer = FixtureWriter::create(folder / "sky").value();
  for (int number = 0; number < kSceneFrames; ++number) {
    const auto& row = rows[static_cast<std::size_t>(number) * rows.size() / kSceneFrames];
    Frame frame{row.metadata, payload_of(read_file(generated / "sky" / row.payload).value())};
    frame.metadata.captured_at = rows[0].metadata.captured_at + number * kSceneInterval;
    frame.metadata.utc = rows[0].metadata.utc + number * kSceneInterval;
    frame.metadata.sequence = static_cast<std::uint32_t>(number);
    check(writer.append(frame));
  }
}

// Several test programs use a rig at the same time.
std::filesystem::path bench_folder(const std::string& suffix = {}) {
  return test_folder("bench-" + std::filesystem::read_symlink("/proc/self/exe").filename().string() + suffix);
}

std::filesystem::path make_fixture() {
  auto recipe = small("clear-noon", 4);
  recipe.start_utc = kStart;
  recipe.sky_period_s = 3.0;
  recipe.scene_period_s = 12.0;
  recipe.scene_frames = 1;
  recipe.sky_size = 240;
  recipe.scene_width = kWidth;
  recipe.scene_height = kHeight;
  const auto generated = recorded(recipe, bench_folder("-generated").filename().string());
  const auto folder = bench_folder();
  std::filesystem::remove_all(folder);
  std::filesystem::copy(generated, folder, std::filesystem::copy_options::recursive);
  std::filesystem::remove_all(folder / "scene");
  std::filesystem::remove_all(folder / "sky");
  write_scene(folder, generated);
  write_sky(folder, generated);
  return folder;
}

}  // namespace

const std::filesystem::path& bench_fixture() {
  static const auto folder = make_fixture();
  return folder;
}

std::optional<int> frame_number(const Image<Rgb8>& picture) {
  const auto seen = picture.at(kCorner / 2, kCorner / 2);
  for (int number = 0; number < kSceneFrames; ++number) {
    const auto colour = colour_of(number);
    const auto near = [](int a, int b) { return std::abs(a - b) <= 3; };
    if (near(seen.r, colour.r) && near(seen.g, colour.g) && near(seen.b, colour.b)) return number;
  }
  return std::nullopt;
}

std::filesystem::path write_config(const std::filesystem::path& folder, const std::string& clock_policy,
                                   const std::filesystem::path& fixture) {
  std::filesystem::create_directories(folder);
  for (const auto& entry : std::filesystem::directory_iterator(fixture))
    if (entry.is_regular_file())
      std::filesystem::copy_file(entry.path(), folder / entry.path().filename(),
                                 std::filesystem::copy_options::overwrite_existing);
  std::filesystem::create_directories(folder / "state");
  check(write_png(folder / "still.png", Image<Rgb8>(kWidth, kHeight, Rgb8{200, 40, 160})));
  auto text = read_text_file(fixture / "fixture.toml").value();
  text.erase(0, text.find("[site]"));
  const auto camera = [&](const char* name) {
    return fmt::format("\n[{}.camera]\nsource = \"replay\"\nfixture = \"{}\"\n", name, fixture.string());
  };
  text += camera("sky") + camera("scene");
  const auto scene = text.find("[scene]");  // of the scene camera's size
  int width = kWidth, height = kHeight;
  std::sscanf(text.c_str() + scene, "[scene] width = %d height = %d", &width, &height);
  text += fmt::format("\n[display]\nkind = \"headless\"\nwidth = {}\nheight = {}\n", width, height);
  text += "\n[still]\npicture = \"still.png\"\ncaption = \"The view returns in a moment.\"\n";
  text += "\n[words]\nlanguage = \"en\"\n";
  text += fmt::format("\n[clock]\npolicy = \"{}\"\n", clock_policy);
  text += "\n[state]\nfolder = \"state\"\n";
  check(write_text_file(folder / "kasumi.toml", text));
  return folder / "kasumi.toml";
}

CameraOpening BenchDevices::camera(CameraRole role, const CameraOptions& options) {
  auto opening = machine_->camera(role, options);
  opening.opener = with_faults(opening.opener, role == CameraRole::sky ? sky : scene, clock_);
  return opening;
}

Result<std::unique_ptr<Display>> BenchDevices::open_display(const DisplayOptions& options) {
  // Where no configuration is read it is the first screen that is found: the bench's.
  const auto* headless = std::get_if<HeadlessDisplayOptions>(&options);
  return open_faulty_display(headless ? *headless : HeadlessDisplayOptions{}, clock_, display);
}

Rig::Rig(RigOptions options)
    : folder(test_folder("appliance-" + options.name)),
      clock(options.utc.value_or(kStart)),
      devices(clock),
      given_at_(kSceneFrames),
      observe_every_(options.observe_every) {
  options.sky.observe_every = observe_every_;
  if (!options.keep_folder) std::filesystem::remove_all(folder);
  config = folder / "kasumi.toml";
  if (!options.keep_content) {
    write_config(folder, options.clock_policy, options.recording.empty() ? bench_fixture() : options.recording);
    check(write_text_file(config, options.first_config + read_text_file(config).value() + options.more_config));
  }
  devices.display = options.display;
  auto content = read_content(config);
  if (!content) {
    ADD_FAILURE() << content.error().message;
    return;
  }
  *content = in_its_era(*content, clock.utc());
  if (options.no_leaves) {
    auto cut = std::make_shared<Content>(**content);
    for (auto& share : cut->config.installation.scene.mask.elements())
      if (share > 0) share = 255;
    *content = std::move(cut);
  }
  devices.scene.gives = [this](std::uint32_t number) { given_at_[number % kSceneFrames] = clock.now(); };
  rested = resting(devices, options.starts ? options.starts->record() : StartRecord{}, clock);
  appliance = std::make_unique<Appliance>(
      config, *content, ApplianceServices{*rested, clock, time, notifier, {}, std::move(options.probes)},
      StatusOutputs{folder / "status.json", false, 10s, options.starts, folder / "sys"}, std::move(options.sky));
}

Rig::~Rig() {
  let_go(devices.scene);
  let_go(devices.sky);
}

void Rig::let_go(CameraFaults& camera) {
  camera.trap.let_go();
  auto& stuck = &camera == &devices.scene ? stuck_scene_ : stuck_sky_;
  if (stuck.joinable()) stuck.join();
}

void Rig::turn(CameraFaults& camera, std::thread& stuck, const std::function<void()>& step) {
  if (stuck.joinable()) return;
  if (!camera.trap.is_set()) return step();
  const auto ended = std::make_shared<std::atomic<bool>>(false);
  stuck = std::thread([step, ended] {
    step();
    *ended = true;
  });
  while (!*ended && !camera.trap.caught()) std::this_thread::yield();
  if (*ended) stuck.join();
}

void BenchDevices::serve(std::shared_ptr<InputLink> link) {
  const auto open = [this](const std::filesystem::path& path) { return open_fake_input(input, path); };
  inputs_.push_back(std::make_unique<Served>(std::move(link), open, clock_));
}

void BenchDevices::turn_inputs() {
  std::erase_if(inputs_, [](const auto& served) { return served->link->ended() && !served->in_turn; });
  for (auto& served : inputs_) {
    if (served->in_turn) continue;
    if (served->stuck.joinable()) served->stuck.join();
    const auto now = clock_.now();
    if (!input.devices[served->link->state().path].may_hang()) {
      served->link->turn(served->reader, now);
      continue;
    }
    served->in_turn = true;
    served->stuck = std::thread([&of = *served, now] {
      of.link->turn(of.reader, now);
      of.in_turn = false;
    });
    for (int i = 0; i < 20 && served->in_turn; ++i) std::this_thread::sleep_for(1ms);
  }
}

BenchDevices::~BenchDevices() {
  for (auto& served : inputs_)
    if (served->stuck.joinable()) served->stuck.join();
}

void Rig::tick(Duration by) {
  clock.advance(by);
  devices.turn_inputs();
  const auto deadline = clock.now();
  turn(devices.scene, stuck_scene_, [this, deadline] { appliance->scene().step(deadline); });
  turn(devices.sky, stuck_sky_, [this, deadline] { appliance->sky().step(deadline); });
  appliance->check().step();
  appliance->visibility().step();
  appliance->reload().step();
  if (!render_hangs) appliance->render().step();
  if (!horizon_at_ || clock.now() - *horizon_at_ >= observe_every_) {
    horizon_at_ = clock.now();
    appliance->horizon().step();
  }
  appliance->step_television();
  if (told_ && clock.now() - *told_ < 500ms) return;
  told_ = clock.now();
  appliance->status().step();
}

void Rig::advance(Duration by, Duration step) {
  for (Duration turned{}; turned < by; turned += step) tick(step);
}

std::optional<Duration> Rig::recover(const std::string& fault, Duration longest) {
  const auto took = advance_until([&] { return shown() == Shown::live && age_on_screen(); }, longest);
  if (took)
    std::printf("%-52s live after %.2f s\n", fault.c_str(), to_seconds(*took));
  else
    std::printf("%-52s not live within %.2f s\n", fault.c_str(), to_seconds(longest));
  return took;
}

Image<Rgb8> Rig::picture() {
  auto* display = appliance->render().display();
  if (!display) return {};
  auto read = read_picture(*display);
  return read ? std::move(*read) : Image<Rgb8>{};
}

bool Rig::shows_still() {
  const auto seen = picture();
  if (seen.empty()) return false;
  const auto& colour = seen.at(kCorner / 2, kCorner / 2);
  return std::abs(colour.r - 200) <= 2 && std::abs(colour.g - 40) <= 2 && std::abs(colour.b - 160) <= 2;
}

std::optional<Duration> Rig::age_on_screen() {
  const auto seen = picture();
  if (seen.empty()) return std::nullopt;
  const auto number = frame_number(seen);
  if (!number || !given_at_[static_cast<std::size_t>(*number)]) return std::nullopt;
  return clock.now() - *given_at_[static_cast<std::size_t>(*number)];
}

void replace_in(const std::filesystem::path& file, const std::string& from, const std::string& to) {
  auto text = read_text_file(file).value();
  const auto at = text.find(from);
  ASSERT_NE(at, std::string::npos) << from;
  text.replace(at, from.size(), to);
  ASSERT_TRUE(write_text_file(file, text));
}

// The memory of a process at address 0: nothing is mapped there.
void make_unreadable(const std::filesystem::path& file) {
  std::filesystem::remove(file);
  std::filesystem::create_symlink("/proc/self/mem", file);
}

std::unique_ptr<Rig> running(RigOptions options) {
  auto rig = std::make_unique<Rig>(std::move(options));
  rig->advance(4s);
  EXPECT_EQ(rig->shown(), Shown::live) << name_of(rig->trouble());
  EXPECT_TRUE(rig->status().sky.report.seen_air()) << rig->status().sky.report.estimate.reason;
  return rig;
}

}  // namespace kasumi
