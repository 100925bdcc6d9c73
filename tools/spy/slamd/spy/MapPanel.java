// SPDX-License-Identifier: BSD-3-Clause
package slamd.spy;

import java.awt.BasicStroke;
import java.awt.Color;
import java.awt.Font;
import java.awt.Graphics;
import java.awt.Graphics2D;
import java.awt.RenderingHints;
import java.awt.event.MouseAdapter;
import java.awt.event.MouseEvent;
import java.awt.event.MouseWheelEvent;
import java.awt.geom.AffineTransform;
import java.awt.geom.Ellipse2D;
import java.awt.geom.Path2D;
import java.awt.geom.Rectangle2D;
import java.awt.image.BufferedImage;
import java.awt.image.DataBufferByte;
import java.awt.image.IndexColorModel;
import java.awt.image.Raster;
import java.util.Arrays;
import java.util.List;
import java.util.Locale;
import javax.swing.JPanel;
import slam.map_meta_t;
import slam.pose_estimate_t;

/** Draws a MapModel. The wheel zooms, dragging moves, a double click fits the whole map into the window again. */
final class MapPanel extends JPanel {
  private static final Color UNKNOWN = new Color(0xcfd8dc);
  private static final Color SCAN = new Color(0xd81b60);
  private static final Color TRAIL = new Color(0x1e88e5);
  private static final Color INK = new Color(0x263238);
  private static final IndexColorModel PALETTE = palette();
  private static final int BAND = 58;  // [pixels] of the legend above the map
  private static final double ROBOT_RADIUS = 0.18;  // [m] of the sign, not of the robot

  private final MapModel model;
  private double centreX, centreY;        // [m] in the middle of the window
  private double pixels = 60;             // [1/m]
  private boolean fitting = true;

  MapPanel(MapModel model) {
    this.model = model;
    setBackground(UNKNOWN);
    Mouse mouse = new Mouse();
    addMouseListener(mouse);
    addMouseMotionListener(mouse);
    addMouseWheelListener(mouse);
  }

  /** Free is white, occupied nearly black; what no message may hold is as unknown as 255. */
  private static IndexColorModel palette() {
    byte[] red = new byte[256], green = new byte[256], blue = new byte[256];
    Arrays.fill(red, (byte) UNKNOWN.getRed());
    Arrays.fill(green, (byte) UNKNOWN.getGreen());
    Arrays.fill(blue, (byte) UNKNOWN.getBlue());
    for (int percent = 0; percent <= 100; ++percent) {
      byte grey = (byte) (255 - 2.3 * percent);
      red[percent] = green[percent] = blue[percent] = grey;
    }
    return new IndexColorModel(8, 256, red, green, blue);
  }

  @Override
  protected void paintComponent(Graphics graphics) {
    super.paintComponent(graphics);
    Graphics2D g = (Graphics2D) graphics.create();
    g.setRenderingHint(RenderingHints.KEY_ANTIALIASING, RenderingHints.VALUE_ANTIALIAS_ON);
    g.setRenderingHint(RenderingHints.KEY_TEXT_ANTIALIASING, RenderingHints.VALUE_TEXT_ANTIALIAS_ON);
    map_meta_t meta = model.meta();
    if (fitting && meta != null && meta.tiles > 0) fit(meta);
    AffineTransform screen = g.getTransform();
    AffineTransform view = view();
    g.transform(view);
    if (meta != null) drawTiles(g, meta);
    drawTrail(g);
    drawScan(g);
    drawRobot(g);
    g.setTransform(screen);
    drawLegend(g, meta);
    drawScaleBar(g);
    g.dispose();
  }

  /** Metres in map to pixels. */
  private AffineTransform view() {
    AffineTransform t = new AffineTransform();
    t.translate(getWidth() / 2.0, getHeight() / 2.0);
    t.scale(pixels, -pixels);
    t.translate(-centreX, -centreY);
    return t;
  }

  private void fit(map_meta_t meta) {
    double side = meta.tile_side * meta.resolution;
    double width = side * (meta.column_max - (double) meta.column_min + 1);
    double height = side * (meta.row_max - (double) meta.row_min + 1);
    if (!(width > 0 && height > 0)) return;
    centreX = meta.origin[0] + side * meta.column_min + width / 2;
    centreY = meta.origin[1] + side * meta.row_min + height / 2;
    pixels = clampZoom(0.95 * Math.min(getWidth() / width, (getHeight() - BAND) / height));
    centreY += BAND / 2.0 / pixels;
  }

  private static double clampZoom(double pixels) {
    return Math.max(0.05, Math.min(5000, pixels));
  }

  private void drawTiles(Graphics2D g, map_meta_t meta) {
    double side = meta.tile_side * meta.resolution;
    for (MapModel.Tile tile : model.tiles()) {
      double x = meta.origin[0] + side * tile.column(), y = meta.origin[1] + side * tile.row();
      if (g.getClip() != null && !g.getClip().intersects(x, y, side, side)) continue;
      g.drawImage(image(tile, meta.tile_side),
          new AffineTransform(meta.resolution, 0, 0, meta.resolution, x, y), null);
    }
  }

  /** The palette over the cells themselves: no copy. */
  private static BufferedImage image(MapModel.Tile tile, int side) {
    DataBufferByte data = new DataBufferByte(tile.cells(), tile.cells().length);
    return new BufferedImage(PALETTE, Raster.createInterleavedRaster(data, side, side, side, 1, new int[] {0}, null), false,
        null);
  }

