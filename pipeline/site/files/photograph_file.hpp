// Photographs, from files and to files.
#pragma once

#include <filesystem>
#include <string>

#include "base/photograph.hpp"
#include "base/result.hpp"
#include "pipeline/site/files/taken_at.hpp"

namespace kasumi {

// A file, or a member of an archive (archive_members.hpp): PNG, JPEG; by the module of base/picture_files TIFF, PNM,
// EXR (where OpenCV was built with it), FITS (light, made sRGB); grey becomes R = G = B. Turned as EXIF says, an ICC
// profile's colours made sRGB: as a viewer shows it (base/picture_files/upright_picture.hpp), and as a calibration must
// refer to it. Errors: bad_input. A JPEG of which a part is missing is refused, unless `damage` is given, which
// receives what is wrong with it (empty: nothing). `taken` receives what the file says of time and place.
Result<Photograph> read_photograph(const std::filesystem::path& path, std::string* damage = nullptr,
                                   TakenAt* taken = nullptr);

// By the name's extension: PNG, TIFF (16 bits when the quantum is finer than 1/255, else 8), JPEG (8). PNG and
// TIFF say sRGB, PNG and JPEG when and where `origin` was taken. Written to a temporary file and renamed. Errors:
// bad_input (another extension), io.
Result<> write_photograph(const std::filesystem::path& path, const Photograph& photograph);

}  // namespace kasumi
