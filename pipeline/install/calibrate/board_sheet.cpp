#include "pipeline/install/calibrate/board_sheet.hpp"

#include <array>
#include <iterator>

#include <fmt/format.h>

#include "pipeline/site/files/html.hpp"

namespace kasumi {

namespace {

constexpr double kMargin_mm = 8.0, kFooter_mm = 10.0;
constexpr double kPointsPerMm = 72.0 / 25.4;

struct Paper {
  std::string_view name;
  double wide_mm, tall_mm;
};
constexpr std::array kPapers{Paper{"A4", 297, 210}, Paper{"A3", 420, 297}, Paper{"A2", 594, 420}, Paper{"A1", 841, 594},
                             Paper{"A0", 1189, 841}};

glm::dvec2 size_mm_of(const AnyBoard& board) {
  if (const auto* charuco = std::get_if<CharucoBoard>(&board))
    return 1e3 * charuco->square_m * glm::dvec2{charuco->columns, charuco->rows};
  const auto& plain = std::get<Board>(board);
  return 1e3 * plain.square_m * glm::dvec2{plain.columns + 1, plain.rows + 1};
}

}  // namespace

Result<BoardSheet> lay_out(const AnyBoard& board) {
  const auto size = size_mm_of(board);
  for (const auto& paper : kPapers) {
    const glm::dvec2 room{paper.wide_mm - 2 * kMargin_mm, paper.tall_mm - 2 * kMargin_mm - kFooter_mm};
    if (size.x > room.x || size.y > room.y) continue;
    BoardSheet sheet{std::string(paper.name), {paper.wide_mm, paper.tall_mm}, {}, {}, {}};
    const glm::dvec2 corner_mm{0.5 * (paper.wide_mm - size.x), kMargin_mm + 0.5 * (room.y - size.y)};
    sheet.black = std::visit([](const auto& any) { return black_of(any); }, board);
    for (auto& box : sheet.black) box.corner_m += 1e-3 * corner_mm;
    sheet.ruler_mm = {kMargin_mm, paper.tall_mm - kMargin_mm};
    sheet.caption = fmt::format("{}; the line is {:.0f} mm, printed at 100 %", description_of(board), kRuler_mm);
    return sheet;
  }
  return fail(FaultKind::bad_input, "a board of {:.0f} x {:.0f} mm: expected one that fits on A0, {:.0f} x {:.0f} mm",
              size.x, size.y, kPapers.back().wide_mm - 2 * kMargin_mm,
              kPapers.back().tall_mm - 2 * kMargin_mm - kFooter_mm);
}

std::string svg_of(const BoardSheet& sheet) {
  std::string text = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}mm\" "
      "height=\"{1}mm\" viewBox=\"0 0 {0} {1}\">\n<rect width=\"{0}\" height=\"{1}\" fill=\"#fff\"/>\n"
      "<g fill=\"#000\" shape-rendering=\"crispEdges\">\n",
      sheet.page_mm.x, sheet.page_mm.y);
  for (const auto& box : sheet.black)
    fmt::format_to(std::back_inserter(text), "<rect x=\"{:.6g}\" y=\"{:.6g}\" width=\"{:.6g}\" height=\"{:.6g}\"/>\n",
                   1e3 * box.corner_m.x, 1e3 * box.corner_m.y, 1e3 * box.side_m, 1e3 * box.side_m);
  fmt::format_to(std::back_inserter(text),
                 "</g>\n<path d=\"M{0} {1}v-3v1.5h{2}v-1.5v3\" fill=\"none\" stroke=\"#000\" stroke-width=\"0.2\"/>\n"
                 "<text x=\"{3}\" y=\"{1}\" font-family=\"sans-serif\" font-size=\"2.6\">{4}</text>\n</svg>\n",
                 sheet.ruler_mm.x, sheet.ruler_mm.y, kRuler_mm, sheet.ruler_mm.x + kRuler_mm + 4.0,
                 html_escaped(sheet.caption));
  return text;
}

std::string pdf_of(const BoardSheet& sheet) {
  // Millimetres from the top left corner, y down, as in the rest of this file.
  std::string drawing =
      fmt::format("{0:.6f} 0 0 {1:.6f} 0 {2:.6f} cm\n", kPointsPerMm, -kPointsPerMm, kPointsPerMm * sheet.page_mm.y);
  for (const auto& box : sheet.black)
    fmt::format_to(std::back_inserter(drawing), "{:.6g} {:.6g} {:.6g} {:.6g} re\n", 1e3 * box.corner_m.x,
                   1e3 * box.corner_m.y, 1e3 * box.side_m, 1e3 * box.side_m);
  const double x = sheet.ruler_mm.x, y = sheet.ruler_mm.y;
  std::string escaped;
  for (const char c : sheet.caption) {
    if (c == '(' || c == ')' || c == '\\') escaped += '\\';
    escaped += c;
  }
  fmt::format_to(std::back_inserter(drawing),
                 "f\n0.2 w {0} {1} m {0} {2} l S {0} {3} m {4} {3} l S {4} {1} m {4} {2} l S\n"
                 "BT /F1 2.6 Tf 1 0 0 -1 {5} {1} Tm ({6}) Tj ET\n",
                 x, y, y - 3.0, y - 1.5, x + kRuler_mm, x + kRuler_mm + 4.0, escaped);

  const std::array objects{
      std::string("<< /Type /Catalog /Pages 2 0 R >>"), std::string("<< /Type /Pages /Kids [3 0 R] /Count 1 >>"),
      fmt::format("<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {:.4f} {:.4f}] /Contents 4 0 R /Resources << /Font << "
                  "/F1 5 0 R >> >> >>",
                  kPointsPerMm * sheet.page_mm.x, kPointsPerMm * sheet.page_mm.y),
      fmt::format("<< /Length {} >>\nstream\n{}endstream", drawing.size(), drawing),
      std::string("<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica /Encoding /WinAnsiEncoding >>")};
  std::string pdf = "%PDF-1.4\n", index;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    index += fmt::format("{:010} 00000 n \n", pdf.size());
    pdf += fmt::format("{} 0 obj\n{}\nendobj\n", i + 1, objects[i]);
  }
  pdf +=
      fmt::format("xref\n0 {0}\n0000000000 65535 f \n{1}trailer\n<< /Size {0} /Root 1 0 R >>\nstartxref\n{2}\n%%EOF\n",
                  objects.size() + 1, index, pdf.size());
  return pdf;
}

}  // namespace kasumi
