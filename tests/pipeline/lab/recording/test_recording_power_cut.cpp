// A recording through a power cut at any moment, with whatever was not written through lost (row 22 of the faults).
#include <algorithm>

#include <gtest/gtest.h>

#include <algorithm>

#include "pipeline/lab/recording/recording.hpp"
#include "pipeline/site/config/fixture_file.hpp"
#include "tests/base/power_cut.hpp"
#include "tests/pipeline/kiosk/operating/kiosk.hpp"

namespace kasumi {
namespace {

struct Kept {
  std::size_t calls;  // when keep() had returned
  Frame frame;
};

// How many rows are whole; each must name a payload that is, too.
std::size_t rows_in(const std::filesystem::path& camera, const std::vector<Kept>& kept) {
  const auto rows = read_index(camera);
  if (!rows) return 0;
  for (std::size_t i = 0; i < rows->size(); ++i) {
    const auto bytes = read_file(camera / (*rows)[i].payload);
    EXPECT_TRUE(bytes && std::ranges::equal(*bytes, kept[i].frame.payload.bytes)) << "row " << i;
  }
  return rows->size();
}

TEST(PowerCut, Row22TakesNoFrameThatHasBeenRecorded) {
  const auto folder = operating_folder("power-cut");
  const auto config = write_kiosk(folder);
  const auto home = operating_folder("power-cut-disk");
  PowerCut power(home);
  auto recording = Recording::create(config, home / "recordings" / "kept", Utc{}, {.keep_free = 0});
  ASSERT_TRUE(recording) << recording.error().message;
  const auto created = power.calls();
  std::vector<Kept> kept;
  for (int number = 0; number < 4; ++number) {
    const auto frame = kiosk_frame(number, static_cast<std::uint8_t>(90 + 30 * number));
    ASSERT_TRUE((*recording)->keep(CameraRole::scene, frame));
    kept.push_back({power.calls(), frame});
  }
  const auto found = operating_folder("power-cut-found");
  for (const auto left : PowerCut::kAll)
    for (std::size_t calls = created; calls <= power.calls(); ++calls) {
      SCOPED_TRACE(fmt::format("cut after {} of {} calls, left over {}", calls, power.calls(), static_cast<int>(left)));
      power.lay_out(calls, left, found);
      const auto fixture = read_fixture(found / "recordings" / "kept");
      ASSERT_TRUE(fixture) << fixture.error().message;
      ASSERT_TRUE(read_index(found / "recordings" / "kept" / "sky"));
      const auto whole =
          static_cast<std::size_t>(std::ranges::count_if(kept, [&](const Kept& one) { return one.calls <= calls; }));
      ASSERT_GE(rows_in(found / "recordings" / "kept" / "scene", kept), whole);
    }
  EXPECT_GE(power.calls() - created, 4 * 6u) << "a payload and a row, each written and written through";
}

}  // namespace
}  // namespace kasumi
