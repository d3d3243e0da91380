// Files of named tensors, as Mitsuba 3 keeps the published data of sky models in (docs/sky.md gives the layout).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "base/result.hpp"

namespace kasumi {

class TensorFile {
 public:
  // Errors: bad_input (no such file, not of this layout, a field that does not lie in the file).
  static Result<TensorFile> read(const std::filesystem::path& file);

  // All numbers of one field of 64-bit numbers, the last index running fastest. Errors: bad_input (no such field, other
  // type or shape, a number that is not finite).
  Result<std::vector<double>> doubles(const std::string& name, const std::vector<std::size_t>& shape) const;

 private:
  struct Field {
    std::string name;
    unsigned type = 0;
    std::vector<std::size_t> shape;
    std::size_t offset = 0;
  };
  class Header;

  std::filesystem::path file_;
  std::vector<std::uint8_t> bytes_;
  std::vector<Field> fields_;
};

}  // namespace kasumi
