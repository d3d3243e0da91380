// tar and zip files for tests.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <archive.h>
#include <archive_entry.h>
#include <gtest/gtest.h>

#include "base/c_ptr.hpp"

namespace kasumi {

using MadeArchivePtr = CPtr<archive, archive_write_free>;

// By the name's ending: .zip, .tar, .tar.gz.
inline MadeArchivePtr begin_archive(const std::filesystem::path& path) {
  MadeArchivePtr made(archive_write_new());
  const auto ending = path.extension();
  EXPECT_EQ(ending == ".zip" ? archive_write_set_format_zip(made.get()) : archive_write_set_format_gnutar(made.get()),
            0);
  if (ending == ".gz") {
    EXPECT_EQ(archive_write_add_filter_gzip(made.get()), 0);
  }
  EXPECT_EQ(archive_write_open_filename(made.get(), path.c_str()), 0);
  return made;
}

inline void begin_member(archive* to, const std::string& name, std::size_t size) {
  const CPtr<archive_entry, archive_entry_free> entry(archive_entry_new());
  archive_entry_set_pathname(entry.get(), name.c_str());
  archive_entry_set_filetype(entry.get(), AE_IFREG);
  archive_entry_set_perm(entry.get(), 0644);
  archive_entry_set_size(entry.get(), static_cast<la_int64_t>(size));
  EXPECT_GE(archive_write_header(to, entry.get()), ARCHIVE_WARN) << archive_error_string(to);
}

inline void pack(const std::filesystem::path& path, const std::vector<std::pair<std::string, std::string>>& members) {
  const auto made = begin_archive(path);
  for (const auto& [name, bytes] : members) {
    begin_member(made.get(), name, bytes.size());
    EXPECT_EQ(archive_write_data(made.get(), bytes.data(), bytes.size()), static_cast<la_ssize_t>(bytes.size()));
  }
  EXPECT_EQ(archive_write_close(made.get()), 0);
}

}  // namespace kasumi
