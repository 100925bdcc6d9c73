// SPDX-License-Identifier: BSD-3-Clause
package slamd.spy;

import java.awt.Color;

/** Words and colours of the states in pose_estimate_t and device_health_t. */
final class States {
  static final Color GOOD = new Color(0x2e7d32);
  static final Color WAITING = new Color(0x1565c0);
  static final Color DOUBTFUL = new Color(0xb26a00);
  static final Color BAD = new Color(0xc62828);
  private static final String[] LOCALISATION = {"initialising", "localised", "degraded", "lost"};
  private static final Color[] LOCALISATION_COLOURS = {WAITING, GOOD, DOUBTFUL, BAD};
  private static final String[] DEVICE = {"absent", "opening", "streaming", "stale", "fault"};
  private static final Color[] DEVICE_COLOURS = {BAD, WAITING, GOOD, DOUBTFUL, BAD};

  private States() {}

  static String localisation(byte state) {
    return known(LOCALISATION, state) ? LOCALISATION[state] : "unknown state " + (state & 0xff);
  }

  static Color localisationColour(byte state) {
    return known(LOCALISATION, state) ? LOCALISATION_COLOURS[state] : BAD;
  }

  static String device(byte state) {
    return known(DEVICE, state) ? DEVICE[state] : "unknown state " + (state & 0xff);
  }

  static Color deviceColour(byte state) {
    return known(DEVICE, state) ? DEVICE_COLOURS[state] : BAD;
  }

  private static boolean known(String[] words, byte state) {
    return state >= 0 && state < words.length;
  }
}
