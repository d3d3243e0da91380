#include <archive.h>
#include <archive_entry.h>

#include "base/c_ptr.hpp"
#include "base/files.hpp"
#include "pipeline/kiosk/content/bundle.hpp"
#include "pipeline/kiosk/content/digest.hpp"

namespace kasumi {

namespace {

using NewArchive = CPtr<archive, archive_write_free>;
using NewEntry = CPtr<archive_entry, archive_entry_free>;

Result<> add_file(archive* writer, const std::string& path, std::string_view bytes, Utc at) {
  const NewEntry entry(archive_entry_new());
  archive_entry_set_pathname(entry.get(), path.c_str());
  archive_entry_set_size(entry.get(), static_cast<la_int64_t>(bytes.size()));
  archive_entry_set_filetype(entry.get(), AE_IFREG);
  archive_entry_set_perm(entry.get(), 0644);
  archive_entry_set_mtime(entry.get(), std::chrono::floor<std::chrono::seconds>(at).time_since_epoch().count(), 0);
  if (archive_write_header(writer, entry.get()) != ARCHIVE_OK ||
      archive_write_data(writer, bytes.data(), bytes.size()) != static_cast<la_ssize_t>(bytes.size()))
    return fail(FaultKind::io, "{}: cannot be packed: {}", path, archive_error_string(writer));
  return {};
}

Result<> add_packed(archive* writer, const std::filesystem::path& from, const PackedFile& file, Utc at) {
  const auto bytes = read_text_file(from);
  if (!bytes) return fail(bytes.error());
  if (sha256_of(*bytes) != file.sha256)
    return fail(FaultKind::bad_input, "{}: has changed while it was packed", from.string());
  return add_file(writer, file.path, *bytes, at);
}

}  // namespace

// GNU's tar: names are bytes, independent of the locale.
Result<> write_bundle(const std::filesystem::path& path, const std::filesystem::path& folder, const Manifest& manifest,
                      std::string_view signature, const std::map<std::string, std::filesystem::path>& instead) {
  return replace_file(path, [&](const std::filesystem::path& unfinished) -> Result<> {
    const NewArchive writer(archive_write_new());
    if (!writer || archive_write_set_format_gnutar(writer.get()) != ARCHIVE_OK ||
        archive_write_open_filename(writer.get(), unfinished.c_str()) != ARCHIVE_OK)
      return fail(FaultKind::io, "{}: cannot be written: {}", path.string(),
                  writer ? archive_error_string(writer.get()) : "not enough memory");
    auto added = add_file(writer.get(), kManifestName, manifest_text(manifest), manifest.created);
    if (added && !signature.empty()) added = add_file(writer.get(), kSignatureName, signature, manifest.created);
    for (const auto& file : manifest.files) {
      const auto other = instead.find(file.path);
      const auto from = other == instead.end() ? folder / file.path : other->second;
      if (added) added = add_packed(writer.get(), from, file, manifest.created);
    }
    if (!added) return added;
    if (archive_write_close(writer.get()) != ARCHIVE_OK)
      return fail(FaultKind::io, "{}: cannot be written: {}", path.string(), archive_error_string(writer.get()));
    return {};
  });
}

}  // namespace kasumi
