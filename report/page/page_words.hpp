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
  Translated screen{"The screen now",    "Der Bildschirm jetzt", "L’écran maintenant",
                    "Lo schermo adesso", "La pantalla ahora",    "現在の画面"};
  Translated screen_take{"Take a small, blurred picture",    "Kleines, unscharfes Bild aufnehmen",
                         "Prendre une petite image floue",   "Prendere una piccola immagine sfocata",
                         "Tomar una pequeña imagen borrosa", "小さなぼかし画像を撮る"};
  Translated screen_note{
      "The screen tells visitors. Nobody can be recognised in it, it is kept nowhere, and one a minute is taken at "
      "most.",
      "Der Bildschirm sagt es den Besuchern. Niemand ist zu erkennen, es wird nirgends behalten, höchstens eines je "
      "Minute.",
      "L’écran en informe les visiteurs. Personne n’y est reconnaissable, elle n’est conservée nulle part, une par "
      "minute au plus.",
      "Lo schermo lo dice ai visitatori. Nessuno è riconoscibile, non viene conservata, al massimo una al minuto.",
      "La pantalla lo dice a los visitantes. No se reconoce a nadie, no se guarda en ningún sitio, una por minuto como "
      "máximo.",
      "画面で来場者にお知らせします。個人は識別できず、どこにも保存されません。撮影は1分に1回までです。"};
  Translated screen_alt{"What the screen showed, blurred",      "Was der Bildschirm zeigte, unscharf",
                        "Ce que l’écran montrait, flou",        "Che cosa mostrava lo schermo, sfocato",
                        "Lo que mostraba la pantalla, borroso", "画面に表示されていた内容（ぼかし）"};
  Translated screen_taken{"Taken at", "Aufgenommen um", "Prise à", "Presa alle", "Tomada a las", "撮影時刻"};
  Translated screen_wait{"One was taken within the last minute. The next is possible in",
                         "In der letzten Minute wurde eines aufgenommen. Das nächste ist möglich in",
                         "Une image a été prise il y a moins d’une minute. La prochaine est possible dans",
                         "Un’immagine è stata presa da meno di un minuto. La prossima è possibile tra",
                         "Se tomó una hace menos de un minuto. La siguiente es posible dentro de",
                         "1分以内に撮影されています。次に撮影できるまで"};
  Translated screen_nothing{"Nothing is on the screen.",     "Auf dem Bildschirm ist nichts.",
                            "Rien n’est affiché à l’écran.", "Sullo schermo non c’è nulla.",
                            "No hay nada en la pantalla.",   "画面には何も表示されていません。"};
  Translated screen_off{"Switched off at the kiosk (screen_picture under [snapshot] in its kasumi.toml).",
                        "An der Station ausgeschaltet (screen_picture unter [snapshot] in seiner kasumi.toml).",
                        "Désactivé sur la borne (screen_picture sous [snapshot] dans son kasumi.toml).",
                        "Disattivato sulla postazione (screen_picture sotto [snapshot] nel suo kasumi.toml).",
                        "Desactivado en el puesto (screen_picture en [snapshot] de su kasumi.toml).",
                        "装置側で無効になっています（kasumi.tomlの[snapshot]のscreen_picture）。"};
  Translated screen_no_answer{"The kiosk gave no picture.",       "Die Station gab kein Bild.",
                              "La borne n’a pas donné d’image.",  "La postazione non ha dato un’immagine.",
                              "El puesto no dio ninguna imagen.", "装置から画像が届きませんでした。"};
  Translated screen_count{"Taken since the kiosk’s start",          "Seit dem Start der Station aufgenommen",
                          "Prises depuis le démarrage de la borne", "Prese dall’avvio della postazione",
                          "Tomadas desde el arranque del puesto",   "起動後の撮影回数"};
  Translated language{"Language", "Sprache", "Langue", "Lingua", "Idioma", "言語"};
  Translated as_of{"As of", "Stand", "Au", "Al", "A las", "時点"};
};

}  // namespace kasumi::report
