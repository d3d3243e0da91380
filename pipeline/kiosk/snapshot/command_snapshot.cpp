#include <algorithm>
#include <cstdio>
#include <memory>

#include <CLI/CLI.hpp>
#include <opencv2/imgproc.hpp>

#include "base/files.hpp"
#include "base/picture_files/picture_file.hpp"
#include "base/socket/local_socket.hpp"
#include "pipeline/command.hpp"
#include "pipeline/kiosk/snapshot/blurred_picture.hpp"
#include "pipeline/kiosk/snapshot/snapshot.hpp"

namespace kasumi {
namespace {

using namespace std::chrono_literals;

constexpr Duration kAnswerDeadline = 15s;  // a sharp picture waits until visitors have had a notice
constexpr Duration kPictureDeadline = 10s;
constexpr std::size_t kLongestHeader = 16384;
constexpr int kEnlargedPixels = 640;  // along the longer side: what a person looks at

struct SnapshotArguments {
  std::string out = "snapshot.png", folder = "/run/kasumi";
  bool sharp = false;
};

Result<Snapshot> ask(const SnapshotArguments& arguments) {
  const auto path = std::filesystem::path(arguments.folder) / kSnapshotSocket;
  const auto socket = connect_to(path);
  if (!socket && socket.error().kind == FaultKind::disconnected)
    return fail(FaultKind::disconnected,
                "no appliance runs here ({}): expected one that was started, as by `systemctl start kasumi`",
                socket.error().message);
  if (!socket && socket.error().kind == FaultKind::timeout)
    return fail(FaultKind::timeout, "{}: others are asking already: try again", path.string());
  if (!socket)
    return fail(socket.error().kind, "{}: only the kiosk's own account and root may ask for a snapshot (sudo)",
                socket.error().message);
  const auto kind = arguments.sharp ? SnapshotKind::sharp : SnapshotKind::blurred;
  const auto in_words = [&](const Fault& fault) {
    return fail(fault.kind, "{}: the appliance gave no snapshot: {}", path.string(), fault.message);
  };
  if (auto sent = write_within(*socket, snapshot_request_line(kind), kPictureDeadline); !sent)
    return in_words(sent.error());
  const auto line = read_line_within(*socket, kLongestHeader, kAnswerDeadline);
  if (!line) return in_words(line.error());
  auto header = parse_snapshot_header(*line);
  if (!header) return in_words({FaultKind::io, header.error().message});
  const auto bytes = read_bytes_within(*socket, header->picture_bytes, kPictureDeadline);
  if (!bytes) return in_words(bytes.error());
  auto at = bytes->begin();
  for (Rgb8& pixel : header->snapshot.picture.elements())
    for (const int c : {0, 1, 2}) pixel[c] = static_cast<std::uint8_t>(*at++);
  return std::move(header->snapshot);
}

// A blurred picture is enlarged softly, since its own few pixels would be a stamp.
Result<std::vector<std::uint8_t>> snapshot_png(const Snapshot& snapshot) {
  const auto& picture = snapshot.picture;
  if (snapshot.kind != SnapshotKind::blurred) return encode_png(picture);
  const double scale = static_cast<double>(kEnlargedPixels) / std::max(picture.width(), picture.height());
  const cv::Mat small(picture.height(), picture.width(), CV_8UC3, const_cast<Rgb8*>(picture.elements().data()));
  Image<Rgb8> enlarged(cv::saturate_cast<int>(picture.width() * scale),
                       cv::saturate_cast<int>(picture.height() * scale));
  cv::Mat large(enlarged.height(), enlarged.width(), CV_8UC3, enlarged.elements().data());
  cv::resize(small, large, large.size(), 0.0, 0.0, cv::INTER_CUBIC);
  return encode_png(enlarged);
}

Result<int> take_snapshot(const SnapshotArguments& arguments) {
  const auto snapshot = ask(arguments);
  if (!snapshot) return fail(snapshot.error());
  if (snapshot->refused)
    return fail(
        FaultKind::bad_input,
        "--sharp: this kiosk sends no sharp pictures: expected sharp = true under [snapshot] in its kasumi.toml");
  const bool to_pipe = arguments.out == "-";
  fmt::print(to_pipe ? stderr : stdout, "{}", snapshot_text(*snapshot));
  if (snapshot->picture.empty())
    return fail(FaultKind::io, "nothing is on the glass: {}",
                snapshot->reason.empty() ? snapshot->shown : snapshot->reason);
  const auto png = snapshot_png(*snapshot);
  if (!png) return fail(png.error());
  if (to_pipe) {
    if (std::fwrite(png->data(), 1, png->size(), stdout) != png->size() || std::fflush(stdout) != 0)
      return fail(FaultKind::io, "standard output: cannot be written");
    return 0;
  }
  if (auto written = write_file(arguments.out, *png); !written) return fail(written.error());
  fmt::print("written: {}{}\n", arguments.out,
             snapshot->kind == SnapshotKind::sharp
                 ? ", sharp: it may show people"
                 : fmt::format(", blurred to {} x {} pixels", snapshot->picture.width(), snapshot->picture.height()));
  return 0;
}

}  // namespace

void add_snapshot_command(CLI::App& app, Action& action) {
  auto* command =
      app.add_subcommand("snapshot", "What the running kiosk shows now, blurred so that no person can be recognised");
  auto arguments = std::make_shared<SnapshotArguments>();
  command->add_option("--out", arguments->out, "PNG to write; - is standard output")->capture_default_str();
  command->add_flag("--sharp", arguments->sharp,
                    "As sharp as on the glass, which says so to visitors first; needs [snapshot] sharp = true");
  command->add_option("--folder", arguments->folder, "The running appliance's folder, which holds snapshot.sock")
      ->capture_default_str();
  command->callback([arguments, &action] { action = [arguments] { return take_snapshot(*arguments); }; });
}

}  // namespace kasumi
