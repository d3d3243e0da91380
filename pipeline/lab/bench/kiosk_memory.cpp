#include "pipeline/lab/bench/kiosk_memory.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <sstream>
#include <thread>

#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "pipeline/lab/bench/child_process.hpp"

namespace kasumi {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using std::chrono::steady_clock;

constexpr int kWidth = 1920, kHeight = 1080;
constexpr auto kLiveWithin = 3min;
constexpr auto kSettling = 35s;  // the layer is redrawn once, and the allocator has given back what the start took

// kasumi.toml of the fixture's site, cameras and building.
Result<fs::path> lay_out_kiosk(const fs::path& fixture, const fs::path& work) {
  const auto text = read_text_file(fixture / "fixture.toml");
  if (!text) return fail(text.error());
  const auto tables = text->find("\n[");
  if (tables == std::string::npos)
    return fail(FaultKind::bad_input, "{}: no tables: expected those of a fixture",
                (fixture / "fixture.toml").string());
  std::string config = text->substr(tables + 1);
  for (const char* camera : {"sky", "scene"})
    config +=
        fmt::format("\n[{}.camera]\nsource = \"replay\"\nfixture = \"{}\"\n", camera, fs::absolute(fixture).string());
  config += fmt::format("\n[display]\nkind = \"headless\"\nwidth = {}\nheight = {}\n", kWidth, kHeight);
  config += "\n[clock]\npolicy = \"trusted\"\n";
  std::error_code failed;
  for (const auto& entry : fs::directory_iterator(fixture, failed))
    if (entry.is_regular_file()) fs::copy_file(entry.path(), work / entry.path().filename(), failed);
  if (failed) return fail(FaultKind::io, "{}: {}", fixture.string(), failed.message());
  if (auto written = write_text_file(work / "kasumi.toml", config); !written) return fail(written.error());
  return work / "kasumi.toml";
}

// Errors: device.
Result<> wait_until_live(const Child& kiosk, const fs::path& status) {
  for (const auto began = steady_clock::now(); steady_clock::now() - began < kLiveWithin;) {
    if (!kiosk.is_running()) return fail(FaultKind::device, "the kiosk ended: {}", kiosk.last_words());
    if (const auto text = read_text_file(status)) {
      const auto json = nlohmann::json::parse(*text, nullptr, false);
      if (json.is_object() && json.value("shown", "") == "live") return {};
    }
    std::this_thread::sleep_for(200ms);
  }
  return fail(FaultKind::device, "the kiosk shows no live picture: {}", kiosk.last_words());
}

bool is_of_gl(const std::string& file) {
  constexpr std::array<const char*, 5> kNames{"/libLLVM", "_dri.so", "/libgallium", "/libGL", "/libEGL"};
  return std::ranges::any_of(kNames, [&](const char* name) { return file.find(name) != std::string::npos; });
}

}  // namespace

// A mapping is a line with its addresses and file, then lines of "Name: 12 kB".
ResidentMemory resident_memory(const std::string& smaps) {
  ResidentMemory memory;
  std::istringstream lines(smaps);
  bool of_gl = false;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string name;
    double kb = 0.0;
    words >> name;
    if (!name.ends_with(':')) {
      of_gl = is_of_gl(line);
      continue;
    }
    if (!(words >> kb)) continue;
    if (name == "Rss:") memory.all_kb += kb;
    if (name == "Anonymous:") memory.own_kb += kb;
    if (of_gl && name == "Rss:") memory.gl_files_kb += kb;
    if (of_gl && name == "Anonymous:") memory.gl_files_kb -= kb;
  }
  return memory;
}

Result<std::vector<BenchRow>> bench_memory(const fs::path& fixture) {
  const WorkFolder work;
  if (work.path().empty()) return fail(FaultKind::io, "no temporary folder can be made");
  const auto config = lay_out_kiosk(fixture, work.path());
  if (!config) return fail(config.error());
  const auto status = work.path() / "status.json";
  const auto kiosk = Child::start({"/proc/self/exe", "run", "--config", config->string(), "--status", status.string()});
  if (!kiosk) return fail(kiosk.error());
  if (auto live = wait_until_live(*kiosk, status); !live) return fail(live.error());
  std::this_thread::sleep_for(kSettling);
  const auto smaps = read_text_file(fmt::format("/proc/{}/smaps", kiosk->pid()));
  if (!smaps || !kiosk->is_running()) return fail(FaultKind::device, "the kiosk ended: {}", kiosk->last_words());
  const auto memory = resident_memory(*smaps);
  const auto mb = [](double kb) { return 1.024e-3 * kb; };  // the kernel's kilobyte has 1024 bytes
  return std::vector<BenchRow>{{.name = "a running kiosk on a screen of full HD: resident memory",
                                .value = mb(memory.all_kb),
                                .unit = "MB",
                                .goal = 300.0},
                               {.name = "  without the pages of the GL driver's files",
                                .value = mb(memory.all_kb - memory.gl_files_kb),
                                .unit = "MB",
                                .goal = 250.0},
                               {.name = "  what it has written itself, software GL's textures and shaders included",
                                .value = mb(memory.own_kb),
                                .unit = "MB",
                                .goal = std::nullopt}};
}

}  // namespace kasumi
