// SPDX-License-Identifier: BSD-3-Clause
package slamd.spy;

import slam.pose_estimate_t;

/** The last minute of poses with their deviations, without a display. */
final class PoseModel {
  static final int CAPACITY = 6000;            // samples: a minute at 100 Hz
  static final long SPAN = 60_000_000;         // [us]
  static final int QUANTITIES = 3;             // x [m], y [m], theta [degrees]

  /** In order of time; theta unwrapped. */
  record Series(long[] utimes, double[][] values, double[][] sigmas, byte[] states) {
    int size() {
      return utimes.length;
    }
  }

  private final long[] utimes = new long[CAPACITY];
  private final double[][] values = new double[QUANTITIES][CAPACITY];
  private final double[][] sigmas = new double[QUANTITIES][CAPACITY];
  private final byte[] states = new byte[CAPACITY];
  private int begin, size, mapId;
  private long refused;

  synchronized void take(pose_estimate_t p) {
    double[] now = {p.x, p.y, Math.toDegrees(p.theta)};
    double[] deviation = new double[QUANTITIES];
    for (int q = 0; q < QUANTITIES; ++q) {
      deviation[q] = Math.sqrt(p.covariance[4 * q]);
      if (!Double.isFinite(now[q]) || !Double.isFinite(deviation[q])) {
        ++refused;
        return;
      }
    }
    deviation[2] = Math.toDegrees(deviation[2]);
    // A clock that was set back, or a new map: what came before has no place on this axis.
    if (size > 0 && (p.utime < utimes[newest()] || p.map_id != mapId)) size = 0;
    mapId = p.map_id;
    if (size > 0) now[2] += 360 * Math.rint((values[2][newest()] - now[2]) / 360);
    if (size == CAPACITY) {
      begin = (begin + 1) % CAPACITY;
      --size;
    }
    ++size;
    int at = newest();
    utimes[at] = p.utime;
    states[at] = p.state;
    for (int q = 0; q < QUANTITIES; ++q) {
      values[q][at] = now[q];
      sigmas[q][at] = deviation[q];
    }
  }

  private int newest() {
    return (begin + size - 1) % CAPACITY;
  }

  synchronized Series series() {
    int first = 0;
    while (first < size && utimes[newest()] - utimes[(begin + first) % CAPACITY] > SPAN) ++first;
    int n = size - first;
    Series s = new Series(new long[n], new double[QUANTITIES][n], new double[QUANTITIES][n], new byte[n]);
    for (int i = 0; i < n; ++i) {
      int from = (begin + first + i) % CAPACITY;
      s.utimes[i] = utimes[from];
      s.states[i] = states[from];
      for (int q = 0; q < QUANTITIES; ++q) {
        s.values[q][i] = values[q][from];
        s.sigmas[q][i] = sigmas[q][from];
      }
    }
    return s;
  }

  synchronized long refused() {
    return refused;
  }
}
