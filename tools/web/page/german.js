// SPDX-License-Identifier: BSD-3-Clause
"use strict";
// Problems and answers of daemon/problems/ in German: id, cause, fix, and what slamd does meanwhile where that matters.
window.kGerman = Object.fromEntries(`not_opened|noch nicht geöffnet
not_wanted|nicht vom CAN genommen
opening|wird geöffnet
waits_for_frames|wartet auf erste Frames ({0})
stopped_opening|beim Öffnen angehalten
port_missing|kein solcher Anschluss|Kabel und udev-Regel prüfen
port_gone|der Anschluss ist weg: ausgesteckt?
port_in_use|ein anderes Programm benutzt den Anschluss
port_held|ein anderes Programm benutzt den Anschluss ({0}, {1})|Beende es; einen Dienst mit sudo systemctl stop {0}
port_is_none|kein serieller Anschluss|Pfad prüfen
port_hidden|kein Recht auf {0} (EACCES)|Rechte des Ordners prüfen
port_of_no_group|kein Recht auf den Anschluss (EACCES): Gruppe {0} ist nicht für Anschlüsse|slamds udev-Regeln installieren, sudo udevadm trigger
port_shut|kein Recht auf den Anschluss (EACCES): Gruppe {0} darf ihn nicht lesen und schreiben|slamds udev-Regeln installieren, sudo udevadm trigger
uart_of_no_group|kein Recht auf den Anschluss (EACCES): Gruppe {0} ist nicht für Anschlüsse|Konsole darauf beenden (serial-getty@{1}), {1} der Gruppe dialout geben
uart_shut|kein Recht auf den Anschluss (EACCES): Gruppe {0} darf ihn nicht lesen und schreiben|Konsole darauf beenden (serial-getty@{1}), {1} der Gruppe dialout geben
port_of_others|kein Recht auf den Anschluss (EACCES): er gehört Gruppe {0}|sudo usermod -aG {0} $USER und neu anmelden, oder SupplementaryGroups={0}
port_forbidden|kein Recht auf den Anschluss (EACCES), obwohl Gruppe {0} es hat|dmesg und aa-status ansehen
port_not_listed|von hier nicht zu öffnen (EPERM): DevicePolicy oder Container verbietet es|DeviceAllow={0} rw, oder docker run --device={0}
no_descriptors|keine Dateideskriptoren mehr frei|slamd neu starten, LimitNOFILE erhöhen
adapter_dead|der Adapter antwortet nicht (EIO)|aus- und wieder einstecken
port_not_opened|Anschluss nicht zu öffnen: {0}|Pfad, Kabel und dmesg prüfen
port_unknown|libserialport findet ihn nicht: /proc und /sys fehlen|einhängen
port_refuses_settings|der Anschluss lehnt die Einstellungen ab|Baudrate prüfen
tcp_address_bad|{0} ist keine Netzadresse eines Geräts|so schreiben: tcp://192.168.0.10:10940
tcp_refused|{0} lehnt die Verbindung ab|Portnummer prüfen; anderes Programm beenden
tcp_no_way|kein Weg führt zu {0}|Netzkabel prüfen, Adresse im Netz des Lidars geben (ip address)
tcp_no_reply|{0} antwortet nicht|Strom, Kabel und Adresse prüfen (ping)
tcp_closed|{0} hat die Verbindung beendet|anderes Programm beenden, sonst Strom prüfen
tcp_silent|{0} nimmt an, sendet aber nichts von diesem Lidar|lidar.driver und lidar.port prüfen
other_baud|{0} antwortet mit {#0} bit/s, nicht mit {#1}|{1}.baud = {#0} setzen
other_device|{0} steckt hier: {1} wird vermisst|Kabel vertauscht? {1}.port und {2}.port tauschen
foreign_device|{0} steckt hier ({#0} bit/s{1})|richtigen Anschluss setzen: slamctl doctor
foreign_lidar|{0} steckt hier ({#0} bit/s{1})|lidar.driver = {2} setzen
foreign_base|{0} steckt hier ({#0} bit/s{1})|base.driver = "{2}" setzen
foreign_imu|{0} steckt hier ({#0} bit/s{1})|imu.driver = "{2}" setzen
lidar_unheard|Anschluss da, aber nichts kommt|5 V, Datenleitung und Motor prüfen
lidar_no_packets|Bytes ohne Pakete dieses Lidars|lidar.driver, lidar.baud, Kabel und Masse prüfen
lidar_searched|sucht, welches Lidar es ist
lidar_not_found|etwas sendet, aber kein Lidar, das sich finden lässt|lidar.driver auf das Modell setzen, Kabel und Masse prüfen
lidar_undecoded|Bytes ohne Antwort darin|Baudrate prüfen
lidar_unanswered|Anschluss da, keine Antwort|Baudrate und 5 V prüfen
lidar_silent|Anschluss da, keine Antwort|5 V und Kabel prüfen
lidar_idle|Anschluss da, Zustand gut|5 V und Motor prüfen
lidar_stopped|antwortet, aber der Scan steht; es meldet: {0}|Strom prüfen, Handbuch
lidar_error|das Lidar meldet einen Hardwarefehler|Handbuch
lidar_error_stays|Hardwarefehler auch nach Neustarts|Handbuch
lidar_unknown|das Lidar nennt Zustand, aber kein Modell|Kabel prüfen
lidar_restarted|das Lidar hat mitten im Scan neu gestartet|5 V prüfen
lidar_head_stands|Messungen ohne ganze Umdrehung|der Kopf steht, Riemen prüfen
lidar_motor_stands|Scan angenommen, keine Daten|der Motor steht, Stecker und 5 V prüfen
lidar_garbage|Bytes ohne Messungen|Kabel, Masse und scan_mode prüfen
lidar_no_scan|das Lidar beginnt keinen Scan|5 V prüfen
lidar_spins_up|wartet auf die Drehzahl
lidar_warns|läuft, aber das Lidar warnt|Fenster putzen, Handbuch
lidar_halved|eine Umdrehung hat mehr Messungen als Platz ist (4080)|Motor schneller, oder sparsamerer lidar.scan_mode
lidar_thinned|eine Umdrehung hat viel mehr Messungen als Platz ist (4080)|Motor schneller: Strom und Riemen prüfen
lidar_stuck|jeder Scan ist gleich, obwohl der Roboter fährt|ausstecken
board_opening|wartet auf die erste Antwort der Platine
board_undecoded|was kommt, ist kein RoboLink|Baudrate und Kabel prüfen
board_unanswered|die Platine antwortet nie|Baudrate und Strom prüfen
board_garbage|Antworten nicht lesbar|Baudrate und Kabel prüfen
board_silent|die Platine antwortet nicht|Strom prüfen
board_late|die Platine antwortet zu spät|hängt anderes daran (USB-Hub, Kabel)?
board_frozen|die Platine antwortet, aber immer dasselbe|neu starten
board_no_mileage|die Platine sendet keinen Weg|neu starten
board_imu_frozen|die IMU-Werte ändern sich nie|neu starten
board_imu_offline|die IMU der Platine ist aus|Platine neu starten, IMU-Kabel prüfen
board_body_radius|die Platine hat eine andere halbe Spur|base.half_track oder die Platine richtigstellen
board_wheel_radius|die Platine hat einen anderen Radradius|base.wheel_radius oder die Platine richtigstellen
board_other_base|die Platine treibt eine andere Bauart|base.kinematics setzen
base_undecoded|was kommt, ist nicht von {0}|base.driver, base.baud und Kabel prüfen
base_lifted|ein Rad hängt in der Luft: angehoben, oder an einer Kante|auf den Boden stellen
base_left_safe_mode|von selbst angehalten: Rad, Kante, Ladestation oder Knopf|Weg frei machen, weiterfahren
base_bumped|Stoßfänger gedrückt|zurückfahren
base_geometry|base.wheel_radius ist {#0.4} m, base.half_track {#1.4} m, aber {0} hat {#2.4} m und {#3.4} m|diese Werte setzen, oder slam-calibrate
imu_undecoded|was kommt, ist nicht von {0}|imu.driver, imu.baud und Anschluss prüfen
imu_unanswered|die IMU schweigt|Strom prüfen{1}
imu_garbage|IMU nicht lesbar|Baudrate und Kabel prüfen
imu_silent|die IMU sendet nichts|Strom prüfen{1}
imu_no_rate|{0} sendet keine Drehraten|im Programm des Herstellers einschalten: {2}
imu_senseless|die IMU sendet unmögliche Werte|neu starten
imu_frozen|die IMU-Werte ändern sich nie|neu starten
imu_no_acceleration|kaum Beschleunigung von der IMU|Ausgabe einschalten
vesc_away|VESC {#0} ({0}) antwortet nicht über CAN|CAN-Kabel, Strom, can.{0}_node prüfen
vesc_fault|VESC {#0} ({0}): Fehler {#1}
iio_missing|der Kernel hat keine IMU {0}|imu.port setzen (grep . /sys/bus/iio/devices/*/name), Treiber laden
iio_no_gyro|{0} hat kein Gyro mit drei Achsen|anderen imu.port setzen
iio_unread|der Kernel kann {0} nicht lesen|Leitungen und Bus prüfen: dmesg
can_gone|Schnittstelle {0} ist weg: ausgesteckt?
can_down|{0} ist aus|ip link set {0} up
can_bus_off|{0} ist bus-off|Leitung und Abschluss prüfen
can_passive|{0} ist error-passive|Leitung, Abschluss und Bitrate prüfen
can_unsupported|der Kernel hat kein CAN|modprobe can-raw
can_refused|kein CAN-Socket auf {0}|journalctl -u slamd -n 20, dmesg
can_blocked|{0} nimmt keine Frames an|drehen die Räder, den Strom abschalten; Adapter neu stecken|die Räder behalten ihr Tempo bis zum Watchdog der Antriebe
can_no_imu|keine Frames der IMU (005, 032, 034)|Strom und Bitrate prüfen
can_no_rate|die IMU sendet keine Drehrate (032)|Ausgabe einschalten
can_no_acceleration|die IMU sendet keine Beschleunigung (034)|Ausgabe einschalten
can_no_time|die IMU sendet keine Zeit (005)|Ausgabe einschalten
can_rare_time|weniger Zeiten (005) als Drehraten (032)|gleiche Rate setzen
can_rare_acceleration|weniger Beschleunigungen (034) als Drehraten (032)|gleiche Rate setzen
can_imu_senseless|IMU-Frames ergeben keine Messung
can_imu_frozen|die IMU-Werte ändern sich nie|neu starten
wheels_senseless|die Räder senden Unmögliches
no_wheels|nichts vom linken (Knoten 0x{#0x2}) und rechten Rad (0x{#1x2})|Strom, Bitrate, can.left_node, can.right_node prüfen
no_frames|nichts vom Rad {0} (Knoten 0x{#0x2})|Strom und Stecker des Antriebs prüfen
no_estimates|Rad {0} (Knoten 0x{#0x2}) sendet keine Encoderwerte|Rate setzen
bad_estimates|Rad {0} (Knoten 0x{#0x2}): Encoderwerte sind keine Zahlen|Antrieb neu starten, Encoder kalibrieren, Kabel prüfen
no_heartbeat|kein Heartbeat vom Rad {0} (Knoten 0x{#0x2})|heartbeat_msg_rate_ms auf 100 setzen
wheel_frozen|Rad {0} (Knoten 0x{#0x2}) dreht, aber sein Ort bleibt|Encoder prüfen
not_armed|Rad {0} (Knoten 0x{#0x2}) ist nicht scharf|cansend {2} {#1x3}#08000000
not_following|Rad {0} (Knoten 0x{#0x2}) dreht nicht mit: blockiert?|Rad frei machen, cansend {2} {#3x3}#0200000001000000|slamd hält beide Räder an
shared_id|Heartbeat vom Rad {0} (Knoten 0x{#0x2}) hat die Id des Quaternions|dieses abschalten, oder Knoten 16
slow_estimates|Rad {0}: Encoderwerte nur alle {#0} ms|encoder_msg_rate_ms auf 10 bis 50 setzen
axis_error|Rad {0}: Achsfehler {1}|beheben, dann cansend {2} {#2x3}# und cansend {2} {#1x3}#08000000
no_openni|OpenNI2 startet nicht|libopenni2-0 installiert?
camera_reset|keine Bilder: wird am USB zurückgesetzt
camera_sought|sucht die Kamera|dauert es, Kabel prüfen
camera_opening|wartet auf das erste Bild
camera_missing|keine Kamera gefunden|Stecker und Strom prüfen
camera_hidden|Kamera am USB, OpenNI2 findet sie nicht|udev-Regeln prüfen
camera_name_missing|keine Kamera {0} (depth.uri)|da ist {1}: setzen, oder leer lassen
camera_not_opened|Kamera nicht zu öffnen|Rechte und andere Programme prüfen
camera_no_stream|das Gerät hat kein Tiefenbild|depth.uri auf eine Tiefenkamera setzen
camera_not_started|kein Tiefenbild|USB-2-Anschluss, genug Bandbreite?
camera_no_mode|die Kamera hat {0} nicht|depth.width, height, rate auf {1} setzen
camera_other_mode|die Kamera nahm den Modus nicht an|depth.width, height, rate anders setzen
camera_other_format|Tiefe nicht in 1 mm|andere Kamera oder Aufnahme
camera_no_view|kein Blickwinkel bekannt|andere Kamera oder Aufnahme
camera_unplugged|Kamera ausgesteckt|wieder einstecken
camera_frozen|0,9 s kein Bild: Kamera hängt
camera_unread|Bild nicht lesbar
images_missing|keine solche Aufnahme|siehe depth.uri
images_not_opened|Aufnahme nicht zu öffnen|siehe depth.uri
images_not_played|Aufnahme nicht bildweise abspielbar|siehe depth.uri
images_over|die Aufnahme ist zu Ende|slamd neu starten
images_not_stored|die Aufnahme beginnt nicht|depth.record schreibbar?
images_not_recorded|Bilder nicht aufzuzeichnen|Datei schreibbar?
camera_not_mounted|Bilder nicht benutzt|Höhe der Kamera messen, depth.z setzen
camera_stuck|jedes Bild ist gleich|ausstecken
images_wrong_size|Bilder falscher Größe
images_empty|Bilder ohne Tiefe|Kamera verdeckt, oder Sonne?
images_tilted|der Boden ist nicht, wo [depth] ihn hat|pitch, roll und z prüfen
images_below_floor|viel liegt unter dem Boden|pitch, roll und z prüfen
damaged|{#0.1} von {#1.1} Hz, {#2.1} je Sekunde gehen verloren|Kabel, Stecker, Masse prüfen, USB ohne Hub
slow|{#0.1} von {#1.1} Hz, nichts ist beschädigt|Senderate und Strom prüfen
starved|der Rechner ist überlastet|andere Programme beenden (top)
silent|Anschluss da, aber still|ausstecken
lcm_opening|wartet auf LCM
lcm_silent|niemand sendet über LCM|Programm starten; beide brauchen eine lcm.url
stamps_old|Stempel {#0s} s alt|Log: slam-replay; sonst timedatectl set-ntp true
stamps_ahead|Stempel {#0s} s voraus|Uhr des Senders: timedatectl set-ntp true
refused|{0} abgelehnt: {1}|{2}
lidar_upside_down|Lidar dreht gegen Gyro und Räder|kopfüber? lidar.upside_down ändern
lidar_against_gyro|Lidar und Gyro drehen entgegengesetzt|lidar.upside_down ändern, oder z-Achse des Gyros
lidar_against_wheels|Lidar und Räder drehen entgegengesetzt|lidar.upside_down ändern, oder Räder vertauscht?
gyro_reversed|Gyro dreht verkehrt: z-Achse nach unten?|IMU umdrehen, oder z negieren
wheels_swapped|Räder drehen gegen das Lidar|links und rechts vertauscht?
wheels_backwards|Räder fahren und drehen verkehrt|zählen beide rückwärts?
lidar_yaw_off|Lidar fährt in andere Richtung als die Räder|{#0.2} rad zu lidar.yaw
wheel_distance_off|Räder melden {#0} % des Wegs|base.wheel_radius prüfen (slam-calibrate)
wheel_turn_off|Räder melden {#0} % der Drehung|base.half_track prüfen (slam-calibrate)
wheels_contradict|Räder und Scans bewegen sich verschieden|Schlupf, oder andere Uhr?
scans_repeated|{#0} Scans doppelt|sendet etwas zweimal, hängt das Lidar?
time_backwards|{#0} Scans mit älterem Stempel|Uhr gestellt, oder falsche Reihenfolge?
lidar_mount_off|Lidar und Räder drehen um andere Mitten|{#0.2} m zu lidar.x, {#1.2} m zu lidar.y, oder slam-calibrate
gyro_degrees|Gyro meldet {#0} % der Drehung: Grad statt Radiant?|rad/s senden
gyro_turn_off|Gyro meldet {#0} % der Drehung|Bereich und Einheit im Treiber setzen
gyro_offset|Gyro zeigt {#0.3} rad/s in Ruhe|beim Kalibrieren stillhalten
gyro_far_off|Gyro zeigt {#0.3} rad/s in Ruhe: zu viel|beim Kalibrieren stillhalten, sonst ersetzen
gyro_clipped|Gyro zeigt nie mehr als {#0.3} rad/s|größeren Bereich setzen
gyro_contradicts|Gyro dreht nicht mit|fest montieren, z-Achse nach oben, eine Uhr
moves_with_robot|{#0} Grad um {#1} Grad treffen den Roboter selbst|Lidar frei montieren, oder lidar.mask
no_return_codes|Strahlen immer mit {#0.3} m ({#1} Werte)|Treiber soll 0 senden
ranges_scatter|Weiten streuen {#0.2} m in Ruhe|Fenster putzen, Sonne fernhalten, ersetzen
beam_times_missing|Scans ohne Zeiten der Strahlen|Zeiten senden
stamps_alone|{#0} Messungen weit voraus gestempelt|Uhr des Senders prüfen
wheels_dead|Räder melden Stand, Scans Bewegung|geschoben? sonst Encoderstecker prüfen
base_no_gyro|{0} sendet Räder, aber keine Drehrate|Kabel des Gyros prüfen, oder imu.driver
vesc_no_estimates|Rad {0} (VESC {#0}): STATUS oder STATUS_5 fehlt|VESC Tool: CAN status 1, 4, 5 mit 50 Hz
vesc_not_following|Rad {0} (VESC {#0}) dreht nicht mit|Rad frei machen; VESC Tool: Terminal, faults|slamd hält beide Räder an
vesc_slow|Rad {0}: STATUS_5 nur alle {#0} ms|VESC Tool: CAN status rate 50 Hz
vesc_hot|VESC von Rad {0} hat {#1} Grad|abkühlen lassen, besser kühlen
lidar_delay|Stempel des Lidars um {#0.3} s falsch (Sigma {#1.3} s)|um so viel lidar.time_offset ändern
no_echo|kein Echo: nichts in Reichweite, oder verdeckt|zu Wänden fahren, Abdeckung weg, putzen
echoes_near|nur Echos unter range_min: verdeckt?|frei machen, oder lidar.range_min in m
echoes_far|nur Echos über range_max: Millimeter?|Meter senden, oder lidar.range_max
disk_full|kein Platz auf {0}{2}|Platz machen: slamctl log list
disk_quota|Quota von {0} erschöpft{2}|Platz machen
disk_read_only|{0} ist nur lesbar|dmesg; Platte ersetzen, oder remount,rw
disk_errors|Platte von {0} meldet Fehler: {2}|dmesg; Stecker prüfen, ersetzen
disk_refuses|{2}|sudo chown -R slamd: {0}
disk_in_the_way|{2}|anderes liegt dort: aus {0} wegräumen
disk_gone|{2}: Platte weg?|einstecken und einhängen, oder Ordner {0} anlegen
disk_fails|{2}|Platz machen, oder Ordner schreibbar
disk_hangs|die Platte antwortet nicht|kaputt oder zu langsam? ({#0} s)
map_implausible|die Karte {2}|slamctl reset: neue Karte, die alte bleibt
map_unreadable|{2}|slamctl reset: neue Karte, die alte bleibt
map_to_localise_missing|keine Karte zum Lokalisieren: {2}|hinlegen, oder store.map ändern
map_not_taken|{2}|beheben, oder store.map ändern
map_files_not_saved|{2}|Ordner schreibbar machen, oder output.map ändern
record_not_written|{2}|Platz oder Ordner schaffen, oder output.record ändern
log_not_written|{2}|Platz machen (slamctl log list), oder log.directory
log_no_room|{0}: nur {#0} MB frei, log.floor hält {#1} MB|Platz machen (slamctl log list)
messages_lost|{#0} Nachrichten fehlen: Platte weg oder langsam
messages_starved|{#0} Nachrichten fehlen: Rechner überlastet
no_scans|wartet auf das Lidar
no_source|Räder, Gyro und Lidar schweigen alle|Gemeinsames prüfen: Strom, USB-Hub
no_scan_yet|wartet auf den ersten Scan
few_points|wartet auf mehr: {#0} von {#1} Punkten|Wände müssen in Reichweite sein (lidar.range_max)
lost|keine Pose, bis er in der Karte gefunden ist|langsam fahren, wo er war, oder slamctl set-pose
floors_alike|in einer der Karten {0}, {1}{2}, die sich von hier aus gleichen|langsam weiterfahren, oder die richtige laden
floor_open|vielleicht in einem Lift auf eine andere Etage gefahren|langsam weiterfahren: Karten werden verglichen
not_found_yet|sucht sich in der Karte|langsam weiterfahren, oder slamctl set-pose
no_scan_placed|wartet auf einen Scan, der passt
scans_turn|Scans drehen {#0.1} Grad je Minute gegen das Gyro|zwei Lidars zusammengelegt, Lidar lose, oder sieht es wenig?
no_match|die letzten {#0} Scans passen nicht zur Karte|Lidar verdeckt, oder Ort verändert?
ways_differ|Scans und Räder weichen {#0.2} m ab|geschoben, Schlupf, oder geht jemand mit?
next_scan|wartet auf einen Scan, der passt
wheels_rejected|die Räder widersprechen den Scans
no_local_route|keine Multicast-Route|ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo
no_route|keine Multicast-Route|Netz verbinden, oder ip route add 224.0.0.0/4 dev INTERFACE
link_blocked|Senden verboten: Firewall gegen udp {0}?|udp {0} hinauslassen, IPAddressAllow={1}
link_unheard|Gesendetes kommt nicht zurück: udp {0} gesperrt?|udp {0} hereinlassen; ip route get {1}
no_lcm_socket|kein Socket für udp {0}: belegt?|ss -ulnp 'sport = :{0}'
rival|noch ein Programm sendet SLAM_POSE auf {0}|eines beenden (pgrep -a slamd), oder andere lcm.url
drive_senders|{#0} Programme senden SLAM_DRIVE ({0})|überzählige beenden (ss -uap), oder base.drive_order
socket_too_long|{0}: Pfad zu lang|runtime.socket ändern
socket_is_file|{0}: Datei im Weg|entfernen, oder runtime.socket ändern
socket_taken|{0}: ein anderes Programm horcht dort|beenden, oder runtime.socket ändern
socket_fails|{0}: {1}|runtime.socket ändern
socket_no_folder|{0}: {1}|Ordner {2} anlegen, oder runtime.socket ändern
socket_no_descriptor|{0}: {1}|LimitNOFILE erhöhen
thread_dead|Thread {0} steht: slamd startet neu
graph_dead|Thread {0} hängt: keine Schleifen, kein Speichern|im Stand: sudo systemctl restart slamd
mapper_dead|Thread {0} hängt: die Karte wächst nicht|im Stand: sudo systemctl restart slamd
camera_dead|Thread {0} hängt am Gerät|Kamera neu stecken
thread_late|Thread {0} war {#0} ms zu spät|dmesg
overloaded|Rechner überlastet: Thread {0} wartete {#0.1} s|andere Programme beenden (top)
new_memory_not_locked|neuer Speicher nicht gesperrt: nur {#1} MiB erlaubt|LimitMEMLOCK=infinity
memory_not_locked|Speicher nicht gesperrt: {#0} MiB, erlaubt {#1}|LimitMEMLOCK=infinity
memory_refused|Speicher nicht gesperrt: {0}|LimitMEMLOCK=infinity
no_fifo|kein SCHED_FIFO: {0}|runtime.*_priority auf 1 bis 99
no_fifo_by_limit|kein SCHED_FIFO: Priorität {#0}, erlaubt {#1}|LimitRTPRIO=95
no_fifo_of_group|kein SCHED_FIFO: cpu.rt_runtime_us ist 0|950000 nach {0} schreiben, auch in die Gruppen darüber
no_fifo_by_filter|kein SCHED_FIFO: Filter oder CONFIG_RT_GROUP_SCHED|sysctl -w kernel.sched_rt_runtime_us=-1, im Container --cap-add=SYS_NICE
no_fifo_by_kernel|kein SCHED_FIFO: CONFIG_RT_GROUP_SCHED|sysctl -w kernel.sched_rt_runtime_us=-1
clock_set_ahead|die Uhr wurde {#0} s vorgestellt
clock_set_back|die Uhr wurde {#0} s zurückgestellt|im Stand: sudo systemctl restart slamd
too_many_commands|zu viele Befehle auf einmal
unknown_verb|unbekannter Befehl; bekannt sind {0}
no_mode|der Modus ist slam oder localise
pose_set|Pose gesetzt
pose_absurd|{0}; die Pose bleibt: x und y in Metern, theta in Radiant
saved|gespeichert als {0}
files_saved|gespeichert in {0}.yaml
files_not_saved|nicht gespeichert; das Log nennt den Grund
files_nowhere|output.map ist nicht gesetzt
files_have_place|der Ort ist output.map
files_under_way|eine Karte wird schon gespeichert
loaded|{0} ist geladen; der Roboter wird darin gesucht
floor_loaded|der Roboter wurde in Karte {0} gefunden, sie ist geladen
new_map|eine neue Karte beginnt
localises|lokalisiert in {0}, die bleibt, wie sie ist; der nächste Start nimmt mode aus der Konfiguration
extends|erweitert {0}; der nächste Start nimmt mode aus der Konfiguration
straightened|die Karte ist um {#0.2}° gedreht; ihr Ursprung war bei x {#1.3} m, y {#2.3} m
renamed|Karte {0} heißt jetzt {1}
deleted|Karte {0} ist gelöscht; bis zur nächsten lässt sie sich zurückholen
restored|Karte {0} ist wieder da
not_stored|nicht gespeichert:
map_not_stored|die Karte ist nicht gespeichert:
old_map_not_stored|die vorige ist nicht gespeichert:
straight_not_stored|die Karte bleibt, denn die ausgerichtete ist nicht gespeichert:
disk_silent|die Platte antwortet nicht; später noch einmal
map_busy|ein anderer Befehl zur Karte ist noch nicht fertig
no_store|store.directory ist nicht gesetzt
no_map_name|„{0}“ ist kein Name einer Karte; erlaubt sind Buchstaben, Ziffern, - und _
no_such_map|es gibt keine Karte „{0}“
plan_name|„{0}“ würde für einen Grundriss gehalten
map_exists|es gibt schon eine Karte „{0}“
none_deleted|keine gelöschte Karte ist aufgehoben; nur die letzte ist es
map_open|slamd hat Karte {0} offen; zuerst eine andere laden
map_begins|store.map nennt Karte {0}, mit der slamd beginnt; zuerst eine andere nennen
map_of_others|ein anderes Programm hat Karte {0} offen
mode_already|der Modus ist schon „{0}“
picture_stays|ein Bild einer Karte lässt sich nicht erweitern
no_map_to_localise|keine gespeicherte Karte zum Lokalisieren
map_stays|im Modus „localise“ bleibt die Karte: erst erweitern, dann bearbeiten, dann wieder lokalisieren
no_reset|im Modus „localise“ bleibt die Karte; stattdessen die Pose setzen
map_same|im Modus „localise“ ändert sich die Karte nicht
not_localised|der Roboter ist nicht lokalisiert und ginge in der gedrehten Karte verloren; später noch einmal
few_walls|zu wenige Wände zum Ausrichten; weiterfahren
other_furniture|{0} und {1} haben dieselben Wände, aber nur {#0.1} % der Hindernisse, wo beide waren, sind gleich, nötig sind {#1} %; von den Umrissen der anderen sehen {#2.1} m umgestellt aus, {#3.1} m nicht: ein anderes Stockwerk oder eine Wohnung mit weit umgestellten oder anderen Möbeln|wenn Möbel umgestellt wurden: --moved angeben; von zwei Stockwerken beide Karten behalten|nichts ist gespeichert
no_place|es gibt keinen Ort „{0}“
edit_made|Bearbeitung {#0} ist gemacht
edit_undone|Bearbeitung {#0}: letzter Schritt rückgängig
edit_redone|Bearbeitung {#0}: letzter Schritt wiederholt
edit_removed|Bearbeitung {#0} ist entfernt
stored_in|gespeichert in {0}
not_stored_yet|noch nicht gespeichert: die Platte antwortet nicht
lost_at_end|am Ende verloren: store.directory ist nicht gesetzt
no_edit|es gibt keine Bearbeitung {#0}
no_edit_number|„{0}“ ist keine Nummer einer Bearbeitung
nothing_to_undo|nichts ist mehr rückgängig zu machen
nothing_undone|nichts wurde rückgängig gemacht
most_edits|mehr als {#0} Bearbeitungen hat keine Karte; einige entfernen
no_map_yet|es gibt noch keine Karte
point_far|ein Punkt liegt mehr als {#0} m neben der Karte
robot_lost|der Roboter ginge verloren: die Karte behielte {#0} % dessen, was er um sich sieht; wegfahren, weniger löschen, oder trotzdem löschen
name_missing|ein Raum oder Ort braucht einen Namen
name_long|der Name hat {#0} Bytes, höchstens {#1} sind erlaubt
name_controls|der Name enthält ein Steuerzeichen
author_bad|Urheber: {0}
many_corners|{#0} Ecken, höchstens {#1} sind erlaubt
point_absurd|{0}
place_no_point|ein Ort hat einen Punkt und eine Richtung
place_heading|die Richtung ist kein Winkel in Radiant
place_sigma|das Sigma des Orts ist keine Länge
wall_short|eine Wand braucht zwei Punkte
wall_same|zwei Punkte der Wand sind gleich
few_corners|ein Umriss braucht drei Ecken, es sind {#0}
outline_crosses|der Umriss kreuzt oder berührt sich; Ecke für Ecke der Reihe nach zeichnen
log_not_set|log.directory ist nicht gesetzt
logging|das Log wird geschrieben: {0}
logging_already|das Log wird schon geschrieben: {0}
log_stopped|Log angehalten
log_was_stopped|es lief kein Log
marked|markiert: {0}
not_marked|nicht markiert:
mark_stopped|das Log ist angehalten; slamctl log start, dann noch einmal
mark_empty|noch nichts im Log; gleich noch einmal
mark_no_words|was ist passiert?
web_busy|ein anderer Befehl läuft noch; danach noch einmal
web_silent|slamd antwortet nicht; läuft es, mit lcm.commands = true oder seinem Socket?
web_off|Befehle sind aus; web.commands = true setzen, slam-web neu starten
needs_token|das braucht das Token
wrong_token|das ist nicht das Token (web.token) des Roboters
many_tokens|zu viele falsche Token von hier; in {#0} s noch einmal
press_over|dieser Druck ist vorbei; loslassen und neu drücken
other_drives|eine andere Seite fährt den Roboter
web_ends|slam-web endet
stop_not_sent|Stopp nicht gesendet; slamd hält in einer halben Sekunde selbst an
speed_not_sent|Tempo nicht gesendet; slamctl doctor sucht die Ursache
speeds_off|Fahren ist aus; base.speed_commands = true setzen, neu starten
setup_answered|diese Frage ist schon beantwortet; die Seite zeigt die jetzige
setup_stands|der Roboter wird jetzt nicht gefahren: nur während seine Fahrt aufgezeichnet wird, und wenn du den Joystick gewählt hast`.split("\n").map((row) => row.split("|")).map(([id, ...words]) => [id, words]));
// The same faults of a drive, for which slamd stops the wheels.
for (const id of ["no_frames", "no_heartbeat", "not_armed", "axis_error"])
  window.kGerman[id + "_stops"] = [...window.kGerman[id], "slamd hält beide Räder an, bis beide Antriebe gehorchen und ein neues SLAM_DRIVE kommt"];
