// Writes the papers' tables and figures next to ours as one page: paper_report --out out/papers
#include <cstdio>
#include <exception>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "tests/figures.hpp"
#include "tests/paper/report/section.hpp"
#include "tests/places.hpp"

namespace {

using namespace kasumi;
using namespace kasumi::paper;

int write(const std::filesystem::path& out, const ReportOptions& options) {
  std::error_code error;
  std::filesystem::create_directories(out, error);
  if (error) {
    fmt::print(stderr, "{}: {}\n", out.string(), error.message());
    return 1;
  }
  const auto sections = all_sections(options, [&options](const Section& section) {
    fmt::print("{}\n", section.title());
    for (const auto& [finding, words] : section.findings()) {
      fmt::print("  {}: {}\n", name_of(finding), words);
      if (finding != Finding::skipped && !options.quick)
        figure_row("papers-findings", {section.title(), std::string(name_of(finding)), words});
    }
    std::fflush(stdout);
  });
  if (auto done = write_report(out, sections, options); !done) {
    fmt::print(stderr, "{}\n", done.error().message);
    return 1;
  }
  fmt::print("{}\n", (out / "index.html").string());
  return 0;
}

}  // namespace

int main(int argc, char** argv) try {
  CLI::App app("The papers' tables and figures next to ours, as one self-contained page");
  std::filesystem::path out;
  ReportOptions options;
  options.shared_data = shared_data_folder();
  app.add_option("--out", out, "Folder for index.html and figures.json")->required();
  app.add_option("--data", options.shared_data,
                 "Folder of real pictures; sections that need them are skipped when it is missing");
  app.add_flag("--quick", options.quick,
               "Few repeats and small pictures: checks that it works; figures are not meaningful");
  CLI11_PARSE(app, argc, argv);
  return write(out, options);
} catch (const std::exception& error) {
  std::fprintf(stderr, "paper_report: %s\n", error.what());
  return 1;
}
