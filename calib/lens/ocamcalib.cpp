#include <cmath>
#include <sstream>

#include "base/files.hpp"
#include "calib/lens/lens.hpp"

namespace kasumi {
namespace {

// The file's lines of numbers; comments and empty lines are left out.
std::vector<std::vector<double>> number_lines(const std::string& text, Problems& problems) {
  std::vector<std::vector<double>> lines;
  std::istringstream file(text);
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    const auto start = line.find_first_not_of(" \t\r");
    if (start == std::string::npos || line[start] == '#') continue;
    std::istringstream stream(line);
    std::vector<double> values;
    for (double value; stream >> value;) values.push_back(value);
    stream.clear();
    std::string rest;
    if (stream >> rest) problems.add("line {}: \"{}\" is not a number", number, rest);
    lines.push_back(std::move(values));
  }
  return lines;
}

}  // namespace

Result<ScaramuzzaParameters> read_ocamcalib(const std::filesystem::path& path) {
  const auto text = read_text_file(path);
  if (!text) return fail(text.error());

  Problems problems;
  const auto lines = number_lines(*text, problems);
  if (lines.size() != 5) {
    problems.add(
        "{} lines of numbers: expected five (polynomial, inverse polynomial, centre, affine parameters, image size), "
        "as "
        "OCamCalib exports them",
        lines.size());
  } else {
    const auto& polynomial = lines[0];
    if (polynomial.size() < 3 || polynomial[0] != static_cast<double>(polynomial.size() - 1))
      problems.add("polynomial: expected the number of coefficients and then as many coefficients, at least two");
    else if (!(polynomial[1] < 0.0))
      problems.add("polynomial: a0 = {}: expected a number < 0 (a model with the opposite sign: turn every sign)",
                   polynomial[1]);
    if (lines[2].size() != 2) problems.add("centre: expected two numbers, row and column");
    if (lines[3].size() != 3)
      problems.add("affine parameters: expected three numbers, c, d and e");
    else if (!(lines[3][0] - lines[3][1] * lines[3][2] > 0.0))
      problems.add("affine parameters c, d, e = {}, {}, {}: expected c - d e > 0", lines[3][0], lines[3][1],
                   lines[3][2]);
    if (lines[4].size() != 2 || !(lines[4][0] >= 1.0) || !(lines[4][1] >= 1.0))
      problems.add("image size: expected two numbers, height and width");
  }
  if (!problems.empty()) {
    Problems named;
    for (const auto& line : problems.lines()) named.add("{}: {}", path.string(), line);
    return fail(named.fault());
  }

  ScaramuzzaParameters model;
  model.polynomial.assign(lines[0].begin() + 1, lines[0].end());
  model.centre = {lines[2][1], lines[2][0]};
  model.c = lines[3][0];
  model.d = lines[3][1];
  model.e = lines[3][2];
  model.width = static_cast<int>(lines[4][1]);
  model.height = static_cast<int>(lines[4][0]);
  return model;
}

}  // namespace kasumi
