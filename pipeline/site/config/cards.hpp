// [[cards]]: known reflectances in the scene camera's view.
#pragma once

#include <vector>

#include "base/table/config_table.hpp"
#include "estimator/light/card_light.hpp"

namespace kasumi {

// `width`, `height`: of the scene camera's pictures. Problems are recorded in the table.
std::vector<LightCard> read_cards(const ConfigTable& root, int width, int height);

}  // namespace kasumi
