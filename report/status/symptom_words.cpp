#include "report/status/symptom_words.hpp"

#include "report/status/translated.hpp"

namespace kasumi::report {

namespace {

struct TranslatedSymptom {
  Translated what, what_to_do;
};

Translated translated_sight(Sight sight) {
  switch (sight) {
    case Sight::live:
      return {"Visitors see the live view with the building.",
              "Besucher sehen das Livebild mit dem Bauwerk.",
              "Les visiteurs voient la vue en direct avec l’édifice.",
              "I visitatori vedono la vista dal vivo con l’edificio.",
              "Los visitantes ven la vista en directo con el edificio.",
              "来場者には建物を重ねたライブ映像が見えています。"};
    case Sight::held:
      return {
          "Visitors see the last picture for a moment.",         "Besucher sehen für einen Augenblick das letzte Bild.",
          "Les visiteurs voient un instant la dernière image.",  "I visitatori vedono per un attimo l’ultima immagine.",
          "Los visitantes ven por un momento la última imagen.", "来場者には直前の映像が一時的に見えています。"};
    case Sight::earlier_air:
      return {"Visitors see the live view with the building, under the air as it was last measured.",
              "Besucher sehen das Livebild mit dem Bauwerk, in der Luft, wie sie zuletzt gemessen wurde.",
              "Les visiteurs voient la vue en direct avec l’édifice, dans l’air tel que mesuré en dernier.",
              "I visitatori vedono la vista dal vivo con l’edificio, nell’aria dell’ultima misura.",
              "Los visitantes ven la vista en directo con el edificio, con el aire de la última medición.",
              "来場者には最後に測定した大気での、建物を重ねたライブ映像が見えています。"};
    case Sight::no_building:
      return {"Visitors see the live view without the building.",
              "Besucher sehen das Livebild ohne das Bauwerk.",
              "Les visiteurs voient la vue en direct sans l’édifice.",
              "I visitatori vedono la vista dal vivo senza l’edificio.",
              "Los visitantes ven la vista en directo sin el edificio.",
              "来場者には建物のないライブ映像が見えています。"};
    case Sight::still:
      return {"Visitors see the still picture.",    "Besucher sehen das Standbild.",
              "Les visiteurs voient l’image fixe.", "I visitatori vedono l’immagine fissa.",
              "Los visitantes ven la imagen fija.", "来場者には静止画が見えています。"};
    case Sight::out_of_order:
      return {"Visitors see the still picture and read that the live view is out of order.",
              "Besucher sehen das Standbild und lesen, dass das Livebild gestört ist.",
              "Les visiteurs voient l’image fixe et lisent que la vue en direct est en panne.",
              "I visitatori vedono l’immagine fissa e leggono che la vista dal vivo è fuori servizio.",
              "Los visitantes ven la imagen fija y leen que la vista en directo está averiada.",
              "来場者には静止画と、ライブ映像が休止中との案内が見えています。"};
    case Sight::closed:
      return {"Closed: the screen is dark on purpose.",          "Geschlossen: Der Bildschirm ist absichtlich dunkel.",
              "Fermé\u202F: l’écran est éteint volontairement.", "Chiuso: lo schermo è spento di proposito.",
              "Cerrado: la pantalla está apagada a propósito.",  "閉館中です。画面は意図して消しています。"};
    case Sight::stopped:
      return {"Visitors see nothing: the kiosk was stopped.",
              "Besucher sehen nichts: Die Station wurde angehalten.",
              "Les visiteurs ne voient rien\u202F: la borne a été arrêtée.",
              "I visitatori non vedono nulla: la postazione è stata fermata.",
              "Los visitantes no ven nada: el puesto se ha detenido.",
              "装置は人の操作で停止されており、来場者には何も見えていません。"};
    case Sight::nothing:
      return {"Visitors see nothing: there is no screen.",
              "Besucher sehen nichts: Es ist kein Bildschirm da.",
              "Les visiteurs ne voient rien\u202F: il n’y a pas d’écran.",
              "I visitatori non vedono nulla: manca lo schermo.",
              "Los visitantes no ven nada: no hay pantalla.",
              "画面がないため、来場者には何も見えていません。"};
    case Sight::unknown:
      return {"What visitors see is not known.",        "Was Besucher sehen, ist nicht bekannt.",
              "On ignore ce que voient les visiteurs.", "Non si sa che cosa vedano i visitatori.",
              "No se sabe qué ven los visitantes.",     "来場者に何が見えているか不明です。"};
  }
  return {};
}

TranslatedSymptom translated_symptom(Ill ill) {
  switch (ill) {
    case Ill::not_running:
      return {{"The kiosk’s program is not running.", "Das Programm der Station läuft nicht.",
               "Le programme de la borne n’est pas en marche.", "Il programma della postazione non è in esecuzione.",
               "El programa del puesto no está en marcha.", "装置のプログラムが動いていません。"},
              {"Start it: sudo systemctl start kasumi. While both cameras are being recorded, this is as it should be.",
               "Starten: sudo systemctl start kasumi. Während beide Kameras aufgezeichnet werden, ist das in Ordnung.",
               "Démarrez-le\u202F: sudo systemctl start kasumi. Pendant un enregistrement des caméras, c’est normal.",
               "Avviarlo: sudo systemctl start kasumi. Durante una registrazione delle telecamere è normale.",
               "Inícielo con sudo systemctl start kasumi. Mientras se graban las cámaras es normal.",
               "sudo systemctl start kasumi で起動してください。カメラの録画中であれば正常です。"}};
    case Ill::silent:
      return {
          {"The kiosk’s program has stopped telling its state.", "Das Programm der Station meldet sich nicht mehr.",
           "Le programme de la borne ne donne plus de nouvelles.", "Il programma della postazione non dà più notizie.",
           "El programa del puesto ha dejado de informar.", "装置のプログラムから状態が届かなくなりました。"},
          {"If it hangs, its watchdog restarts it within 25 s. If this stays: is the disk full?",
           "Hängt es, startet der Watchdog es binnen 25 s neu. Bleibt es so: Ist die Platte voll?",
           "S’il est bloqué, le chien de garde le relance en 25 s. Sinon\u202F: le disque est-il plein\u202F?",
           "Se è bloccato, il watchdog lo riavvia entro 25 s. Se continua: il disco è pieno?",
           "Si está colgado, el watchdog lo reinicia en 25 s. Si continúa: ¿está lleno el disco?",
           "停止している場合は25秒以内に自動で再起動します。続く場合はディスクの空きを確認してください。"}};
    case Ill::unreadable:
      return {{"The kiosk’s status cannot be read.", "Der Zustand der Station ist nicht lesbar.",
               "L’état de la borne est illisible.", "Lo stato della postazione non è leggibile.",
               "No se puede leer el estado del puesto.", "装置の状態を読み取れません。"},
              {"Are kasumi and kasumi-report of the same version? Is the disk sound?",
               "Haben kasumi und kasumi-report dieselbe Version? Ist die Platte in Ordnung?",
               "kasumi et kasumi-report sont-ils de la même version\u202F? Le disque est-il sain\u202F?",
               "kasumi e kasumi-report hanno la stessa versione? Il disco è integro?",
               "¿Son kasumi y kasumi-report de la misma versión? ¿Está bien el disco?",
               "kasumi と kasumi-report の版が同じか、ディスクが正常かを確認してください。"}};
    case Ill::no_display:
      return {{"There is no screen.", "Es ist kein Bildschirm da.", "Il n’y a pas d’écran.", "Manca lo schermo.",
               "No hay pantalla.", "画面が見つかりません。"},
              {"Is the screen on, and its cable plugged in? The picture returns by itself.",
               "Ist der Bildschirm an, steckt das Kabel? Das Bild kehrt von selbst zurück.",
               "L’écran est-il allumé et branché\u202F? L’image reviendra d’elle-même.",
               "Lo schermo è acceso e collegato? L’immagine torna da sola.",
               "¿Está encendida y conectada la pantalla? La imagen vuelve por sí sola.",
               "画面の電源とケーブルを確認してください。映像は自動的に戻ります。"}};
    case Ill::scene_lost:
      return {
          {"No picture is coming from the scene camera.", "Von der Szenenkamera kommt kein Bild.",
           "La caméra de la scène n’envoie pas d’image.", "Dalla telecamera della scena non arriva nessuna immagine.",
           "La cámara de la escena no envía ninguna imagen.", "風景カメラからの映像が届いていません。"},
          {"Check its cable, hub and power. It comes back by itself within 3 s of the camera.",
           "Kabel, Hub und Strom prüfen. Das Bild ist 3 s nach der Kamera wieder da.",
           "Vérifiez câble, concentrateur et alimentation. L’image revient 3 s après la caméra.",
           "Controllare cavo, hub e alimentazione. L’immagine torna entro 3 s dalla telecamera.",
           "Revise cable, concentrador y corriente. La imagen vuelve 3 s después de la cámara.",
           "ケーブル、ハブ、電源を確認してください。復旧後3秒以内に映像が戻ります。"}};
    case Ill::scene_frozen:
      return {{"The scene camera’s picture stands still.", "Das Bild der Szenenkamera steht still.",
               "L’image de la caméra de la scène est figée.", "L’immagine della telecamera della scena è ferma.",
               "La imagen de la cámara de la escena se ha detenido.", "風景カメラの映像が止まっています。"},
              {"Switch the camera off and on again.", "Die Kamera aus- und wieder einschalten.",
               "Éteignez puis rallumez la caméra.", "Spegnere e riaccendere la telecamera.",
               "Apague y vuelva a encender la cámara.", "カメラの電源を入れ直してください。"}};
    case Ill::scene_covered:
      return {{"Something covers the scene camera.", "Die Szenenkamera ist verdeckt.",
               "La caméra de la scène est masquée.", "La telecamera della scena è coperta.",
               "La cámara de la escena está tapada.", "風景カメラが覆われています。"},
              {"Look at its lens.", "Das Objektiv ansehen.", "Examinez l’objectif.", "Guardare l’obiettivo.",
               "Mire el objetivo.", "レンズを確認してください。"}};
    case Ill::scene_white_out:
      return {{"The scene camera sees nothing but white.", "Die Szenenkamera sieht nur Weiß.",
               "La caméra de la scène ne voit que du blanc.", "La telecamera della scena vede solo bianco.",
               "La cámara de la escena solo ve blanco.", "風景カメラの映像が真っ白です。"},
              {"Look at its lens: sun, fog, condensation? It returns by itself.",
               "Das Objektiv ansehen: Sonne, Nebel, Beschlag? Das Bild kehrt von selbst zurück.",
               "Examinez l’objectif\u202F: soleil, brouillard, buée\u202F? L’image reviendra d’elle-même.",
               "Guardare l’obiettivo: sole, nebbia, condensa? L’immagine torna da sola.",
               "Mire el objetivo: ¿sol, niebla, vaho? La imagen vuelve por sí sola.",
               "レンズへの日光、霧、結露を確認してください。映像は自動的に戻ります。"}};
    case Ill::starting:
      return {{"It has started, and no picture has come from the scene camera yet.",
               "Gestartet, doch von der Szenenkamera kam noch kein Bild.",
               "Démarré, mais la caméra de la scène n’a pas encore envoyé d’image.",
               "Avviato, ma dalla telecamera della scena non è ancora arrivata nessuna immagine.",
               "Iniciado, pero la cámara de la escena aún no ha enviado ninguna imagen.",
               "起動しましたが、風景カメラの映像がまだ届いていません。"},
              {"Wait a minute; then check the camera’s cable and power.",
               "Eine Minute warten, dann Kabel und Strom der Kamera prüfen.",
               "Attendez une minute, puis vérifiez le câble et l’alimentation de la caméra.",
               "Attendere un minuto, poi controllare cavo e alimentazione della telecamera.",
               "Espere un minuto; después revise el cable y la corriente de la cámara.",
               "1分待ってから、カメラのケーブルと電源を確認してください。"}};
    case Ill::safe_mode:
      return {
          {"Safe mode: too many starts have failed.", "Notbetrieb: Zu viele Starts sind gescheitert.",
           "Mode de secours\u202F: trop de démarrages ont échoué.", "Modalità provvisoria: troppi avvii falliti.",
           "Modo seguro: han fallado demasiados arranques.", "起動の失敗が続いたため、セーフモードで動いています。"},
          {"Mend the cause, then: sudo systemctl restart kasumi.",
           "Die Ursache beheben, dann: sudo systemctl restart kasumi.",
           "Corrigez la cause, puis\u202F: sudo systemctl restart kasumi.",
           "Rimuovere la causa, poi: sudo systemctl restart kasumi.",
           "Corrija la causa y después: sudo systemctl restart kasumi.",
           "原因を取り除いてから sudo systemctl restart kasumi を実行してください。"}};
    case Ill::cannot_draw:
      return {{"The scene camera’s pictures cannot be drawn.", "Die Bilder der Szenenkamera sind nicht darstellbar.",
               "Les images de la caméra de la scène ne peuvent pas être affichées.",
               "Le immagini della telecamera della scena non si possono mostrare.",
               "No se pueden dibujar las imágenes de la cámara de la escena.", "風景カメラの映像を描画できません。"},
              {"Configure another picture size, mask or driver.",
               "Andere Bildgröße, Maske oder anderen Treiber einstellen.",
               "Choisissez une autre taille d’image, un autre masque ou pilote.",
               "Impostare altra dimensione dell’immagine, maschera o driver.",
               "Configure otro tamaño de imagen, máscara o controlador.",
               "画像サイズ、マスク、ドライバーの設定を変えてください。"}};
    case Ill::sky_lost:
      return {{"No picture is coming from the sky camera.", "Von der Himmelskamera kommt kein Bild.",
               "La caméra du ciel n’envoie pas d’image.", "Dalla telecamera del cielo non arriva nessuna immagine.",
               "La cámara del cielo no envía ninguna imagen.", "空のカメラからの映像が届いていません。"},
              {"Check its cable and power. Until then the air is shown as it was last measured.",
               "Kabel und Strom prüfen. Bis dahin gilt die zuletzt gemessene Luft.",
               "Vérifiez câble et alimentation. D’ici là, l’air est celui mesuré en dernier.",
               "Controllare cavo e alimentazione. Fino ad allora vale l’aria dell’ultima misura.",
               "Revise cable y corriente. Hasta entonces se usa el aire de la última medición.",
               "ケーブルと電源を確認してください。それまでは最後に測定した大気で表示します。"}};
    case Ill::clock_unset:
      return {{"The clock is not set: no sun, no building.", "Die Uhr ist nicht gestellt: keine Sonne, kein Bauwerk.",
               "L’horloge n’est pas à l’heure\u202F: ni soleil ni édifice.",
               "L’orologio non è regolato: niente sole né edificio.", "El reloj no está en hora: sin sol ni edificio.",
               "時計が合っていないため、太陽の位置がわからず建物を表示できません。"},
              {"Give the machine a time server or a clock chip, or set [clock] policy.",
               "Dem Rechner einen Zeitserver oder Uhrenbaustein geben, oder [clock] policy setzen.",
               "Donnez à la machine un serveur de temps ou une horloge, ou réglez [clock] policy.",
               "Dare alla macchina un server dell’ora o un orologio, o impostare [clock] policy.",
               "Dé a la máquina un servidor de hora o un reloj, o ajuste [clock] policy.",
               "時刻サーバーまたは時計ICを用意するか、[clock] policy を設定してください。"}};
    case Ill::air_supposed:
      return {{"Nobody sees the air: how hazy it is, is supposed.", "Niemand sieht die Luft: Der Dunst ist angenommen.",
               "Personne ne voit l’air\u202F: la brume est supposée.", "Nessuno vede l’aria: la foschia è presunta.",
               "Nadie ve el aire: la bruma es supuesta.", "大気を観測できないため、霞は推定値です。"},
              {"Wait for a clear sky, or name landmarks, which tell it under clouds.",
               "Auf klaren Himmel warten oder Landmarken angeben: Sie zeigen sie auch unter Wolken.",
               "Attendez un ciel clair, ou indiquez des repères, qui la montrent sous les nuages.",
               "Attendere cielo sereno, o indicare punti di riferimento, che la mostrano sotto le nuvole.",
               "Espere un cielo despejado o indique referencias, que la muestran bajo las nubes.",
               "晴天を待つか、曇天でも使える目印を設定してください。"}};
    case Ill::observers_disagree:
      return {
          {"Sky and landmarks tell different air.", "Himmel und Landmarken zeigen verschiedene Luft.",
           "Le ciel et les repères indiquent un air différent.", "Cielo e punti di riferimento indicano arie diverse.",
           "El cielo y las referencias indican aire distinto.", "空と目印とで、示す大気が異なります。"},
          {"Clean the sky camera’s dome; look at the landmarks’ boxes.",
           "Kuppel der Himmelskamera reinigen; Felder der Landmarken ansehen.",
           "Nettoyez le dôme de la caméra du ciel\u202F; vérifiez les cadres des repères.",
           "Pulire la cupola della telecamera del cielo; controllare i riquadri.",
           "Limpie la cúpula de la cámara del cielo; revise los recuadros de las referencias.",
           "空のカメラのドームを清掃し、目印の枠を確認してください。"}};
    case Ill::camera_moved:
      return {{"A camera has changed since it was calibrated.", "Eine Kamera hat sich seit der Kalibrierung verändert.",
               "Une caméra a changé depuis son étalonnage.", "Una telecamera è cambiata dalla calibrazione.",
               "Una cámara ha cambiado desde su calibración.", "カメラが較正時から変化しています。"},
              {"Straighten it, or calibrate it again.", "Ausrichten oder neu kalibrieren.",
               "Redressez-la ou étalonnez-la de nouveau.", "Raddrizzarla o calibrarla di nuovo.",
               "Enderécela o vuelva a calibrarla.", "向きを直すか、較正し直してください。"}};
    case Ill::camera_soiled:
      return {{"A camera’s dome or lens is dirty, fogged or out of focus.",
               "Kuppel oder Objektiv einer Kamera ist schmutzig, beschlagen oder unscharf.",
               "Le dôme ou l’objectif d’une caméra est sale, embué ou flou.",
               "La cupola o l’obiettivo di una telecamera è sporco, appannato o fuori fuoco.",
               "La cúpula o el objetivo de una cámara está sucio, empañado o desenfocado.",
               "カメラのドームまたはレンズに汚れ、曇り、ピントのずれがあります。"},
              {"Clean it.", "Reinigen.", "Nettoyez-le.", "Pulirlo.", "Límpielo.", "清掃してください。"}};
    case Ill::hot:
      return {{"The machine is too hot: fewer pictures are shown.",
               "Der Rechner ist zu heiß: Es werden weniger Bilder gezeigt.",
               "La machine est trop chaude\u202F: moins d’images sont affichées.",
               "La macchina è troppo calda: si mostrano meno immagini.",
               "La máquina está demasiado caliente: se muestran menos imágenes.",
               "機器が高温のため、表示枚数を減らしています。"},
              {"Look for dust, a fan that stands still, sun on the case.",
               "Staub, stehender Lüfter, Sonne auf dem Gehäuse?",
               "Cherchez\u202F: poussière, ventilateur arrêté, soleil sur le boîtier.",
               "Cercare polvere, ventola ferma, sole sulla custodia.",
               "Busque polvo, un ventilador parado o sol sobre la caja.",
               "ほこり、ファンの停止、直射日光を確認してください。"}};
    case Ill::hung:
      return {{"A part of the program hangs.", "Ein Teil des Programms hängt.", "Une partie du programme est bloquée.",
               "Una parte del programma è bloccata.", "Una parte del programa está colgada.",
               "プログラムの一部が応答していません。"},
              {"A driver or the disk does not answer. If this stays: sudo systemctl restart kasumi.",
               "Ein Treiber oder die Platte antwortet nicht. Bleibt es so: sudo systemctl restart kasumi.",
               "Un pilote ou le disque ne répond pas. Si cela dure\u202F: sudo systemctl restart kasumi.",
               "Un driver o il disco non risponde. Se continua: sudo systemctl restart kasumi.",
               "Un controlador o el disco no responde. Si continúa: sudo systemctl restart kasumi.",
               "ドライバーまたはディスクが応答していません。続く場合は sudo systemctl restart kasumi "
               "を実行してください。"}};
    case Ill::content_refused:
      return {{"The configured content is refused; shown is what worked last.",
               "Der eingestellte Inhalt wird abgelehnt; gezeigt wird, was zuletzt ging.",
               "Le contenu configuré est refusé\u202F; le dernier qui fonctionnait est affiché.",
               "Il contenuto configurato è rifiutato; si mostra l’ultimo funzionante.",
               "El contenido configurado se rechaza; se muestra el último que funcionó.",
               "設定された内容を使えないため、最後に動いた内容を表示しています。"},
              {"Correct what is named, then: sudo systemctl reload kasumi.",
               "Das Genannte berichtigen, dann: sudo systemctl reload kasumi.",
               "Corrigez ce qui est nommé, puis\u202F: sudo systemctl reload kasumi.",
               "Correggere quanto indicato, poi: sudo systemctl reload kasumi.",
               "Corrija lo indicado y después: sudo systemctl reload kasumi.",
               "示された箇所を直してから sudo systemctl reload kasumi を実行してください。"}};
    case Ill::reload_refused:
      return {{"The last change was refused; the old content stays.",
               "Die letzte Änderung wurde abgelehnt; der alte Inhalt bleibt.",
               "La dernière modification a été refusée\u202F; l’ancien contenu reste.",
               "L’ultima modifica è stata rifiutata; resta il contenuto precedente.",
               "El último cambio se rechazó; sigue el contenido anterior.",
               "最後の変更は適用されず、以前の内容のままです。"},
              {"Correct what is named, then: sudo systemctl reload kasumi.",
               "Das Genannte berichtigen, dann: sudo systemctl reload kasumi.",
               "Corrigez ce qui est nommé, puis\u202F: sudo systemctl reload kasumi.",
               "Correggere quanto indicato, poi: sudo systemctl reload kasumi.",
               "Corrija lo indicado y después: sudo systemctl reload kasumi.",
               "示された箇所を直してから sudo systemctl reload kasumi を実行してください。"}};
  }
  return {};
}

}  // namespace

std::string_view sight_text(Sight sight, Language language) {
  return translated_sight(sight).in(language);
}

SymptomWords symptom_words(Ill ill, Language language) {
  const auto words = translated_symptom(ill);
  return {words.what.in(language), words.what_to_do.in(language)};
}

std::string detail_text(const Symptom& symptom, Language language) {
  if (symptom.more == 0) return symptom.detail;
  const auto more = [&](const char* before, const char* after) {
    return fmt::format("{} ({}{}{})", symptom.detail, before, symptom.more, after);
  };
  switch (language) {
    case Language::english: return more("and ", " more");
    case Language::german: return more("und ", " weitere");
    case Language::french: return more("et ", " autres");
    case Language::italian: return more("e altri ", "");
    case Language::spanish: return more("y ", " más");
    case Language::japanese: return more("ほか", "件");
  }
  return symptom.detail;
}

}  // namespace kasumi::report
