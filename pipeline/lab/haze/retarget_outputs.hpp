// Where `kasumi retarget` writes its pictures.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "pipeline/lab/haze/retarget_task.hpp"
#include "pipeline/site/files/contact_sheet.hpp"
#include "pipeline/site/files/picture_sink.hpp"
#include "pipeline/site/files/picture_source.hpp"

namespace kasumi {

// A picture or a folder, a contact sheet, films: one film of all results for stills, one per target for sequences.
class RetargetOutputs {
 public:
  // `targets`: their names. Errors: bad_input (a folder that cannot be made, a sheet of a sequence, which would have to stay in memory).
  static Result<RetargetOutputs> open(const RetargetRequest& arguments, const std::vector<std::string>& targets,
                                      const PictureSource& source);

  void as_taken(const Photograph& photograph);
  // `stem`: of the source picture; `target`: index of the target air.
  Result<> put(const std::string& stem, std::size_t target, const UnderOtherAir& made);
  Result<> finish();

 private:
  std::filesystem::path path_of(const std::string& stem, std::size_t target) const;

  std::filesystem::path out_, sheet_file_;
  std::vector<std::string> targets_;
  bool single_ = false;               // --out is a picture's name
  bool prints_ = false;               // a line for each picture
  std::vector<std::uint8_t> origin_;  // of the picture at hand
  ContactSheet sheet_;
  std::vector<std::unique_ptr<PictureSink>> films_;
};

}  // namespace kasumi
