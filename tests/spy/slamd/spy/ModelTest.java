// SPDX-License-Identifier: BSD-3-Clause
package slamd.spy;

import java.io.IOException;
import java.util.Random;
import lcm.lcm.LCMDataInputStream;
import lcm.lcm.LCMDataOutputStream;
import lcm.lcm.LCMEncodable;
import slam.device_health_t;
import slam.health_t;
import slam.map_meta_t;
import slam.map_tile_t;
import slam.pose_estimate_t;
import slam.scan_t;

/** The models behind the windows, on any machine: no display. Prints what is not so; exits 1 then. */
public final class ModelTest {
  private static int failures;

  private ModelTest() {}

  private static void check(boolean holds, String what) {
    if (holds) return;
    System.err.println("not so: " + what);
    ++failures;
  }

  public static void main(String[] args) throws IOException {
    mapHoldsOnlyTilesOfItsMap();
    mapRefusesHostileGeometry();
    mapIsBounded();
    trailIsBounded();
    scanIsDrawnFromWhereEachBeamWas();
    poseUnwrapsAndForgets();
    healthHasWords();
    feedOutlivesAnyBytes();
    System.exit(failures == 0 ? 0 : 1);
  }

  private static map_meta_t meta(int id, int side) {
    map_meta_t m = new map_meta_t();
    m.map_id = id;
    m.resolution = 0.05;
    m.origin = new double[] {-1, -2};
    m.tile_side = side;
    m.tiles = 1;
    return m;
  }

  private static map_tile_t tile(int id, int column, int row, int side) {
    map_tile_t t = new map_tile_t();
    t.map_id = id;
    t.column = column;
    t.row = row;
    t.side = side;
    t.ncells = side * side;
    t.cells = new byte[t.ncells];
    return t;
  }

  private static pose_estimate_t pose(long utime, double x, double theta) {
    pose_estimate_t p = new pose_estimate_t();
    p.utime = utime;
    p.x = x;
    p.theta = theta;
    p.covariance = new double[] {1e-4, 0, 0, 0, 4e-4, 0, 0, 0, 1e-6};
    p.state = 1;
    return p;
  }

  private static void mapHoldsOnlyTilesOfItsMap() {
    MapModel model = new MapModel(new Pose2(0, 0, 0));
    model.take(tile(1, 0, 0, 8));
    check(model.tiles().isEmpty(), "a tile before its meta waits for the refresh");
    model.take(meta(1, 8));
    model.take(tile(1, 0, 0, 8));
    model.take(tile(1, 0, 0, 8));
    model.take(tile(1, -3, 2, 8));
    model.take(tile(2, 5, 5, 8));
    check(model.tiles().size() == 2, "two tiles of map 1");
    model.take(meta(2, 8));
    check(model.tiles().isEmpty(), "another map begins empty");
  }

  private static void mapRefusesHostileGeometry() {
    MapModel model = new MapModel(new Pose2(0, 0, 0));
    for (double resolution : new double[] {Double.NaN, 0, -1, Double.POSITIVE_INFINITY, 1e9}) {
      map_meta_t m = meta(1, 8);
      m.resolution = resolution;
      model.take(m);
    }
    model.take(meta(1, 0));
    model.take(meta(1, -8));
    model.take(meta(1, Integer.MAX_VALUE));
    check(model.meta() == null && model.refused() == 8, "each of eight is refused");
    model.take(meta(1, 8));
    map_tile_t wrong = tile(1, 0, 0, 8);
    wrong.cells = new byte[63];
    model.take(wrong);
    model.take(tile(1, 0, 0, 9));
    model.take(tile(1, Integer.MIN_VALUE, 0, 8));
    check(model.tiles().isEmpty() && model.refused() == 11, "tiles that do not fit are refused");
    model.take(pose(1, Double.NaN, 0));
    check(model.pose() == null && model.refused() == 12, "a pose that is no number is refused");
  }

  private static void mapIsBounded() {
    MapModel model = new MapModel(new Pose2(0, 0, 0));
    int side = MapModel.MAX_SIDE, most = (int) (MapModel.MAX_CELLS / ((long) side * side));
    model.take(meta(1, side));
    map_tile_t t = tile(1, 0, 0, side);
    for (t.column = 0; t.column < most + 5; ++t.column) model.take(t);
    check(model.tiles().size() == most && model.full(), "more cells than the limit are not held, and that is said");
  }

  private static void trailIsBounded() {
    MapModel model = new MapModel(new Pose2(0, 0, 0));
    for (int i = 0; i < 3 * MapModel.MAX_TRAIL; ++i) model.take(pose(10_000L * i, 0.06 * i, 0));
    check(model.trail().size() <= MapModel.MAX_TRAIL, "the trail is bounded");
    check(model.trail().get(0).x() == 0, "and keeps its beginning");
  }

