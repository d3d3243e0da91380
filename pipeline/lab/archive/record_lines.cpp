#include "pipeline/lab/archive/record_lines.hpp"

namespace kasumi {
namespace {

constexpr std::size_t kLongestRecord = 1 << 20;

}  // namespace

RecordLines::RecordLines(const std::filesystem::path& path)
    : file_(path, std::ios::binary), buffer_(kLongestRecord, '\0') {}

bool RecordLines::next() {
  begin_ = end_;
  file_.getline(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
  const auto count = static_cast<std::size_t>(file_.gcount());
  too_long_ = file_.fail() && count + 1 == buffer_.size();
  if (count == 0 || file_.fail()) return false;
  whole_ = !file_.eof();
  line_ = std::string_view(buffer_.data(), whole_ ? count - 1 : count);
  end_ = begin_ + count;
  return true;
}

void RecordLines::go_to(std::uint64_t begin) {
  if (begin == end_ && file_.good()) return;
  file_.clear();
  file_.seekg(static_cast<std::streamoff>(begin));
  end_ = begin;
}

}  // namespace kasumi
