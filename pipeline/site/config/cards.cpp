#include "pipeline/site/config/cards.hpp"

#include <fmt/format.h>

#include "base/units.hpp"

namespace kasumi {

std::vector<LightCard> read_cards(const ConfigTable& root, int width, int height) {
  constexpr Range kReflectances{0.02, 1.0};
  std::vector<LightCard> cards;
  for (const auto& table : root.tables("cards")) {
    LightCard card;
    card.name = table.text("name", fmt::format("card {}", cards.size() + 1));
    const auto box = table.numbers("region_px", 4, {0.0, 100e3});
    if (box.size() == 4 && table.has("region_px")) {
      card.x = static_cast<int>(box[0]);
      card.y = static_cast<int>(box[1]);
      card.width = static_cast<int>(box[2]);
      card.height = static_cast<int>(box[3]);
      if (card.width < 1 || card.height < 1 || card.x + card.width > width || card.y + card.height > height)
        table.problem("region_px",
                      fmt::format("[x, y, width, height] within the scene camera's {} x {} pixels", width, height));
    }
    if (table.if_text("reflectance") == "grey") {
      card.grey = true;
      card.reflectance = glm::dvec3{kGreyReflectance};
      table.text("reflectance");
    } else if (table.if_number("reflectance")) {
      card.reflectance = glm::dvec3{table.number("reflectance", kReflectances)};
    } else if (!table.has("reflectance")) {
      table.problem("reflectance", "a number from 0.02 to 1, three of them, or \"grey\"");
    } else if (const auto channels = table.numbers("reflectance", 3, kReflectances); channels.size() == 3) {
      card.reflectance = {channels[0], channels[1], channels[2]};
    }
    const double up_deg = table.number("faces_up_deg", {-90.0, 90.0}, 0.0);
    const bool level = up_deg == 90.0 || up_deg == -90.0;  // faces no azimuth
    const double azimuth_deg =
        level ? table.number("faces_deg", {-360.0, 360.0}, 0.0) : table.number("faces_deg", {-360.0, 360.0});
    card.normal = direction_from(from_degrees(90.0 - up_deg), from_degrees(azimuth_deg));
    cards.push_back(card);
  }
  return cards;
}

}  // namespace kasumi
