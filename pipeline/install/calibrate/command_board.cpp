#include <CLI/CLI.hpp>

#include "base/files.hpp"
#include "pipeline/install/calibrate/board_options.hpp"
#include "pipeline/install/calibrate/board_sheet.hpp"
#include "pipeline/install/calibrate/command_calibrate.hpp"

namespace kasumi {

namespace {

struct SheetRequest {
  BoardOptions board;
  std::string out;
};

Result<int> write_sheet(const SheetRequest& arguments) {
  Problems problems;
  const auto board = read_board(arguments.board, true, problems);
  const auto extension = std::filesystem::path(arguments.out).extension().string();
  if (extension != ".svg" && extension != ".pdf")
    problems.add("--out {}: expected a name that ends in .pdf or .svg", arguments.out);
  const auto sheet = problems.empty() ? lay_out(board) : Result<BoardSheet>();
  if (!sheet) problems.add("{}", sheet.error().message);
  if (!problems.empty()) return fail(problems.fault());
  if (auto done = write_text_file(arguments.out, extension == ".svg" ? svg_of(*sheet) : pdf_of(*sheet)); !done)
    return fail(done.error());
  fmt::print(
      "written: {}: {} on {}\nprint at 100 % (not fitted to the page), measure the line of {:.0f} mm, and glue "
      "it on something flat\n",
      arguments.out, description_of(board), sheet->paper, kRuler_mm);
  return 0;
}

}  // namespace

void add_calibrate_board(CLI::App& calibrate_command, Action& action) {
  auto* command = calibrate_command.add_subcommand("board", "A board to print for calibrate lens, to scale");
  auto arguments = std::make_shared<SheetRequest>();
  add_board_options(*command, arguments->board);
  command->add_option("--out", arguments->out, "The page (.pdf or .svg)")->required();
  command->callback([arguments, &action] { action = [arguments] { return write_sheet(*arguments); }; });
}

}  // namespace kasumi
