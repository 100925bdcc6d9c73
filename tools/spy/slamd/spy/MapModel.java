// SPDX-License-Identifier: BSD-3-Clause
package slamd.spy;

import java.util.ArrayList;
import java.util.Collection;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import slam.map_meta_t;
import slam.map_tile_t;
import slam.pose_estimate_t;
import slam.scan_t;

/** What the map window shows, without a display. Every message is checked, and nothing grows without bound. */
final class MapModel {
  /** One tile; cells in percent, 255 unknown, row by row from the lower left. */
  record Tile(int column, int row, byte[] cells) {}

  private record Key(int column, int row) {}

  private record Stamped(long utime, Pose2 pose) {}

  static final int MAX_SIDE = 1024;              // [cells]
  static final long MAX_CELLS = 64L << 20;       // one byte each
  static final int MAX_INDEX = 1 << 20;          // [tiles] from the origin
  static final int MAX_TRAIL = 20_000;           // [points]
  static final double TRAIL_STEP = 0.05;         // [m]
  private static final int MAX_BEAMS = 4080;
  private static final int RECENT = 256;         // poses, 2.5 s of them
  private static final double MAX_COORDINATE = 1e6;  // [m]

  private final Pose2 base_lidar;
  private final Map<Key, Tile> tiles = new HashMap<>();
  private final List<Pose2> trail = new ArrayList<>();
  private final Stamped[] recent = new Stamped[RECENT];
  private int poses;
  private double trailStep = TRAIL_STEP;
  private map_meta_t meta;
  private pose_estimate_t pose;
  private float[] scan = {};
  private long refused;
  private boolean full;

  /** @param base_lidar lidar in base: no message has it */
  MapModel(Pose2 base_lidar) {
    this.base_lidar = base_lidar;
  }

  synchronized void take(map_meta_t m) {
    boolean valid = m.resolution >= 1e-3 && m.resolution <= 10 && m.tile_side >= 1 && m.tile_side <= MAX_SIDE
        && Math.abs(m.origin[0]) < MAX_COORDINATE && Math.abs(m.origin[1]) < MAX_COORDINATE;
    if (!valid) {
      ++refused;
      return;
    }
    boolean other = meta == null || m.map_id != meta.map_id || m.resolution != meta.resolution
        || m.tile_side != meta.tile_side || m.origin[0] != meta.origin[0] || m.origin[1] != meta.origin[1];
    if (other) {
      tiles.clear();
      full = false;
      if (meta != null && m.map_id != meta.map_id) trail.clear();
    }
    meta = m;
  }

  /** A tile of another map than the newest meta's waits for the next full refresh. */
  synchronized void take(map_tile_t t) {
    if (meta == null || t.map_id != meta.map_id) return;
    boolean valid = t.side == meta.tile_side && t.cells.length == t.side * t.side && Math.abs((long) t.column) <= MAX_INDEX
        && Math.abs((long) t.row) <= MAX_INDEX;
    if (!valid) {
      ++refused;
      return;
    }
    Key key = new Key(t.column, t.row);
    if (!tiles.containsKey(key) && (tiles.size() + 1L) * t.cells.length > MAX_CELLS) {
      full = true;
      return;
    }
    tiles.put(key, new Tile(t.column, t.row, t.cells));
  }

  synchronized void take(pose_estimate_t p) {
    Pose2 at = new Pose2(p.x, p.y, p.theta);
    if (!at.finite() || Math.abs(p.x) > MAX_COORDINATE || Math.abs(p.y) > MAX_COORDINATE) {
      ++refused;
      return;
    }
    if (pose != null && p.map_id != pose.map_id) {
      trail.clear();
      trailStep = TRAIL_STEP;
      poses = 0;
      scan = new float[0];
    }
    pose = p;
    recent[poses++ % RECENT] = new Stamped(p.utime, at);
    if (poses >= 2 * RECENT) poses -= RECENT;
    extendTrail(at);
  }

  private void extendTrail(Pose2 at) {
    if (!trail.isEmpty()) {
      Pose2 last = trail.get(trail.size() - 1);
      if (Math.hypot(at.x() - last.x(), at.y() - last.y()) < trailStep) return;
    }
    trail.add(at);
    if (trail.size() <= MAX_TRAIL) return;
    List<Pose2> thinned = new ArrayList<>();
    for (int i = 0; i < trail.size(); i += 2) thinned.add(trail.get(i));
    trail.clear();
    trail.addAll(thinned);
    trailStep *= 2;
  }

  /** Each beam is drawn from where the base was when it was measured. */
  synchronized void take(scan_t s) {
    if (s.nbeams > MAX_BEAMS) {
      ++refused;
      return;
    }
    if (poses == 0) return;
    float[] points = new float[2 * s.nbeams];
    int n = 0;
    for (int i = 0; i < s.nbeams; ++i) {
      float range = s.ranges[i];
      boolean hit = range > 0 && range >= s.range_min && range <= s.range_max;
      if (!hit || !Float.isFinite(s.bearings[i]) || !Float.isFinite(s.time_offsets[i])) continue;
      Pose2 lidar = poseAt(s.utime + (long) (1e6 * s.time_offsets[i])).times(base_lidar);
      points[n++] = (float) (lidar.x() + range * Math.cos(lidar.theta() + s.bearings[i]));
      points[n++] = (float) (lidar.y() + range * Math.sin(lidar.theta() + s.bearings[i]));
    }
    scan = java.util.Arrays.copyOf(points, n);
  }

  private Pose2 poseAt(long utime) {
    Stamped best = null;
    for (int i = 0; i < Math.min(poses, RECENT); ++i) {
      Stamped candidate = recent[i];
      if (best == null || Math.abs(candidate.utime - utime) < Math.abs(best.utime - utime)) best = candidate;
    }
    return best.pose;
  }

  synchronized map_meta_t meta() {
    return meta;
  }

  synchronized Collection<Tile> tiles() {
    return new ArrayList<>(tiles.values());
  }

  synchronized List<Pose2> trail() {
    return new ArrayList<>(trail);
  }

  synchronized pose_estimate_t pose() {
    return pose;
  }

  /** x, y, x, y ... in map [m]; never written to again. */
  synchronized float[] scan() {
    return scan;
  }

  synchronized long refused() {
    return refused;
  }

  /** True where the map has more cells than this window holds. */
  synchronized boolean full() {
    return full;
  }
}
