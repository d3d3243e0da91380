// Bundles from outside: what is not as it must be is refused before anything of it is written.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include <archive.h>
#include <archive_entry.h>

#include "base/c_ptr.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/kiosk/content/bundles.hpp"

namespace kasumi {
namespace {

using testing::AllOf;
using testing::HasSubstr;
namespace fs = std::filesystem;

// An entry of a tar as somebody else may write it.
struct Entry {
  std::string path, text;
  unsigned type = AE_IFREG;
  std::string link{};
  bool hard = false;
};

fs::path write_tar(const fs::path& file, const std::vector<Entry>& entries) {
  const CPtr<archive, archive_write_free> writer(archive_write_new());
  archive_write_set_format_gnutar(writer.get());
  archive_write_open_filename(writer.get(), file.c_str());
  for (const auto& each : entries) {
    const CPtr<archive_entry, archive_entry_free> entry(archive_entry_new());
    archive_entry_set_pathname(entry.get(), each.path.c_str());
    archive_entry_set_filetype(entry.get(), each.type);
    archive_entry_set_size(entry.get(), static_cast<la_int64_t>(each.text.size()));
    archive_entry_set_perm(entry.get(), 0644);
    if (each.hard) archive_entry_set_hardlink(entry.get(), each.link.c_str());
    if (!each.hard && !each.link.empty()) archive_entry_set_symlink(entry.get(), each.link.c_str());
    EXPECT_EQ(archive_write_header(writer.get(), entry.get()), ARCHIVE_OK) << archive_error_string(writer.get());
    archive_write_data(writer.get(), each.text.data(), each.text.size());
  }
  archive_write_close(writer.get());
  return file;
}

const std::vector<std::pair<std::string, std::string>> kFiles{
    {"kasumi.toml", "[site]\n"}, {"models/塔.glb", std::string(100'000, 'g')}, {"still.png", "png"}, {"empty", ""}};

// A good bundle of `kFiles`, for which somebody then does something else.
struct Packing : testing::Test {
  void SetUp() override {
    folder = content_folder("bundle");
    fs::create_directories(folder / "desk");
    manifest = write_files(folder / "desk", kFiles);
  }
  std::vector<Entry> entries() const {
    std::vector<Entry> all{{kManifestName, manifest_text(manifest)}};
    for (const auto& [path, text] : kFiles) all.push_back({path, text});
    return all;
  }
  std::string refusal(const std::vector<Entry>& entries) {
    const auto bundle = look_into(write_tar(folder / "bad.kasumi", entries));
    return bundle ? "accepted" : bundle.error().message;
  }
  fs::path folder;
  Manifest manifest;
};

TEST_F(Packing, WhatIsPackedIsUnpackedAsItWas) {
  const auto file = folder / "good.kasumi";
  ASSERT_TRUE(write_bundle(file, folder / "desk", manifest, "signature\n"));
  const auto bundle = must(look_into(file));
  EXPECT_EQ(bundle->manifest.files, manifest.files);
  EXPECT_EQ(bundle->manifest.name, "Spring");
  EXPECT_EQ(bundle->signature, "signature\n");
  EXPECT_TRUE(check_files(*bundle));
  fs::create_directories(folder / "out");
  const auto unpacked = unpack(*bundle, folder / "out");
  ASSERT_TRUE(unpacked) << unpacked.error().message;
  for (const auto& [path, text] : kFiles) EXPECT_EQ(read_text_file(folder / "out" / path), text) << path;
  EXPECT_TRUE(check_unpacked(folder / "out", manifest));
  ASSERT_TRUE(write_text_file(folder / "out/still.png", "pnG"));
  EXPECT_FALSE(check_unpacked(folder / "out", manifest));
}

TEST_F(Packing, TarItselfReadsIt) {
  ASSERT_TRUE(write_bundle(folder / "good.kasumi", folder / "desk", manifest, ""));
  fs::create_directories(folder / "tar");
  ASSERT_EQ(shell(fmt::format("tar -xf {0}/good.kasumi -C {0}/tar", folder.string())), 0);
  for (const auto& [path, text] : kFiles) EXPECT_EQ(read_text_file(folder / "tar" / path), text) << path;
  EXPECT_EQ(read_text_file(folder / "tar" / kManifestName), manifest_text(manifest));
}

TEST_F(Packing, TheBenchMakesGoodOnes) {
  EXPECT_EQ(refusal(entries()), "accepted") << "else the refusals below prove nothing";
}

TEST_F(Packing, NothingLeadsOutOfTheFolder) {
  for (const char* path : {"../evil", "/etc/evil", "a/../../evil", "a//b", "./a", "a/.", "..", "a/..", ".hidden/x",
                           "a\\..\\b", "a\nb", "x/x/x/x/x/x/x/x/x/x"}) {
    auto all = entries();
    all.push_back({path, "evil"});
    EXPECT_THAT(refusal(all), testing::Not("accepted")) << path;
    // And where its manifest names it.
    auto named = manifest;
    named.files.push_back({path, 4, sha256_of("evil")});
    all.front().text = manifest_text(named);
    EXPECT_THAT(refusal(all), testing::Not("accepted")) << path;
  }
  EXPECT_THAT(refusal({{"../evil", "x"}}), HasSubstr("leads out of its folder"));
}

TEST_F(Packing, NothingButFiles) {
  const std::vector<std::pair<Entry, std::string>> cases{
      {{"link", "", AE_IFLNK, "/etc/passwd"}, "a link"},
      {{"link", "", AE_IFREG, "kasumi.toml", true}, "a link"},
      {{"device", "", AE_IFCHR}, "a device"},
      {{"disk", "", AE_IFBLK}, "a device"},
      {{"pipe", "", AE_IFIFO}, "neither a file nor a folder"},
      {{"folder", "", AE_IFDIR}, "a folder by itself"},
  };
  for (const auto& [entry, words] : cases) {
    auto all = entries();
    all.push_back(entry);
    EXPECT_THAT(refusal(all), HasSubstr(words)) << entry.path;
  }
  auto all = entries();
  all[3] = {"still.png", "", AE_IFLNK, "/etc/passwd"};  // in the place of what the manifest names
  EXPECT_THAT(refusal(all), HasSubstr("a link"));
}

TEST_F(Packing, AllProblemsAtOnce) {
  auto all = entries();
  all.erase(all.begin() + 2);
  all.push_back({"../evil", "x"});
  all.push_back({"surplus", "x"});
  all.push_back({"kasumi.toml", "again"});
  all[2].text = "longer than it was";
  EXPECT_THAT(refusal(all),
              AllOf(HasSubstr("evil"), HasSubstr("surplus: not named"), HasSubstr("kasumi.toml: there twice"),
                    HasSubstr("塔.glb: named by the manifest, but not there"), HasSubstr("18 bytes, expected 3")));
}

TEST_F(Packing, ManyProblemsAreCounted) {
  auto all = entries();
  for (int i = 0; i < 900; ++i) all.push_back({fmt::format("../{}", i), ""});
  const auto refused = refusal(all);
  EXPECT_THAT(refused, HasSubstr("more"));
  EXPECT_LT(refused.size(), 8000u);
}

TEST_F(Packing, TooManyFilesAreNotCountedToTheEnd) {
  std::vector<Entry> all;
  for (std::size_t i = 0; i < 3 * kMostFiles; ++i) all.push_back({fmt::format("f{}", i), ""});
  EXPECT_THAT(refusal(all), HasSubstr("more than 1000 files"));
}

// A header may say anything.
TEST_F(Packing, SizesAreBoundedBeforeAnythingIsRead) {
  const auto file = write_tar(folder / "huge.kasumi", entries());
  auto bytes = read_text_file(file).value();
  const auto at = bytes.find("still.png", 512);
  ASSERT_NE(at, std::string::npos);
  const auto header = bytes.rfind(std::string("still.png", 10));
  ASSERT_EQ(header % 512, 0u);
  bytes.replace(header + 124, 12, "77777777777\0", 12);  // 8 GB
  unsigned sum = 0;
  for (std::size_t i = 0; i < 512; ++i)
    sum += i >= 148 && i < 156 ? ' ' : static_cast<unsigned char>(bytes[header + i]);
  bytes.replace(header + 148, 8, fmt::format("{:06o}", sum) + std::string("\0 ", 2));
  ASSERT_TRUE(write_text_file(file, bytes));
  EXPECT_THAT(look_into(file), FailsWith(HasSubstr("8589934591 bytes, expected at most")));
}

TEST_F(Packing, WhatIsCutShortOrNoTarIsRefused) {
  const auto file = folder / "cut.kasumi";
  const auto whole = read_text_file(write_tar(file, entries())).value();
  int refused = 0;
  for (std::size_t length = 0; length + 1024 < whole.size(); length += 997) {
    ASSERT_TRUE(write_text_file(file, whole.substr(0, length)));
    const auto bundle = look_into(file);
    if (bundle && check_files(*bundle)) continue;  // zeros at the end are no part of it
    ++refused;
  }
  EXPECT_GT(refused, 95);
  ASSERT_TRUE(write_text_file(file, "not a tar"));
  EXPECT_FALSE(look_into(file));
  EXPECT_FALSE(look_into(folder));
  EXPECT_FALSE(look_into("/dev/zero"));
  EXPECT_FALSE(look_into(folder / "none"));
}

TEST_F(Packing, AChangedFileIsFoundByItsHash) {
  auto all = entries();
  all[3].text = "pnG";
  const auto bundle = look_into(write_tar(folder / "changed.kasumi", all));
  ASSERT_TRUE(bundle) << "as long as it was";
  EXPECT_THAT(check_files(*bundle), FailsWith(HasSubstr("still.png: is not what the manifest names")));
}

// A stick that answers differently the second time.
TEST_F(Packing, WhatChangesBetweenLookingAndUnpackingIsRefused) {
  const auto bundle = must(look_into(write_tar(folder / "turn.kasumi", entries())));
  auto other = entries();
  other[3] = {"still.png", "", AE_IFLNK, "/etc/passwd"};
  other.push_back({"../evil", "x"});
  const auto now = read_text_file(write_tar(folder / "other.kasumi", other)).value();
  {
    std::FILE* file = std::fopen((folder / "turn.kasumi").c_str(), "r+b");  // the same file, as it is open
    std::fwrite(now.data(), 1, now.size(), file);
    std::fclose(file);
  }
  fs::create_directories(folder / "out");
  EXPECT_THAT(unpack(*bundle, folder / "out"), FailsWith(HasSubstr("still.png: is not there any more")));
  EXPECT_FALSE(fs::exists(folder / "evil"));
  EXPECT_FALSE(fs::is_symlink(folder / "out/still.png"));
}

TEST_F(Packing, AFileThatChangesWhilePackedIsRefusedAndNothingIsLeft) {
  ASSERT_TRUE(write_text_file(folder / "desk/still.png", "other"));
  EXPECT_THAT(write_bundle(folder / "out.kasumi", folder / "desk", manifest, ""),
              FailsWith(HasSubstr("has changed while it was packed")));
  EXPECT_FALSE(fs::exists(folder / "out.kasumi"));
}

TEST(ManifestText, EveryProblemIsNamed) {
  const auto why = [](const std::string& text) {
    const auto manifest = parse_manifest(text);
    return manifest ? "read" : manifest.error().message;
  };
  EXPECT_THAT(why("{"), HasSubstr("not the manifest"));
  EXPECT_THAT(why(R"({"format": "kasumi-content", "version": 2})"), HasSubstr("expected 1"));
  const std::string head = R"({"format": "kasumi-content", "version": 1, "name": "a\nb", "created_utc": "today",
      "configuration": "missing.toml", "files": [)";
  EXPECT_THAT(why(head + R"({"path": "a", "bytes": -1, "sha256": "x"}, {"path": "a/b", "bytes": 1, "sha256": "x"},
      {"path": "../c"}, 7, {"path": "a", "bytes": 1}]})"),
              AllOf(HasSubstr("name:"), HasSubstr("created_utc"), HasSubstr("a: expected its \"bytes\""),
                    HasSubstr("a/b: expected its \"sha256\""), HasSubstr("leads out"), HasSubstr("without a name"),
                    HasSubstr("named twice"), HasSubstr("a folder of another"), HasSubstr("missing.toml")));
  EXPECT_THAT(why(head + "]}"), HasSubstr("1 to 1000"));
  EXPECT_THAT(why(std::string(100'000, '[')), HasSubstr("not the manifest"));
}

}  // namespace
}  // namespace kasumi
