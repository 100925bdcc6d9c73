// SPDX-License-Identifier: BSD-3-Clause
package slamd.spy;

import java.awt.Color;
import java.awt.Component;
import java.awt.Container;
import java.awt.Frame;
import java.awt.Rectangle;
import java.awt.Robot;
import java.awt.event.MouseEvent;
import java.awt.image.BufferedImage;
import java.io.File;
import java.util.ArrayList;
import java.util.List;
import java.util.Set;
import java.util.TreeSet;
import java.util.concurrent.Callable;
import java.util.concurrent.FutureTask;
import java.util.function.IntPredicate;
import javax.imageio.ImageIO;
import javax.swing.JFrame;
import javax.swing.JMenuItem;
import javax.swing.JPopupMenu;
import javax.swing.JTable;
import javax.swing.MenuElement;
import javax.swing.MenuSelectionManager;
import javax.swing.SwingUtilities;

/**
 * Uses slam-spy as a person does: an agent in the real program, so that its launcher is tested as it is. Right button on a
 * channel, an entry of the menu, then what the window shows. Ends the program: 0 when all is so.
 */
public final class SpyDriver {
  private static final long LIMIT = 60_000;  // [ms] for each condition
  private static final Set<String> CHANNELS = Set.of("LASER", "POSE", "SLAM_DEPTH", "SLAM_HEALTH", "SLAM_IMU",
      "SLAM_MAP_META", "SLAM_MAP_TILE", "SLAM_ODOMETRY", "SLAM_POSE", "SLAM_SCAN", "SLAM_WHEELS");

  private SpyDriver() {}

  /** @param folder for screenshots */
  public static void premain(String folder) {
    Thread thread = new Thread(() -> {
      int code = 1;
      try {
        drive();
        code = 0;
      } catch (Exception | AssertionError e) {
        e.printStackTrace();
      }
      try {
        ImageIO.write(new Robot().createScreenCapture(new Rectangle(0, 0, 1600, 1000)), "png", new File(folder, "spy.png"));
      } catch (Exception e) {
        e.printStackTrace();
        code = 1;
      }
      Runtime.getRuntime().halt(code);
    }, "driver");
    thread.setDaemon(true);
    thread.start();
  }

  private static void drive() throws Exception {
    until("the window of lcm-spy", () -> frame("LCM Spy") != null);
    JTable table = find(frame("LCM Spy"), JTable.class).get(0);
    until("the channels " + CHANNELS, () -> channels(table).containsAll(CHANNELS));
    open(table, "SLAM_MAP_TILE", "slamd: map");
    open(table, "SLAM_POSE", "slamd: pose and sigma");
    open(table, "SLAM_HEALTH", "slamd: health");
    edt(() -> {
      frame("LCM Spy").setBounds(0, 0, 760, 340);
      frame("slamd: map").setBounds(0, 350, 760, 650);
      frame("slamd: pose and sigma").setBounds(770, 0, 830, 490);
      frame("slamd: health").setBounds(770, 500, 830, 500);
      for (String name : new String[] {"LCM Spy", "slamd: map", "slamd: pose and sigma", "slamd: health"}) {
        frame(name).validate();
      }
      return null;
    });
    Component map = find(frame("slamd: map"), MapPanel.class).get(0);
    until("free space in the map", () -> pixels(map, SpyDriver::free) > 50_000);
    until("walls in the map", () -> pixels(map, SpyDriver::wall) > 300);
    until("the scan in the map", () -> pixels(map, new Color(0xd81b60)) > 300);
    until("a growing trail in the map", () -> pixels(map, new Color(0x1e88e5)) > 250);
    Component pose = find(frame("slamd: pose and sigma"), PosePanel.class).get(0);
    until("curves of the pose", () -> pixels(pose, new Color(0x1565c0)) > 100);
    until("a pose that is localised", () -> pixels(pose, States.GOOD) > 100);
    HealthPanel health = find(frame("slamd: health"), HealthPanel.class).get(0);
    List<JTable> tables = find(health, JTable.class);
    until("devices that stream", () -> tables.get(0).getRowCount() >= 3 && "streaming".equals(tables.get(0).getValueAt(0, 1)));
    until("stages and counters", () -> tables.get(1).getRowCount() > 2 && tables.get(2).getRowCount() > 2);
    List<String> undecodable = edt(() -> undecodable(table));
    if (!undecodable.isEmpty()) throw new AssertionError("undecodable: " + undecodable);
    System.out.println(channels(table).size() + " channels, 0 undecodable");
  }

