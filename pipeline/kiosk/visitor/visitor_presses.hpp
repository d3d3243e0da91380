// How often visitors pressed what, by the hour and no closer: kept for 13 months, so that a year can be compared.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>

#include "base/clock.hpp"
#include "base/result.hpp"
#include "pipeline/site/visitor/hand_event.hpp"

namespace kasumi {

constexpr const char* kPressesFile = "visitor.csv";                         // in the state's folder
using PressesByHour = std::map<Utc, std::array<std::uint64_t, kHandKeys>>;  // by the hour's beginning

// Of the file's text; lines that are none are left out.
PressesByHour read_presses(std::string_view text);
std::string presses_text(const PressesByHour& presses);

// Adds them to the file and leaves out what is older than 13 months. A file that cannot be read, or lies in the future,
// begins anew. BLOCKS for as long as the disk takes. Errors: io.
Result<> add_presses(const std::filesystem::path& file, const PressesByHour& fresh, Utc now);

}  // namespace kasumi
