#include "pipeline/lab/bench/peers.hpp"

#include <chrono>
#include <cstdlib>
#include <functional>
#include <optional>
#include <sstream>

#include "base/files.hpp"
#include "base/statistics.hpp"
#include "capture/fixture/fixture.hpp"
#include "pipeline/lab/bench/child_process.hpp"

namespace kasumi {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;

constexpr int kFew = 20, kMany = 220, kRounds = 3;
constexpr Duration kAtMost = std::chrono::minutes(3);

struct Player {
  std::string name;
  std::string program;  // must be installed
  std::function<std::vector<std::string>(int pictures)> command;
  std::optional<double> goal{};  // for our processor time over its own
};

// The fixture's frames at 30 a second, over and over, with one picture of the sky; and the same frames as 000000.jpg ...
Result<> lay_out(const fs::path& fixture, const fs::path& work) {
  auto scene = read_index(fixture / "scene");
  if (!scene) return fail(scene.error());
  const auto sky = read_index(fixture / "sky");
  if (!sky) return fail(sky.error());
  std::erase_if(*scene, [](const IndexRow& row) { return row.disconnected || row.payload.empty(); });
  if (scene->empty() || sky->empty())
    return fail(FaultKind::bad_input, "{}: has no frames: expected some of both cameras", fixture.string());
  for (const auto& row : *scene)
    if (row.metadata.format != kMjpg)
      return fail(FaultKind::bad_input, "{}: scene/index.csv, line {}: {}: expected frames in MJPG", fixture.string(),
                  row.line, row.metadata.format.text());
  try {
    fs::create_directories(work / "scene");
    fs::create_directories(work / "sky");
    for (const auto& entry : fs::directory_iterator(fixture))
      if (entry.is_regular_file()) fs::create_symlink(fs::absolute(entry.path()), work / entry.path().filename());
    fs::copy_file(fixture / "sky" / sky->front().payload, work / "sky" / sky->front().payload);
    for (std::size_t i = 0; i < std::size_t{kMany}; ++i) {
      const auto file = fs::absolute(fixture / "scene" / (*scene)[i % scene->size()].payload);
      fs::create_symlink(file, work / fmt::format("{:06}.jpg", i));
      fs::copy_file(file, work / "scene" / file.filename(),
                    fs::copy_options::skip_existing);  // links are refused there
    }
  } catch (const fs::filesystem_error& error) {
    return fail(FaultKind::io, "{}", error.what());
  }
  const auto header = std::string(kIndexHeader) + "\n";
  std::string rows = header;
  for (int i = 0; i < kMany; ++i) {
    IndexRow row = (*scene)[static_cast<std::size_t>(i) % scene->size()];
    row.metadata.captured_at = scene->front().metadata.captured_at + i * milliseconds(33);
    row.metadata.utc = scene->front().metadata.utc + i * milliseconds(33);
    row.metadata.sequence = static_cast<std::uint32_t>(i);
    rows += index_line(row) + "\n";
  }
  if (auto written = write_text_file(work / "scene" / "index.csv", rows); !written) return written;
  return write_text_file(work / "sky" / "index.csv", header + index_line(sky->front()) + "\n");
}

// Text of a fixture.toml with its building behind the camera.
std::string turned_round(const std::string& fixture) {
  std::istringstream lines(fixture);
  std::string turned, table;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with('[')) table = line;
    const auto key = line.substr(0, line.find(' '));
    const auto equals = line.find('=');
    if (table == "[object]" && (key == "east_m" || key == "north_m") && equals != std::string::npos)
      line = fmt::format("{} = {:.3f}", key, -std::strtod(line.c_str() + equals + 1, nullptr));
    turned += line + "\n";
  }
  return turned;
}

// The folder of `lay_out` once more, without a building to be seen.
Result<> lay_out_without_building(const fs::path& work, const fs::path& empty) {
  const auto text = read_text_file(work / "fixture.toml");
  if (!text) return fail(text.error());
  try {
    fs::create_directories(empty);
    for (const auto& entry : fs::directory_iterator(work))
      if (const auto name = entry.path().filename();
          name != "fixture.toml" && name != empty.filename() && entry.path().extension() != ".jpg")
        fs::create_symlink(entry.path(), empty / name);
  } catch (const fs::filesystem_error& error) {
    return fail(FaultKind::io, "{}", error.what());
  }
  return write_text_file(empty / "fixture.toml", turned_round(*text));
}