  private static void open(JTable table, String channel, String entry) throws Exception {
    edt(() -> {
      int row = 0;
      while (!channel.equals(table.getValueAt(row, 0).toString().trim())) ++row;
      Rectangle cell = table.getCellRect(row, 0, true);
      int[] kinds = {MouseEvent.MOUSE_PRESSED, MouseEvent.MOUSE_RELEASED, MouseEvent.MOUSE_CLICKED};
      for (int kind : kinds) {
        table.dispatchEvent(new MouseEvent(table, kind, System.currentTimeMillis(), MouseEvent.BUTTON3_DOWN_MASK, cell.x + 5,
            cell.y + 5, 1, false, MouseEvent.BUTTON3));
      }
      return null;
    });
    until("the entry " + entry + " of " + channel, () -> {
      for (MenuElement element : MenuSelectionManager.defaultManager().getSelectedPath()) {
        if (!(element instanceof JPopupMenu menu)) continue;
        for (JMenuItem item : find(menu, JMenuItem.class)) {
          if (!entry.equals(item.getText())) continue;
          MenuSelectionManager.defaultManager().clearSelectedPath();
          item.doClick();
          return true;
        }
      }
      return false;
    });
    until("the window " + entry, () -> frame(entry) != null);
  }

  private static Set<String> channels(JTable table) {
    Set<String> names = new TreeSet<>();
    for (int row = 0; row < table.getRowCount(); ++row) names.add(table.getValueAt(row, 0).toString().trim());
    return names;
  }

  private static List<String> undecodable(JTable table) {
    List<String> names = new ArrayList<>();
    for (int row = 0; row < table.getRowCount(); ++row) {
      String type = String.valueOf(table.getValueAt(row, 1));
      String errors = String.valueOf(table.getValueAt(row, table.getColumnCount() - 1)).trim();
      if (!type.trim().matches("\\w+_t") || !errors.equals("0")) names.add(table.getValueAt(row, 0) + ": " + type + " " + errors);
    }
    return names;
  }

  private static JFrame frame(String title) {
    for (Frame f : Frame.getFrames()) {
      if (f instanceof JFrame frame && frame.isVisible() && title.equals(frame.getTitle())) return frame;
    }
    return null;
  }

  private static <T extends Component> List<T> find(Container in, Class<T> kind) {
    List<T> found = new ArrayList<>();
    for (Component c : in.getComponents()) {
      if (kind.isInstance(c)) found.add(kind.cast(c));
      if (c instanceof Container inner) found.addAll(find(inner, kind));
    }
    return found;
  }

  private static boolean free(int rgb) {
    Color c = new Color(rgb);
    return c.getRed() == c.getGreen() && c.getRed() == c.getBlue() && c.getRed() > 0xdc;
  }

  private static boolean wall(int rgb) {
    Color c = new Color(rgb);
    return c.getRed() == c.getGreen() && c.getRed() == c.getBlue() && c.getRed() > 0 && c.getRed() < 0x50;
  }

  private static int pixels(Component panel, Color colour) {
    return pixels(panel, rgb -> (rgb & 0xffffff) == (colour.getRGB() & 0xffffff));
  }

  private static int pixels(Component panel, IntPredicate wanted) {
    BufferedImage image = new BufferedImage(panel.getWidth(), panel.getHeight(), BufferedImage.TYPE_INT_RGB);
    panel.paint(image.createGraphics());
    int n = 0;
    for (int rgb : image.getRGB(0, 0, image.getWidth(), image.getHeight(), null, 0, image.getWidth())) {
      if (wanted.test(rgb)) ++n;
    }
    return n;
  }

  private static <T> T edt(Callable<T> work) throws Exception {
    FutureTask<T> task = new FutureTask<>(work);
    SwingUtilities.invokeLater(task);
    return task.get();
  }

  private static void until(String what, Callable<Boolean> condition) throws Exception {
    long end = System.nanoTime() + 1_000_000 * LIMIT;
    while (!edt(condition)) {
      if (System.nanoTime() > end) throw new AssertionError("did not come in time: " + what);
      Thread.sleep(50);  // between two looks
    }
  }
}
