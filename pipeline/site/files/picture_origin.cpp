#include "pipeline/site/files/picture_origin.hpp"

#include <cstdlib>
#include <cstring>
#include <memory>

#include <libexif/exif-data.h>

#include "base/c_ptr.hpp"

namespace kasumi {
namespace {

using OriginPtr = CPtr<ExifData, exif_data_unref>;
constexpr ExifTag kTimes[] = {EXIF_TAG_DATE_TIME_ORIGINAL,    EXIF_TAG_DATE_TIME_DIGITIZED,
                              EXIF_TAG_OFFSET_TIME_ORIGINAL,  EXIF_TAG_OFFSET_TIME_DIGITIZED,
                              EXIF_TAG_SUB_SEC_TIME_ORIGINAL, EXIF_TAG_SUB_SEC_TIME_DIGITIZED};

void add_entry(ExifContent* to, ExifEntry* entry) {
  exif_content_add_entry(to, entry);
  exif_entry_unref(entry);  // the content holds it
}

// A copy made by the memory of the data that will own it.
void add_copy(ExifData& data, ExifIfd directory, const ExifEntry& entry) {
  auto* memory = exif_mem_new_default();
  ExifEntry* copy = exif_entry_new_mem(memory);
  copy->data = static_cast<unsigned char*>(exif_mem_alloc(memory, entry.size));
  exif_mem_unref(memory);
  if (!copy->data) return exif_entry_unref(copy);
  std::memcpy(copy->data, entry.data, entry.size);
  copy->size = entry.size;
  copy->tag = entry.tag;
  copy->components = entry.components;
  copy->format = entry.format;
  add_entry(data.ifd[directory], copy);
}

struct Copying {
  ExifData* to;
  int count;
};

void add_place(ExifEntry* entry, void* copying) {
  auto& into = *static_cast<Copying*>(copying);
  add_copy(*into.to, EXIF_IFD_GPS, *entry);
  ++into.count;
}

}  // namespace

std::vector<std::uint8_t> time_and_place(std::span<const std::uint8_t> exif, bool always) {
  const OriginPtr made(exif_data_new());
  if (!made) return {};
  Copying copying{made.get(), 0};
  if (!exif.empty()) {
    std::vector<std::uint8_t> headed{'E', 'x', 'i', 'f', 0, 0};
    headed.insert(headed.end(), exif.begin(), exif.end());
    const OriginPtr source(exif_data_new());
    if (!source) return {};
    exif_data_unset_option(source.get(), EXIF_DATA_OPTION_FOLLOW_SPECIFICATION);
    exif_data_load_data(source.get(), headed.data(), static_cast<unsigned int>(headed.size()));
    exif_data_set_byte_order(made.get(), exif_data_get_byte_order(source.get()));
    for (const auto tag : kTimes)
      if (const auto* entry = exif_content_get_entry(source->ifd[EXIF_IFD_EXIF], tag)) {
        add_copy(*made, EXIF_IFD_EXIF, *entry);
        ++copying.count;
      }
    exif_content_foreach_entry(source->ifd[EXIF_IFD_GPS], add_place, &copying);
  }
  if (copying.count == 0 && !always) return {};
  ExifEntry* space = exif_entry_new();
  exif_content_add_entry(made->ifd[EXIF_IFD_EXIF], space);
  exif_entry_initialize(space, EXIF_TAG_COLOR_SPACE);
  exif_set_short(space->data, exif_data_get_byte_order(made.get()), 1);  // sRGB
  exif_entry_unref(space);
  exif_data_set_byte_order(made.get(), EXIF_BYTE_ORDER_INTEL);
  unsigned char* bytes = nullptr;
  unsigned int size = 0;
  exif_data_save_data(made.get(), &bytes, &size);
  const std::unique_ptr<unsigned char, decltype(&std::free)> held(bytes, &std::free);
  if (!bytes || size <= 6) return {};
  return {bytes + 6, bytes + size};
}

}  // namespace kasumi
