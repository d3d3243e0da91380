#include "pipeline/site/config/messages.hpp"

namespace kasumi {
namespace {

struct Translations {
  std::string_view english, german, french, italian, spanish, japanese;
};

// French writes a narrow no-break space before its double punctuation marks.
constexpr Translations translations_of(Message message) {
  switch (message) {
    case Message::starting:
      return {"The live picture will appear in a moment.",     "Das Livebild erscheint gleich.",
              "L’image en direct apparaîtra dans un instant.", "L’immagine dal vivo apparirà tra un istante.",
              "La imagen en directo aparecerá en un momento.", "まもなくライブ映像が表示されます。"};
    case Message::scene_camera_missing:
      return {"No picture is coming from the camera.\nThe live view will return by itself.",
              "Von der Kamera kommt kein Bild.\nDas Livebild kehrt von selbst zurück.",
              "La caméra n’envoie pas d’image.\nLa vue en direct reviendra d’elle-même.",
              "Dalla telecamera non arriva nessuna immagine.\nLa vista dal vivo tornerà da sola.",
              "La cámara no envía ninguna imagen.\nLa vista en directo volverá por sí sola.",
              "カメラからの映像が届いていません。\nライブ映像は自動的に復帰します。"};
    case Message::scene_camera_frozen:
      return {"The camera’s picture stands still.\nThe live view will return by itself.",
              "Das Bild der Kamera steht still.\nDas Livebild kehrt von selbst zurück.",
              "L’image de la caméra est figée.\nLa vue en direct reviendra d’elle-même.",
              "L’immagine della telecamera è ferma.\nLa vista dal vivo tornerà da sola.",
              "La imagen de la cámara se ha detenido.\nLa vista en directo volverá por sí sola.",
              "カメラの映像が止まっています。\nライブ映像は自動的に復帰します。"};
    case Message::scene_camera_covered:
      return {"Something covers the camera.\nThe live view returns when it is clear again.",
              "Die Kamera ist verdeckt.\nDas Livebild kehrt zurück, sobald sie wieder frei ist.",
              "La caméra est masquée.\nLa vue en direct reviendra dès qu’elle sera dégagée.",
              "La telecamera è coperta.\nLa vista dal vivo tornerà appena sarà libera.",
              "La cámara está tapada.\nLa vista en directo volverá cuando quede despejada.",
              "カメラが覆われています。\n取り除かれるとライブ映像に戻ります。"};
    case Message::scene_camera_blinded:
      return {"Bright light blinds the camera.\nThe live view returns when it has passed.",
              "Helles Licht blendet die Kamera.\nDas Livebild kehrt danach zurück.",
              "Une lumière vive éblouit la caméra.\nLa vue en direct reviendra ensuite.",
              "Una luce intensa abbaglia la telecamera.\nLa vista dal vivo tornerà poco dopo.",
              "Una luz intensa deslumbra la cámara.\nLa vista en directo volverá después.",
              "強い光のためカメラが見えなくなっています。\n収まるとライブ映像に戻ります。"};
    case Message::sky_camera_missing:
      return {"No picture is coming from the sky camera: the haze is shown as it was last measured.",
              "Von der Himmelskamera kommt kein Bild: Der Dunst ist so gezeigt, wie er zuletzt gemessen wurde.",
              "La caméra du ciel n’envoie pas d’image\u202F: la brume est montrée telle que mesurée en dernier.",
              "Dalla telecamera del cielo non arriva nessuna immagine: la foschia è mostrata come nell’ultima misura.",
              "La cámara del cielo no envía ninguna imagen: la bruma se muestra según la última medición.",
              "空のカメラからの映像が届いていません。\n霞は最後に測定された状態で表示しています。"};
    case Message::no_clock:
      return {"The clock is not set yet.\nThe building appears as soon as the time of day is known.",
              "Die Uhr ist noch nicht gestellt.\nDas Bauwerk erscheint, sobald die Tageszeit bekannt ist.",
              "L’horloge n’est pas encore réglée.\nL’édifice apparaîtra dès que l’heure sera connue.",
              "L’orologio non è ancora regolato.\nL’edificio apparirà appena si conoscerà l’ora.",
              "El reloj aún no está en hora.\nEl edificio aparecerá en cuanto se conozca la hora.",
              "時計がまだ合っていません。\n時刻がわかりしだい建物が現れます。"};
    case Message::closed:
      return {"Closed.\nWe look forward to your next visit.",
              "Geschlossen.\nWir freuen uns auf Ihren nächsten Besuch.",
              "Fermé.\nAu plaisir de vous accueillir prochainement.",
              "Chiuso.\nVi aspettiamo alla prossima visita.",
              "Cerrado.\nLe esperamos en su próxima visita.",
              "本日の公開は終了しました。\nまたのお越しをお待ちしております。"};
    case Message::recording:
      return {"Recording",          "Aufnahme läuft", "Enregistrement en cours", "Registrazione in corso",
              "Grabación en curso", "録画中"};
    case Message::sharp_snapshot:
      return {"A picture of what you see here is being sent to those who look after this kiosk.",
              "Ein Bild dessen, was Sie hier sehen, geht gerade an die Betreuer dieser Station.",
              "Une image de ce que vous voyez ici est envoyée aux responsables de cette borne.",
              "Un’immagine di ciò che vedete qui viene inviata ai responsabili di questa postazione.",
              "Se está enviando una imagen de lo que ve aquí a los responsables de este puesto.",
              "この画面の画像を、この装置の管理者に送信しています。"};
    case Message::page_picture:
      return {"A small blurred picture of this screen goes to those who look after it. Nobody can be recognised.",
              "Ein kleines, unscharfes Bild dieses Bildschirms geht an seine Betreuer. Niemand ist zu erkennen.",
              "Une petite image floue de cet écran est envoyée à ses responsables. Personne n’y est reconnaissable.",
              "Una piccola immagine sfocata di questo schermo va ai suoi responsabili. Nessuno è riconoscibile.",
              "Una pequeña imagen borrosa de esta pantalla se envía a sus responsables. No se reconoce a nadie.",
              "この画面の小さなぼかし画像を管理者に送信しています。\n個人は識別できません。"};
    case Message::safe_mode:
      return {"The live view is out of order.\nWe are taking care of it.",
              "Das Livebild ist gestört.\nWir kümmern uns darum.",
              "La vue en direct est en panne.\nNous nous en occupons.",
              "La vista dal vivo è fuori servizio.\nCe ne stiamo occupando.",
              "La vista en directo está averiada.\nNos estamos ocupando de ello.",
              "ライブ映像は現在ご覧いただけません。\nただいま対応しております。"};
    case Message::earlier_content:
      return {"The latest changes could not be used.\nThe exhibit is shown as it was before.",
              "Die letzten Änderungen waren nicht brauchbar.\nGezeigt wird der Stand davor.",
              "Les dernières modifications sont inutilisables.\nL’état précédent est affiché.",
              "Le ultime modifiche non sono utilizzabili.\nViene mostrato lo stato precedente.",
              "Los últimos cambios no se pueden utilizar.\nSe muestra el estado anterior.",
              "最新の変更を適用できませんでした。\n変更前の状態で表示しています。"};
  }
  return {};
}

}  // namespace

std::string_view message_text(Message message, Language language) {
  const Translations texts = translations_of(message);
  switch (language) {
    case Language::english: return texts.english;
    case Language::german: return texts.german;
    case Language::french: return texts.french;
    case Language::italian: return texts.italian;
    case Language::spanish: return texts.spanish;
    case Language::japanese: return texts.japanese;
  }
  return texts.english;
}

}  // namespace kasumi
