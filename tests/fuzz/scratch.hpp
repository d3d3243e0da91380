// A folder of this process for readers that need a file; in memory where the machine offers that.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <span>

#include <unistd.h>

namespace kasumi {

class Scratch {
 public:
  Scratch() {
    std::error_code error;
    const bool shm = std::filesystem::is_directory("/dev/shm", error);
    folder_ = (shm ? std::filesystem::path("/dev/shm") : std::filesystem::temp_directory_path()) /
              ("kasumi-fuzz-" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  ~Scratch() {
    std::error_code error;
    std::filesystem::remove_all(folder_, error);
  }

  const std::filesystem::path& folder() const { return folder_; }
  std::filesystem::path file(const std::string& name, std::span<const std::uint8_t> bytes) const {
    std::ofstream out(folder_ / name, std::ios::binary | std::ios::trunc);
    out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    return folder_ / name;
  }

 private:
  std::filesystem::path folder_;
};

// A reader must return a value or a readable message; anything else is a finding.
template <class Answer>
void expect_value_or_sentence(const Answer& answer) {
  if (!answer && answer.error().message.empty()) std::abort();
}

// A target's, which one_input.cpp calls for every input.
void try_input(std::span<const std::uint8_t> input);

}  // namespace kasumi

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
