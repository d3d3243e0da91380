// The words of the state page.
#pragma once

#include "report/status/figure_words.hpp"

namespace kasumi::report {

struct PageWords : FigureWords {
  Translated state{"State", "Zustand", "État", "Stato", "Estado", "状態"};
  Translated day{"The last 24 hours", "Die letzten 24 Stunden", "Les dernières 24 heures",
                 "Le ultime 24 ore",  "Las últimas 24 horas",   "過去24時間"};
  Translated no_history{"No history is kept.",          "Es wird kein Verlauf geführt.", "Aucun historique n’est tenu.",
                        "Non si tiene una cronologia.", "No se guarda historial.",       "履歴は保存されていません。"};
  Translated plot{
      "What visitors saw, turbidity T and aerosol optical depth over the last 24 hours; the table says the same",
      "Was Besucher sahen, Trübung T und optische Dicke des Aerosols in 24 Stunden; die Tabelle sagt dasselbe",
      "Ce que les visiteurs ont vu, turbidité T et épaisseur optique des aérosols sur 24 heures\u202F; le tableau dit "
      "la même chose",
      "Che cosa hanno visto i visitatori, torbidità T e spessore ottico dell’aerosol in 24 ore; la tabella dice lo "
      "stesso",
      "Lo que vieron los visitantes, turbiedad T y espesor óptico del aerosol en 24 horas; la tabla dice lo mismo",
      "過去24時間に来場者が見たもの、混濁係数Tとエアロゾル光学的厚さ。表の内容と同じです"};
  Translated strip{"visitors saw",          "Besucher sahen",  "les visiteurs ont vu", "i visitatori hanno visto",
                   "los visitantes vieron", "来場者が見たもの"};
  Translated no_figures{"no figures", "keine Werte", "pas de valeurs", "nessun valore", "sin valores", "値なし"};
  Translated from{"from", "von", "de", "dalle", "desde", "開始"}, to{"to", "bis", "à", "alle", "hasta", "終了"};
  Translated figures{"Figures", "Werte", "Valeurs", "Valori", "Valores", "測定値"};
  Translated works{"works", "arbeitet", "fonctionne", "funziona", "funciona", "正常"};
  Translated fails{"sends no picture",   "liefert kein Bild", "n’envoie pas d’image",
                   "non invia immagini", "no envía imagen",   "映像なし"};
  Translated content{"Content", "Inhalt", "Contenu", "Contenuto", "Contenido", "内容"};
  Translated as_configured{"as configured",    "wie eingestellt",      "comme configuré",
                           "come configurato", "según lo configurado", "設定どおり"};
  Translated earlier{"what worked last",     "was zuletzt ging",       "le dernier qui fonctionnait",
                     "l’ultimo funzionante", "el último que funcionó", "最後に動いた内容"};
  Translated brought{"Content brought last",     "Zuletzt gebrachter Inhalt", "Dernier contenu apporté",
                     "Ultimo contenuto portato", "Último contenido traído",   "最後に届いた内容"};
  Translated server{"Content’s server",     "Server des Inhalts",     "Serveur du contenu",
                    "Server del contenuto", "Servidor del contenido", "内容の配信元"};
  Translated not_asked{"not asked yet",           "noch nicht gefragt", "pas encore interrogé",
                       "non ancora interpellato", "aún sin consultar",  "未確認"};
  Translated answered{"asked", "gefragt", "interrogé", "interpellato", "consultado", "確認"};
  Translated arriving{"is arriving", "kommt an", "arrive", "in arrivo", "está llegando", "受信中"};
  Translated running{"Running since",   "Läuft seit",      "En marche depuis",
                     "In funzione dal", "En marcha desde", "起動時刻"};
  Translated off{"not running", "nicht in Betrieb", "à l’arrêt", "non in funzione", "parado", "停止"};
  Translated refresh{"Look again", "Neu ansehen", "Actualiser", "Aggiorna", "Actualizar", "更新"};
  Translated language{"Language", "Sprache", "Langue", "Lingua", "Idioma", "言語"};
  Translated as_of{"As of", "Stand", "Au", "Al", "A las", "時点"};
};

}  // namespace kasumi::report
