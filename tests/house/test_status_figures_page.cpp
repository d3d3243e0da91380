// docs/fleet.md has the figures of status.json as base/status/status_figures.hpp has them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "base/status/status_figures.hpp"
#include "tests/house/repository.hpp"

namespace kasumi::house {
namespace {

std::string believed_text(const Believed& believed) {
  switch (believed.kind) {
    case FigureKind::flag: return "true, false";
    case FigureKind::is_so: return "true; else no";
    case FigureKind::sum: return "counts, summed";
    case FigureKind::number: break;
  }
  if (believed.highest == kCounted.highest) return "a count";
  return fmt::format("{} to {}", believed.lowest, believed.highest);
}

std::string in_code(std::string_view prefix, std::string_view name) {
  return name.empty() ? std::string() : fmt::format("`{}{}`", prefix, name);
}

std::string figure_lines(const StatusFigure& figure, const std::string& key) {
  const auto& shown = figure.shown;
  return fmt::format("| {} | {} | {} | {} | {} | {} |\n", key, figure.what, believed_text(figure.believed),
                     in_code("kasumi_", figure.metric), in_code("", figure.mqtt), shown.text.empty() ? "" : "yes");
}

TEST(StatusFiguresPage, IsMadeFromTheTable) {
  std::string table =
      "| in `status.json` | what | believed | metric | MQTT | page and entity |\n|---|---|---|---|---|---|\n";
  for (const auto& figure : kStatusFigures) table += figure_lines(figure, in_code("", figure.key));
  for (const auto& figure : kCameraFigures) table += figure_lines(figure, in_code("CAMERA.", figure.key));
  const auto page = read_text_file(source_folder() / "docs/fleet.md").value();
  const auto made = test_output_folder() / "status-figures.md";
  std::filesystem::create_directories(made.parent_path());
  std::ofstream(made) << table;
  EXPECT_NE(page.find("\n" + table + "\n"), std::string::npos)
      << "docs/fleet.md: expected the table as it is in " << made;
}

}  // namespace
}  // namespace kasumi::house
