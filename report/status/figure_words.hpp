// The words for what page and messages both tell.
#pragma once

#include "report/status/translated.hpp"

namespace kasumi::report {

struct FigureWords {
  Translated picture{"Picture", "Bild", "Image", "Immagine", "Imagen", "映像"};
  Translated seen{"What visitors see",           "Was Besucher sehen",
                  "Ce que voient les visiteurs", "Che cosa vedono i visitatori",
                  "Lo que ven los visitantes",   "来場者に見えているもの"};
  Translated wrong{"What is wrong, and what to do",  "Was fehlt, und was zu tun ist",
                   "Ce qui ne va pas, et que faire", "Che cosa non va, e che cosa fare",
                   "Qué falla y qué hacer",          "問題と対処"};
  Translated nothing_wrong{"Nothing is wrong.", "Es fehlt nichts.", "Tout va bien.",
                           "Va tutto bene.",    "Todo va bien.",    "問題はありません。"};
  Translated aod{"optical depth at 550 nm",  "optische Dicke bei 550 nm", "épaisseur optique à 550 nm",
                 "spessore ottico a 550 nm", "espesor óptico a 550 nm",   "光学的厚さ (550 nm)"};
  Translated turbidity{"Turbidity T", "Trübung T", "Turbidité T", "Torbidità T", "Turbiedad T", "混濁係数 T"};
  Translated visibility{"Visibility", "Sichtweite", "Visibilité", "Visibilità", "Visibilidad", "視程"};
  Translated scene{"Scene camera",           "Szenenkamera",        "Caméra de la scène",
                   "Telecamera della scena", "Cámara de la escena", "風景カメラ"};
  Translated sky{"Sky camera",           "Himmelskamera",    "Caméra du ciel",
                 "Telecamera del cielo", "Cámara del cielo", "空のカメラ"};
  Translated latency{"Camera to screen",           "Kamera bis Bildschirm",
                     "De la caméra à l’écran",     "Dalla telecamera allo schermo",
                     "De la cámara a la pantalla", "カメラから画面まで"};
  Translated temperature{"Temperature", "Temperatur", "Température", "Temperatura", "Temperatura", "温度"};
};

}  // namespace kasumi::report
