// SPDX-License-Identifier: BSD-3-Clause
package slamd.spy;

import java.awt.Color;
import java.util.ArrayList;
import java.util.List;
import java.util.Locale;
import slam.counter_t;
import slam.device_health_t;
import slam.health_t;
import slam.stage_health_t;

/** The newest health message as rows of words, without a display. */
final class HealthModel {
  record Row(Color colour, String... cells) {}

  static final String[] DEVICE_COLUMNS = {"device", "state", "rate [Hz]", "age [s]", "samples", "rejects", "reason"};
  static final String[] STAGE_COLUMNS = {"stage", "count", "p50 [ms]", "p99 [ms]", "max [ms]"};
  static final String[] COUNTER_COLUMNS = {"counter", "since start"};
  private static final int MAX_ROWS = 256;   // of a table; slamd has a tenth of it
  private static final int MAX_TEXT = 300;   // [characters] of a cell
  private health_t health;

  synchronized void take(health_t message) {
    health = message;
  }

  synchronized health_t health() {
    return health;
  }

  /** One line over the tables. */
  static String summary(health_t h) {
    return States.localisation(h.localisation) + ": " + shortened(h.summary);
  }

  static String machine(health_t h) {
    String disk = h.disk_free_mb < 0 ? "not known" : number("%.0f MB", h.disk_free_mb);
    return number("up %.0f s", h.uptime) + number("   cores in use %.2f", h.cpu) + number("   memory %.0f MB", h.memory_mb)
        + "   disk free " + disk;
  }

  static List<Row> devices(health_t h) {
    List<Row> rows = new ArrayList<>();
    for (device_health_t d : h.devices) {
      if (rows.size() == MAX_ROWS) break;
      String age = d.age < 0 ? "none yet" : number("%.2f", d.age);
      String rate = number("%.1f", d.rate) + " of " + number("%.0f", d.expected);
      rows.add(new Row(States.deviceColour(d.state), shortened(d.name), States.device(d.state), rate, age,
          Long.toString(d.samples), Long.toString(d.rejects), shortened(d.reason)));
    }
    return rows;
  }

  static List<Row> stages(health_t h) {
    List<Row> rows = new ArrayList<>();
    for (stage_health_t s : h.stages) {
      if (rows.size() == MAX_ROWS) break;
      rows.add(new Row(Color.BLACK, shortened(s.name), Long.toString(s.count), number("%.2f", s.p50_us / 1e3),
          number("%.2f", s.p99_us / 1e3), number("%.2f", s.max_us / 1e3)));
    }
    return rows;
  }

  static List<Row> counters(health_t h) {
    List<Row> rows = new ArrayList<>();
    for (counter_t c : h.counters) {
      if (rows.size() == MAX_ROWS) break;
      rows.add(new Row(Color.BLACK, shortened(c.name), Long.toString(c.value)));
    }
    return rows;
  }

  private static String number(String format, double value) {
    return String.format(Locale.ROOT, format, value);
  }

  /** Swing takes a text that begins with "<html>" for a page and would load what it names. */
  static String shortened(String text) {
    String clean = text.replace('<', '(').replace('>', ')').replaceAll("\\p{Cntrl}", " ");
    return clean.length() <= MAX_TEXT ? clean : clean.substring(0, MAX_TEXT) + " ...";
  }
}