  private static void scanIsDrawnFromWhereEachBeamWas() {
    MapModel model = new MapModel(new Pose2(0.1, 0, Math.PI / 2));
    scan_t s = new scan_t();
    s.utime = 1_000_000;
    s.range_min = 0.1f;
    s.range_max = 10;
    s.nbeams = 4;
    s.ranges = new float[] {1, 2, 0, Float.NaN};
    s.bearings = new float[4];
    s.time_offsets = new float[] {0, 0.1f, 0, 0};
    s.intensities = new float[4];
    model.take(s);
    check(model.scan().length == 0, "no scan without a pose");
    for (int i = 0; i <= 20; ++i) model.take(pose(1_000_000 + 10_000L * i, i, 0));
    model.take(s);
    float[] p = model.scan();
    check(p.length == 4, "two hits");
    check(near(p[0], 0.1) && near(p[1], 1), "the first beam from (0, 0)");
    check(near(p[2], 10.1) && near(p[3], 2), "the second from where the base was 0.1 s later");
  }

  private static boolean near(double a, double b) {
    return Math.abs(a - b) < 1e-4;
  }

  private static void poseUnwrapsAndForgets() {
    PoseModel model = new PoseModel();
    model.take(pose(0, 0, Math.toRadians(179)));
    model.take(pose(10_000, 0, Math.toRadians(-179)));
    PoseModel.Series s = model.series();
    check(near(s.values()[2][1], 181), "theta goes on over 180 degrees");
    check(near(s.sigmas()[0][0], 0.01) && near(s.sigmas()[1][0], 0.02) && near(s.sigmas()[2][0], Math.toDegrees(1e-3)),
        "sigma is the root of the diagonal");
    pose_estimate_t bad = pose(20_000, 0, 0);
    bad.covariance[4] = -1;
    model.take(bad);
    check(model.series().size() == 2 && model.refused() == 1, "a negative variance is refused");
    for (int i = 0; i < 3 * PoseModel.CAPACITY; ++i) model.take(pose(20_000 + 10_000L * i, i, 0));
    s = model.series();
    check(s.size() == PoseModel.CAPACITY && s.values()[0][s.size() - 1] == 3 * PoseModel.CAPACITY - 1, "the newest stay");
    model.take(pose(5, 7, 0));
    check(model.series().size() == 1, "a clock that was set back begins anew");
  }

  private static void healthHasWords() {
    health_t h = health();
    h.devices[0].reason = "<html><img src='http://example.org/'>";
    HealthModel.Row row = HealthModel.devices(h).get(0);
    check(row.cells()[1].equals("fault") && row.colour() == States.BAD, "a fault in words and red");
    check(!row.cells()[6].contains("<"), "no text becomes a page");
    check(row.cells()[3].equals("none yet"), "no age before the first sample");
    h.devices[0].state = -1;
    check(HealthModel.devices(h).get(0).cells()[1].equals("unknown state 255"), "a state of the future has words");
    check(HealthModel.summary(h).startsWith("localised: "), "the state begins the sentence");
  }

  private static health_t health() {
    health_t h = new health_t();
    h.localisation = 1;
    h.summary = "all is well";
    h.ndevices = 1;
    h.devices = new device_health_t[] {new device_health_t()};
    h.devices[0].name = "lidar";
    h.devices[0].reason = "";
    h.devices[0].state = 4;
    h.devices[0].age = -1;
    h.stages = new slam.stage_health_t[0];
    h.counters = new slam.counter_t[0];
    return h;
  }

  private static byte[] bytes(LCMEncodable message) throws IOException {
    LCMDataOutputStream out = new LCMDataOutputStream();
    message.encode(out);
    return out.toByteArray();
  }

  /** Every cut of each message, counts of any size, and bytes that are changed at random. */
  private static void feedOutlivesAnyBytes() throws IOException {
    int[] taken = {0};
    Feed feed = new Feed(null);
    feed.on("TILE", map_tile_t::new, t -> ++taken[0]);
    feed.on("HEALTH", health_t::new, h -> ++taken[0]);
    byte[] whole = bytes(tile(1, 0, 0, 8));
    give(feed, "TILE", whole);
    give(feed, "HEALTH", bytes(health()));
    check(taken[0] == 2 && feed.refused() == 0, "whole messages are taken");
    for (int n = 0; n < whole.length; ++n) give(feed, "TILE", java.util.Arrays.copyOf(whole, n));
    check(taken[0] == 2 && feed.refused() == whole.length, "each cut is refused and counted");
    for (int count : new int[] {-1, Integer.MIN_VALUE, Integer.MAX_VALUE}) {
      map_tile_t t = tile(1, 0, 0, 8);
      byte[] b = bytes(t);
      java.nio.ByteBuffer.wrap(b).putInt(32, count);
      give(feed, "TILE", b);
    }
    check(taken[0] == 2 && feed.refused() == whole.length + 3, "counts that cannot be are refused");
    Random random = new Random(1);
    byte[] health = bytes(health());
    for (int i = 0; i < 2000; ++i) {
      byte[] b = health.clone();
      b[8 + random.nextInt(b.length - 8)] = (byte) random.nextInt();
      give(feed, "HEALTH", b);
    }
  }

  private static void give(Feed feed, String channel, byte[] data) {
    feed.messageReceived(null, channel, new LCMDataInputStream(data));
  }
}
