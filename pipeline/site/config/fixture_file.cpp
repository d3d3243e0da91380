#include "pipeline/site/config/fixture_file.hpp"

namespace kasumi {

Result<Fixture> read_fixture(const std::filesystem::path& folder) {
  std::error_code error;
  if (!std::filesystem::is_directory(folder, error))
    return fail(FaultKind::bad_input, "{}: expected a fixture, a folder with fixture.toml, sky/ and scene/",
                folder.string());
  const auto root = ConfigTable::read_file(folder / "fixture.toml");
  if (!root) return fail(root.error());
  Fixture fixture{folder, read_fixture_info(*root), read_installation(*root)};
  if (auto whole = root->finish(); !whole) return fail(whole.error());
  return fixture;
}

Result<PicturesRead> for_each_picture(const Fixture& fixture, const Camera& camera, FrameSelection options,
                                      const std::function<void(const PictureView&, const FrameMetadata&)>& use) {
  options.yuv_encoding = camera.yuv_encoding;
  options.width = camera.width;
  options.height = camera.height;
  return for_each_picture(fixture.folder / camera.name, options, use);
}

}  // namespace kasumi
