// SPDX-License-Identifier: BSD-3-Clause
package slamd.spy;

import java.awt.BasicStroke;
import java.awt.Color;
import java.awt.Font;
import java.awt.Graphics;
import java.awt.Graphics2D;
import java.awt.RenderingHints;
import java.awt.geom.Path2D;
import java.util.Arrays;
import java.util.Locale;
import javax.swing.JPanel;

/** Draws a PoseModel: a strip for each of x, y and theta with its band of one sigma, and a narrow one of sigma alone. */
final class PosePanel extends JPanel {
  private static final String[] NAMES = {"x", "y", "theta"};
  private static final String[] UNITS = {"m", "m", "\u00b0"};
  private static final double[] LEAST = {0.02, 0.02, 1};  // span of a strip: a standing robot's noise fills none
  private static final Color[] COLOURS = {new Color(0x1565c0), new Color(0x00838f), new Color(0x6a1b9a)};
  private static final Color INK = new Color(0x263238);
  private static final Color GRID = new Color(0xdfe5e8);
  private static final int LEFT = 80, RIGHT = 16, TOP = 34, BOTTOM = 44, GAP = 26;

  private final PoseModel model;

  PosePanel(PoseModel model) {
    this.model = model;
    setBackground(Color.WHITE);
  }

  @Override
  protected void paintComponent(Graphics graphics) {
    super.paintComponent(graphics);
    Graphics2D g = (Graphics2D) graphics.create();
    g.setRenderingHint(RenderingHints.KEY_ANTIALIASING, RenderingHints.VALUE_ANTIALIAS_ON);
    g.setRenderingHint(RenderingHints.KEY_TEXT_ANTIALIASING, RenderingHints.VALUE_TEXT_ANTIALIAS_ON);
    g.setFont(new Font(Font.SANS_SERIF, Font.PLAIN, 14));
    PoseModel.Series series = model.series();
    if (series.size() == 0) {
      g.setColor(INK);
      g.drawString("waiting for a pose", 30, 40);
    } else {
      double strip = (getHeight() - TOP - BOTTOM) / (double) PoseModel.QUANTITIES;
      for (int q = 0; q < PoseModel.QUANTITIES; ++q) drawQuantity(g, series, q, TOP + q * strip, strip - GAP);
      drawStates(g, series);
    }
    g.dispose();
  }

  private void drawQuantity(Graphics2D g, PoseModel.Series s, int q, double top, double height) {
    double[] v = s.values()[q], sigma = s.sigmas()[q];
    int last = s.size() - 1;
    g.setColor(COLOURS[q]);
    g.drawString(String.format(Locale.ROOT, "%s = %.3f %s   sigma %.4f %s", NAMES[q], v[last], UNITS[q], sigma[last],
        UNITS[q]), LEFT, (int) top - 6);
    double low = Double.POSITIVE_INFINITY, high = Double.NEGATIVE_INFINITY;
    for (int i = 0; i <= last; ++i) {
      low = Math.min(low, v[i] - sigma[i]);
      high = Math.max(high, v[i] + sigma[i]);
    }
    double margin = Math.max(0.05 * (high - low), (LEAST[q] - (high - low)) / 2);
    Strip values = new Strip(top, 0.72 * height, low - margin, high + margin);
    Strip sigmas = new Strip(top + 0.78 * height, 0.22 * height, 0, Math.max(1e-9, 1.1 * Arrays.stream(sigma).max().orElse(0)));
    frame(g, values, "%.2f", true);
    frame(g, sigmas, "%.4f", false);
    Color fill = new Color(COLOURS[q].getRed(), COLOURS[q].getGreen(), COLOURS[q].getBlue(), 70);
    double[] under = new double[v.length], over = new double[v.length], zero = new double[v.length];
    for (int i = 0; i <= last; ++i) {
      under[i] = v[i] - sigma[i];
      over[i] = v[i] + sigma[i];
    }
    g.setColor(fill);
    g.fill(band(s, values, under, over));
    g.fill(band(s, sigmas, zero, sigma));
    g.setColor(COLOURS[q]);
    g.setStroke(new BasicStroke(1.4f));
    g.draw(line(s, values, v));
    g.draw(line(s, sigmas, sigma));
  }

  /** A strip of the window and the values at its lower and upper edge. */
  private record Strip(double top, double height, double low, double high) {
    double y(double value) {
      return top + height * (high - value) / (high - low);
    }
  }

  private double x(PoseModel.Series s, int i) {
    long end = s.utimes()[s.size() - 1];
    return LEFT + (getWidth() - LEFT - RIGHT) * (1 - (end - s.utimes()[i]) / (double) PoseModel.SPAN);
  }

  private Path2D line(PoseModel.Series s, Strip strip, double[] values) {
    Path2D path = new Path2D.Double();
    path.moveTo(x(s, 0), strip.y(values[0]));
    for (int i = 1; i < s.size(); ++i) path.lineTo(x(s, i), strip.y(values[i]));
    return path;
  }

  private Path2D band(PoseModel.Series s, Strip strip, double[] under, double[] over) {
    Path2D path = line(s, strip, over);
    for (int i = s.size() - 1; i >= 0; --i) path.lineTo(x(s, i), strip.y(under[i]));
    path.closePath();
    return path;
  }

  private void frame(Graphics2D g, Strip strip, String format, boolean both) {
    int right = getWidth() - RIGHT;
    g.setStroke(new BasicStroke(1));
    g.setColor(GRID);
    for (int part = 0; part <= 2; ++part) {
      int y = (int) (strip.top() + strip.height() * part / 2);
      g.drawLine(LEFT, y, right, y);
    }
    for (int seconds = 0; seconds <= 60; seconds += 10) {
      int x = LEFT + (right - LEFT) * seconds / 60;
      g.drawLine(x, (int) strip.top(), x, (int) (strip.top() + strip.height()));
    }
    g.setColor(INK);
    label(g, String.format(Locale.ROOT, format, strip.high()), strip.top() + 10);
    if (both) label(g, String.format(Locale.ROOT, format, strip.low()), strip.top() + strip.height());
  }

  private static void label(Graphics2D g, String words, double y) {
    g.drawString(words, LEFT - 8 - g.getFontMetrics().stringWidth(words), (int) y);
  }

  private void drawStates(Graphics2D g, PoseModel.Series s) {
    int y = getHeight() - BOTTOM;
    for (int i = 1; i < s.size(); ++i) {
      int from = (int) x(s, i - 1), to = (int) x(s, i);
      g.setColor(States.localisationColour(s.states()[i]));
      g.fillRect(from, y, Math.max(1, to - from), 10);
    }
    byte state = s.states()[s.size() - 1];
    g.setColor(States.localisationColour(state));
    g.drawString(States.localisation(state), LEFT, y + 28);
    g.setColor(INK);
    String axis = "last 60 s";
    g.drawString(axis, getWidth() - RIGHT - g.getFontMetrics().stringWidth(axis), y + 28);
  }
}
