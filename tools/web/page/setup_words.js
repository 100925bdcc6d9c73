// SPDX-License-Identifier: BSD-3-Clause
"use strict";
// Texts of the set-up's page; a question has its English from slamctl, and its German here by its id.
const kSetupTexts = {
  en: {
    setup: "set-up", stepfind: "Find", stepask: "Ask", stepdrive: "Drive", stepcalibrate: "Calibrate", stepwrite: "Write", stepcheck: "Check",
    next: "Next", yes: "Yes", no: "No", again: "Look again", finish: "End the set-up", live: "Open the live page", printed: "Answers, and what was printed",
    setupToken: "This page needs the whole address, with all behind the #, that slamctl setup --web has printed.",
    setupAway: "No answer from the set-up; the page keeps trying. Is the robot on, and in this network?", setupNone: "No set-up runs here. On the robot: sudo slamctl setup --web",
    ended: "The set-up has ended.", axes: "The robot from above", axesWords: "The robot from above. x points forward, y to the left, from the middle between the driven wheels. A few centimetres off are enough: calibration makes it exact.",
    waits: "Waiting for scans and wheels …", push: "Push or drive the robot now: straight on, a whole turn to each side, once through the room.", hold: "Hold the stick to drive: straight on, a whole turn to each side, once through the room. Letting go stops.",
    over: "Recorded. The scans are being matched …", time: "Time", straight: "Straight on", left: "Turned left", right: "Turned right", missing: "{0}, still missing: {1}", enough: "{0}, enough",
    value: "Value", before: "before", after: "after", interval: "± 95 %", stays: "right, stays", changed: "changed", rms: "Scans over wheels, error of a motion: {0} mm and {1}° before, {2} mm and {3}° after.", gyro: "Gyro over scans: {0} ± {1}.",
    scans: "All scans, placed by the wheels alone: before on the left, after on the right. Walls are thin where it is right.", drawn: "The map of your drive",
    notCalibrated: "Not calibrated: {0}", changes: "To be written to {0}", wrote: "Written to {0}", same: "Nothing is to be changed in {0}", noValue: "no value changes", nothing: "nothing known",
    allGood: "doctor: all good", faults: "doctor: {0} faults", notWritten: "Nothing was written.", failed: "The set-up ended: {0}",
    start: "On the robot: sudo systemctl enable --now slamd slamd-web", serviceRuns: "slamd runs again.", serviceFails: "slamd does not start. On the robot: journalctl -u slamd -n 50",
  },
  de: {
    setup: "Einrichten", stepfind: "Suchen", stepask: "Fragen", stepdrive: "Fahren", stepcalibrate: "Kalibrieren", stepwrite: "Schreiben", stepcheck: "Prüfen",
    next: "Weiter", yes: "Ja", no: "Nein", again: "Neu suchen", finish: "Einrichten beenden", live: "Live-Seite öffnen", printed: "Antworten und Ausgaben",
    setupToken: "Diese Seite braucht die ganze Adresse mit allem hinter dem #, die slamctl setup --web ausgegeben hat.",
    setupAway: "Keine Antwort vom Einrichten; die Seite versucht es weiter. Ist der Roboter an und in diesem Netz?", setupNone: "Hier läuft kein Einrichten. Auf dem Roboter: sudo slamctl setup --web",
    ended: "Das Einrichten ist beendet.", axes: "Der Roboter von oben", axesWords: "Der Roboter von oben. x zeigt nach vorn, y nach links, von der Mitte zwischen den angetriebenen Rädern. Auf ein paar Zentimeter kommt es nicht an: die Kalibrierung macht es genau.",
    waits: "Wartet auf Scans und Räder …", push: "Schiebe oder fahre den Roboter jetzt: geradeaus, eine ganze Drehung nach jeder Seite, einmal durch den Raum.", hold: "Stick halten zum Fahren: geradeaus, eine ganze Drehung nach jeder Seite, einmal durch den Raum. Loslassen hält an.",
    over: "Aufgezeichnet. Die Scans werden verglichen …", time: "Zeit", straight: "Geradeaus", left: "Links gedreht", right: "Rechts gedreht", missing: "{0}, es fehlen noch {1}", enough: "{0}, genug",
    value: "Wert", before: "vorher", after: "nachher", interval: "± 95 %", stays: "richtig, bleibt", changed: "geändert", rms: "Scans gegen Räder, Fehler einer Bewegung: vorher {0} mm und {1}°, nachher {2} mm und {3}°.", gyro: "Gyro gegen Scans: {0} ± {1}.",
    scans: "Alle Scans, nur nach den Rädern gelegt: links vorher, rechts nachher. Wände sind dünn, wo es stimmt.", drawn: "Die Karte deiner Fahrt",
    notCalibrated: "Nicht kalibriert: {0}", changes: "Zu schreiben nach {0}", wrote: "Geschrieben nach {0}", same: "In {0} ist nichts zu ändern", noValue: "kein Wert ändert sich", nothing: "nichts Bekanntes",
    allGood: "doctor: alles gut", faults: "doctor: {0} Fehler", notWritten: "Nichts wurde geschrieben.", failed: "Das Einrichten endete: {0}",
    start: "Auf dem Roboter: sudo systemctl enable --now slamd slamd-web", serviceRuns: "slamd läuft wieder.", serviceFails: "slamd startet nicht. Auf dem Roboter: journalctl -u slamd -n 50",
  },
};
for (const name in kSetupTexts) Object.assign(kTexts[name], kSetupTexts[name]);

