// Where a test finds what it needs. Known to one generated file only: all else compiles to the same in every
// checkout, so that a compiler cache serves them all.
#pragma once

#include <filesystem>

namespace kasumi {

std::filesystem::path source_folder();
std::filesystem::path shared_data_folder();  // real input beside the checkout: tests that want it skip where it is not
std::filesystem::path test_output_folder();  // the only place where tests write; of this program and shard alone
std::filesystem::path kasumi_program();
std::filesystem::path made_once_folder();  // tests/made_once.hpp; of the generator that these programs are built with

}  // namespace kasumi