std::vector<Player> players(const fs::path& work, const fs::path& empty) {
  const auto gstreamer = [work](std::vector<std::string> sink) {
    return [work, sink = std::move(sink)](int pictures) {
      std::vector<std::string> command{"gst-launch-1.0",
                                       "-q",
                                       "multifilesrc",
                                       fmt::format("location={}/%06d.jpg", work.string()),

                                       fmt::format("num-buffers={}", pictures),
                                       "caps=image/jpeg,framerate=30/1",
                                       "!",
                                       "jpegdec",
                                       "!"};
      command.insert(command.end(), sink.begin(), sink.end());
      return command;
    };
  };
  const auto ours = [](const fs::path& fixture) {
    return [fixture](int pictures) {
      return std::vector<std::string>{"/proc/self/exe", "replay",   fixture.string(),
                                      "--window",       "--frames", std::to_string(pictures)};
    };
  };
  const auto mpv = [work](int pictures) {
    return std::vector<std::string>{"mpv",
                                    "--no-config",
                                    "--really-quiet",
                                    "--untimed",
                                    "--no-audio",
                                    "--vo=gpu",
                                    "--gpu-sw=yes",

                                    "--mf-fps=30",
                                    fmt::format("--frames={}", pictures),
                                    fmt::format("mf://{}/0*.jpg", work.string())};
  };
  return {{"kasumi with building and air", "", ours(work)},
          {"kasumi with the camera's picture alone", "", ours(empty)},
          {"gst jpegdec ! glupload ! glcolorconvert ! glimagesink", "gst-launch-1.0",
           gstreamer({"glupload", "!", "glcolorconvert", "!", "glimagesink", "sync=false"}), 0.45},
          {"gst jpegdec ! glupload ! glcolorconvert ! fakesink", "gst-launch-1.0",
           gstreamer({"glupload", "!", "glcolorconvert", "!", "fakesink"})},
          {"gst jpegdec ! videoconvert ! ximagesink", "gst-launch-1.0",
           gstreamer({"videoconvert", "!", "ximagesink", "sync=false"})},
          {"gst jpegdec ! videoconvert ! kmssink", "gst-launch-1.0",
           gstreamer({"videoconvert", "!", "kmssink", "sync=false"})},
          {"mpv --vo=gpu", "mpv", mpv}};
}

struct PlayerCost {
  std::vector<double> picture_ms;  // of processor time
  std::vector<double> first_s;     // start, one picture, end
};

Result<double> processor_s(const Player& player, int pictures) {
  const auto cost = run_child(player.command(pictures), kAtMost);
  if (!cost) return fail(cost.error());
  if (cost->exit_code != 0)
    return fail(FaultKind::device, "{}: exit code {}: {}", player.name, cost->exit_code, cost->last_words);
  return cost->processor_s;
}

Result<> play(const Player& player, PlayerCost& cost) {
  const auto few = processor_s(player, kFew), many = processor_s(player, kMany);
  if (!few) return fail(few.error());
  if (!many) return fail(many.error());
  cost.picture_ms.push_back(1e3 * (*many - *few) / (kMany - kFew));
  const auto first = run_child(player.command(1), kAtMost);
  if (!first) return fail(first.error());
  cost.first_s.push_back(first->wall_s);
  return {};
}

}  // namespace

Result<PeerRows> bench_peers(const fs::path& fixture) {
  const WorkFolder work;
  if (work.path().empty()) return fail(FaultKind::io, "no temporary folder can be made");
  if (auto laid = lay_out(fixture, work.path()); !laid) return fail(laid.error());
  const fs::path empty = work.path() / "empty";
  if (auto laid = lay_out_without_building(work.path(), empty); !laid) return fail(laid.error());
  std::optional<VirtualDesktop> desktop;
  if (!std::getenv("DISPLAY") && !std::getenv("WAYLAND_DISPLAY")) {
    auto started = VirtualDesktop::start(1920, 1080);
    if (!started) return fail(started.error());
    desktop.emplace(std::move(*started));
  }

  PeerRows result;
  std::vector<Player> all = players(work.path(), empty);
  std::vector<PlayerCost> costs(all.size());
  std::vector<bool> plays(all.size(), true);
  for (int round = 0; round < kRounds; ++round)
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (!plays[i]) continue;
      const bool here = all[i].program.empty() || is_installed(all[i].program);
      const auto played =
          here ? play(all[i], costs[i]) : Result<>(fail(FaultKind::unsupported, "{}: not installed", all[i].name));
      if (played) continue;
      if (all[i].program.empty()) return fail(played.error());
      plays[i] = false;
      result.skipped.push_back(played.error().message);
    }
  const auto row = [&](std::string name, double value, std::string unit, std::optional<double> goal = {}) {
    result.rows.push_back({.name = std::move(name), .value = value, .unit = std::move(unit), .goal = goal});
  };
  const double ours = median(costs[0].picture_ms);
  for (std::size_t i = 1; i < all.size(); ++i)
    if (plays[i])
      row(fmt::format("processor time of a picture, ours / {}", all[i].name), ours / median(costs[i].picture_ms), "x",
          all[i].goal);
  for (std::size_t i = 0; i < all.size(); ++i)
    if (plays[i]) row(fmt::format("  {}", all[i].name), median(costs[i].picture_ms), "ms");
  row("from start to the end after one picture, ours", median(costs[0].first_s), "s", 1.0);
  for (std::size_t i = 1; i < all.size(); ++i)
    if (plays[i]) row(fmt::format("  {}, start to end", all[i].name), median(costs[i].first_s), "s");
  return result;
}

}  // namespace kasumi