const kGermanQuestions = {
  "stop_service": "Der Dienst slamd läuft und hat die Anschlüsse. Bis zum Ende anhalten? Der Roboter steht dann.",
  "choose": "Mehrere Geräte kommen in Frage. Welches ist es? Oder das andere ausstecken und neu suchen",
  "lidar.driver": "Kein Lidar wurde gefunden. Was sendet die Scans? Ein Wort aus man slamd.toml, oder none", "lidar.port": "Anschluss des Lidars",
  "lidar.x": "Lidar vor dem Drehpunkt [m]", "lidar.y": "Lidar links vom Drehpunkt [m]", "lidar.yaw": "Nullrichtung des Lidars, gegen den Uhrzeiger von vorn [rad]", "lidar.upside_down": "Hängt das Lidar kopfüber?",
  "base.driver": "Kein Antrieb wurde gefunden. Was liest die Räder? Ein Wort aus man slamd.toml, oder none", "base.port": "Anschluss des Antriebs",
  "base.counts_per_turn": "Schritte des Encoders in einer Radumdrehung; bei VESC: 6 x Polpaare x Getriebe", "base.type": "Räder: differential, omni3 (drei Omniräder) oder mecanum4",
  "base.wheel_radius": "Radius eines angetriebenen Rads [m]", "base.half_track": "Halber Abstand der angetriebenen Räder [m]",
  "can.pole_pairs": "Polpaare eines Motors: halb so viele, wie sein Rotor Magnete hat", "can.left_node": "Nummer des linken Antriebs auf CAN", "can.right_node": "Nummer des rechten Antriebs auf CAN",
  "imu.roll": "Drehung der IMU um die Achse nach vorn [rad], 0: eben, 3.14159: kopfüber",
  "depth.x": "Kamera vor dem Drehpunkt [m]", "depth.z": "Kamera über dem Boden [m]; 0: ihre Bilder werden nicht benutzt", "depth.pitch": "Winkel, um den die Kamera nach unten blickt [rad]",
  "calibrate": "Räder und Lidar jetzt durch eine Fahrt kalibrieren? Du fährst.",
  "again": "Nicht kalibriert. Noch einmal fahren?",
  "joystick": "Mit dem Joystick dieser Seite fahren? Die Räder drehen sich dann, langsam, solange du ihn hältst. Stelle den Roboter auf den Boden, mit Platz um ihn, und bleib in Reichweite seines Schalters. Nein: du schiebst ihn",
  "write": "Das schreiben? Die alte Datei bleibt erhalten.", "finish": "Einrichten beenden",
};
