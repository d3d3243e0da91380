#include "pipeline/lab/bench/machine_board.hpp"

#include <sys/resource.h>
#include <sys/utsname.h>

#include <algorithm>
#include <cstdio>
#include <cstring>

#include <fmt/ranges.h>

#include "base/files.hpp"
#include "pipeline/lab/bench/recorded_run.hpp"
#include "pipeline/machine/kernel_files.hpp"

namespace kasumi {
namespace {

constexpr std::size_t kCopied = 64u << 20;  // bytes: more than any cache
constexpr int kCopies = 9;

// "Raspberry Pi 4 Model B Rev 1.4" by the device tree, else by the firmware of a PC.
std::string board_of(const BoardPlaces& places) {
  std::string model = line_of(places.proc / "device-tree" / "model");
  if (const auto end = model.find('\0'); end != std::string::npos) model.resize(end);
  if (!model.empty()) return model;
  const auto dmi = places.sys / "class" / "dmi" / "id";
  model = fmt::format("{} {}", line_of(dmi / "sys_vendor"), line_of(dmi / "product_name"));
  return model == " " ? "not known" : model;
}

std::string speeds_of(const BoardPlaces& places) {
  std::vector<std::string> speeds;
  for (const auto& policy : entries_of(places.sys / "devices" / "system" / "cpu" / "cpufreq", "policy"))
    if (const auto most_khz = number_of(policy / "cpuinfo_max_freq"))
      speeds.push_back(
          fmt::format("{:.0f} MHz at most ({})", *most_khz / 1000.0, line_of(policy / "scaling_governor")));
  return fmt::format("{}", fmt::join(speeds, ", "));
}

// Bytes read and written.
double copied_gb_per_s() {
  std::vector<char> from(kCopied, 1), to(kCopied, 2);
  char sink = 0;
  const double seconds = least_seconds_of(
      [&] {
        std::memcpy(to.data(), from.data(), kCopied);
        sink = static_cast<char>(sink + to[kCopied / 2]);
      },
      kCopies);
  return sink == 0 ? 0.0 : 2e-9 * static_cast<double>(kCopied) / seconds;
}

}  // namespace

std::string machine_text(const BoardPlaces& places) {
  utsname kernel{};
  ::uname(&kernel);
  std::string text =
      fmt::format("board: {}\nkernel: {} {} {}\nprocessor: {}\n", board_of(places), kernel.sysname, kernel.release,
                  kernel.machine, processor_of(read_text_file(places.proc / "cpuinfo").value_or("")));
  if (const auto speeds = speeds_of(places); !speeds.empty()) text += "speed: " + speeds + "\n";
  const auto memory = line_of(places.proc / "meminfo");  // "MemTotal:        3884376 kB"
  if (memory.starts_with("MemTotal:")) text += "memory: " + memory.substr(memory.find_first_not_of(" ", 9)) + "\n";
  return text;
}

std::string displays_text(const std::vector<ListedCard>& cards) {
  if (cards.empty()) return "planes: no graphics card with a display: the GPU composes each picture\n";
  std::string text;
  for (const auto& card : cards) {
    text += fmt::format("card: {}{}{}\n", card.driver.empty() ? "not known" : card.driver,
                        card.atomic ? ", atomic" : "", card.problem.empty() ? "" : ": " + card.problem);
    for (const auto& connector : card.connectors)
      text += fmt::format("connector: {} {}, now {}, prefers {}\n", connector.name, connector.connection,
                          connector.mode_now.empty() ? "off" : connector.mode_now,
                          connector.preferred.empty() ? "nothing" : connector.preferred);
    for (const auto& plane : card.planes) text += "plane: " + plane + "\n";
    if (!card.plane_formats.empty())
      text += fmt::format("planes: {} lays the building over pictures in {} by itself\n", card.driver,
                          fmt::join(card.plane_formats, ", "));
    else if (card.problem.empty())
      text += fmt::format("planes: {}: the GPU composes each picture: {}\n", card.driver,
                          card.no_planes.empty() ? "no display is connected" : card.no_planes);
  }
  return text;
}

std::string decoders_text(const std::vector<V4l2Decoder>& decoders) {
  if (decoders.empty()) return "decoder: none by V4L2, or not for this account\n";
  std::string text;
  for (const auto& decoder : decoders)
    text += fmt::format("decoder: {}: {} to {}\n", decoder.driver, fmt::join(decoder.from, " "),
                        fmt::join(decoder.to, " "));
  return text;
}

void print_board(const std::string& version) {
  const double seconds = seconds_of([&] {
    fmt::print("kasumi: {}\n{}copied: {:.2f} GB/s, read and written, one core\n{}{}", version, machine_text(),
               copied_gb_per_s(), displays_text(list_displays()), decoders_text(list_v4l2_decoders()));
    std::fflush(stdout);
    if (const auto drawing = draw_for_board(); !drawing) {
      fmt::print("gl: {}\n", drawing.error().message);
    } else {
      fmt::print("gl: {}\nmixed by: {}\n", drawing->gl, drawing->path);
      for (const auto& row : drawing->rows) fmt::print("{:<72} {:>9.3g} {}\n", row.name, row.value, row.unit);
    }
  });
  rusage used{};
  ::getrusage(RUSAGE_SELF, &used);
  fmt::print("{:<72} {:>9.3g} MB\n{:<72} {:>9.3g} s\n", "peak of this program's memory",
             static_cast<double>(used.ru_maxrss) / 1024.0, "all of this", seconds);
}

}  // namespace kasumi