  private void drawTrail(Graphics2D g) {
    List<Pose2> trail = model.trail();
    if (trail.isEmpty()) return;
    Path2D path = new Path2D.Double();
    path.moveTo(trail.get(0).x(), trail.get(0).y());
    for (Pose2 p : trail) path.lineTo(p.x(), p.y());
    g.setColor(TRAIL);
    g.setStroke(new BasicStroke((float) (2 / pixels), BasicStroke.CAP_ROUND, BasicStroke.JOIN_ROUND));
    g.draw(path);
  }

  private void drawScan(Graphics2D g) {
    float[] points = model.scan();
    double size = 3 / pixels;
    g.setColor(SCAN);
    for (int i = 0; i + 1 < points.length; i += 2) {
      g.fill(new Rectangle2D.Double(points[i] - size / 2, points[i + 1] - size / 2, size, size));
    }
  }

  private void drawRobot(Graphics2D g) {
    pose_estimate_t pose = model.pose();
    if (pose == null) return;
    double r = Math.max(ROBOT_RADIUS, 7 / pixels);
    Graphics2D robot = (Graphics2D) g.create();
    robot.translate(pose.x, pose.y);
    robot.rotate(pose.theta);
    Color colour = States.localisationColour(pose.state);
    robot.setColor(new Color(colour.getRed(), colour.getGreen(), colour.getBlue(), 90));
    robot.fill(new Ellipse2D.Double(-r, -r, 2 * r, 2 * r));
    Path2D arrow = new Path2D.Double();
    arrow.moveTo(0.95 * r, 0);
    arrow.lineTo(-0.6 * r, 0.6 * r);
    arrow.lineTo(-0.3 * r, 0);
    arrow.lineTo(-0.6 * r, -0.6 * r);
    arrow.closePath();
    robot.setColor(colour);
    robot.fill(arrow);
    robot.dispose();
  }

  private void drawLegend(Graphics2D g, map_meta_t meta) {
    pose_estimate_t pose = model.pose();
    g.setFont(new Font(Font.SANS_SERIF, Font.PLAIN, 14));
    g.setColor(Color.WHITE);
    g.fillRect(0, 0, getWidth(), BAND);
    String robot = pose == null ? "waiting for SLAM_POSE" : "robot, " + States.localisation(pose.state);
    int x = entry(g, 14, pose == null ? States.WAITING : States.localisationColour(pose.state), robot);
    x = entry(g, x, TRAIL, "trail");
    x = entry(g, x, SCAN, "lidar scan");
    x = entry(g, x, Color.BLACK, "occupied");
    x = entry(g, x, new Color(PALETTE.getRGB(0)), "free");
    entry(g, x, UNKNOWN, "unknown");
    String size = "waiting for SLAM_MAP_META";
    if (meta != null) {
      size = model.full() ? "map is larger than this window holds" : String.format(Locale.ROOT,
          "%d tiles, %d keyframes, cells of %.0f mm", model.tiles().size(), meta.keyframes, 1000 * meta.resolution);
    }
    if (pose != null) {
      size += String.format(Locale.ROOT, "     x %.2f m   y %.2f m   theta %.1f\u00b0", pose.x, pose.y,
          Math.toDegrees(pose.theta));
    }
    g.drawString(size, 14, 46);
  }

  /** @return where the next begins */
  private static int entry(Graphics2D g, int x, Color colour, String words) {
    g.setColor(colour);
    g.fillOval(x, 11, 13, 13);
    g.setColor(INK);
    g.setStroke(new BasicStroke(0.5f));
    g.drawOval(x, 11, 13, 13);
    g.drawString(words, x + 20, 22);
    return x + 40 + g.getFontMetrics().stringWidth(words);
  }

  private void drawScaleBar(Graphics2D g) {
    double length = scaleLength(140 / pixels);
    int width = (int) Math.round(length * pixels), x = 20, y = getHeight() - 24;
    g.setColor(new Color(255, 255, 255, 225));
    g.fillRoundRect(10, y - 26, width + 20, 40, 10, 10);
    g.setColor(INK);
    g.setStroke(new BasicStroke(2));
    g.drawLine(x, y, x + width, y);
    g.drawLine(x, y - 5, x, y + 5);
    g.drawLine(x + width, y - 5, x + width, y + 5);
    g.drawString(length < 1 ? Math.round(100 * length) + " cm" : Math.round(length) + " m", x + 6, y - 8);
  }

  /** @return [m] 1, 2 or 5 times a power of ten, the longest up to limit */
  static double scaleLength(double limit) {
    double power = Math.pow(10, Math.floor(Math.log10(limit)));
    double length = limit >= 5 * power ? 5 * power : limit >= 2 * power ? 2 * power : power;
    return Math.max(length, 0.01);
  }

  private final class Mouse extends MouseAdapter {
    private int lastX, lastY;

    @Override
    public void mousePressed(MouseEvent e) {
      lastX = e.getX();
      lastY = e.getY();
    }

    @Override
    public void mouseDragged(MouseEvent e) {
      fitting = false;
      centreX -= (e.getX() - lastX) / pixels;
      centreY += (e.getY() - lastY) / pixels;
      mousePressed(e);
      repaint();
    }

    @Override
    public void mouseClicked(MouseEvent e) {
      if (e.getClickCount() == 2) fitting = true;
    }

    /** What is under the pointer stays there. */
    @Override
    public void mouseWheelMoved(MouseWheelEvent e) {
      fitting = false;
      double right = e.getX() - getWidth() / 2.0, down = e.getY() - getHeight() / 2.0;
      double x = centreX + right / pixels, y = centreY - down / pixels;
      pixels = clampZoom(pixels * Math.pow(1.2, -e.getPreciseWheelRotation()));
      centreX = x - right / pixels;
      centreY = y + down / pixels;
      repaint();
    }
  }
}
