// What a place of the building has to tell, beside the building: never over it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "gles/picture/flat_picture.hpp"

namespace kasumi {

// For whom it is laid out.
struct PanelReader {
  // Whose hand comes from the left: the panel is on the right, where that hand does not cover it. Else on the left.
  bool left_handed = false;
  bool seated = false;       // in the lower third of the screen
  bool large_print = false;  // letters of a degree at least, half as large again as usual, and never smaller to fit
  double pixels_per_degree = 24.0;  // of the screen, from where it is read: 43 inches of 1920 x 1080 at 70 cm
  friend bool operator==(const PanelReader&, const PanelReader&) = default;
};

struct PanelRequest {
  std::string title, text;                           // UTF-8
  std::string language{};                            // ISO 639: also whether lines begin on the right
  std::optional<std::filesystem::path> font_file{};  // as CaptionStyle's
  int width = 1280, height = 720;                    // of the screen, pixels
  std::optional<FlatPlace> building{};               // what must stay free, on the screen
  double foot = 0.0;                                 // of the screen, that others take: pixels
  PanelReader reader{};
};

struct StoryPanel {
  Image<Rgba8> picture;
  FlatPlace place;                  // on the screen, whole pixels, beside the building
  std::size_t left_out = 0;         // lines that were one too many; the last one shown ends with dots
  std::vector<std::string> faults;  // for people: words that no font can show, lines that are left out
};

constexpr double kPanelContrast = 7.0;  // at least, of letters to what is behind, before any picture (WCAG 2.2, 1.4.6)
constexpr int kMostPanelLines = 8;      // of the text
constexpr std::size_t kMostPanelBytes = 10'000;  // bounds the time to lay it out

// On the side of the building that the reader's hand leaves free, else on the other, below or above it: the first of them
// that holds all of the text. Where none does, letters get smaller by up to a third; then lines are left out.
// Errors: bad_input (not UTF-8, too long, no such screen), unsupported (no font; no room beside the building).
Result<StoryPanel> draw_story_panel(const PanelRequest& request);

}  // namespace kasumi
