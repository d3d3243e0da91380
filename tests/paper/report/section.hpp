// A part of the report: one table or figure of the papers next to ours.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "base/image.hpp"
#include "base/picture.hpp"
#include "base/result.hpp"
#include "tests/paper/report/svg_plot.hpp"

namespace kasumi::paper {

// reproduced: the papers' figures are reproduced. better: ours are closer to the truth. differs: not reproduced, with
// the reason. skipped: could not be computed here, with the reason.
enum class Finding { reproduced, better, differs, skipped };
std::string_view name_of(Finding finding);

struct ReportOptions {
  std::filesystem::path shared_data;  // real pictures; optional
  bool quick = false;  // small pictures and few repeats: checks that it works; figures are not meaningful
};

class Section {
 public:
  Section(std::string id, std::string title) : id_(std::move(id)), title_(std::move(title)) {}

  void say(std::string_view text);  // plain text
  void table(const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows);
  void plot(const Plot& plot);
  // As JPEG inside the page; the picture in the page is at most as wide as `shown_px`.
  void picture(const Image<Rgb8>& picture, std::string_view caption, int shown_px = 640);
  void finding(Finding finding, std::string_view words);
  // Machine-readable figures, next to the page.
  void figure(const std::string& name, double value) { figures_[name] = value; }

  const std::string& id() const { return id_; }
  const std::string& title() const { return title_; }
  const std::string& body() const { return body_; }
  const std::vector<std::pair<Finding, std::string>>& findings() const { return findings_; }
  const std::map<std::string, double>& figures() const { return figures_; }

 private:
  std::string id_, title_, body_;
  std::vector<std::pair<Finding, std::string>> findings_;
  std::map<std::string, double> figures_;
};

// index.html (nothing fetched, no script) and figures.json in `folder`. Errors: io.
Result<> write_report(const std::filesystem::path& folder, const std::vector<Section>& sections,
                      const ReportOptions& options);

// The sections, in the order of the page.
Section turbidity_section(const ReportOptions& options);      // M Table 1, M14 Table 1 and 2
Section scattering_section(const ReportOptions& options);     // M Table 2, Fig 9 and 10, Eq 24
Section sky_pictures_section(const ReportOptions& options);   // M Fig 7 and 8, M14 Fig 6
Section terms_section(const ReportOptions& options);          // M Fig 11, M14 Fig 7
Section mixed_reality_section(const ReportOptions& options);  // M Fig 1 and 14, M14 Fig 9, P Fig 1
Section scenes_section(const ReportOptions& options);         // M Fig 12 and 13, generated scenes
Section photographs_section(const ReportOptions& options);    // the same on real material
Section classic_section(const ReportOptions& options);        // hazy photographs without distances
Section landmarks_section(const ReportOptions& options);      // visibility from landmarks
Section haze_section(const ReportOptions& options);           // H Fig 2, 6, 7
Section haze_pictures_section(const ReportOptions& options);  // H Fig 1, 3, 4, 5
Section report_u_section(const ReportOptions& options);       // U Table 3.1
Section frame_rate_section(const ReportOptions& options);     // M Sect 7.3
// All of them; `done` is called after each.
std::vector<Section> all_sections(const ReportOptions& options, const std::function<void(const Section&)>& done = {});

}  // namespace kasumi::paper
