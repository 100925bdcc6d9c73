// SPDX-License-Identifier: BSD-3-Clause
package slamd.spy;

import java.awt.BorderLayout;
import java.awt.Color;
import java.awt.Component;
import java.awt.Dimension;
import java.awt.Font;
import java.awt.GridLayout;
import java.util.List;
import javax.swing.BorderFactory;
import javax.swing.BoxLayout;
import javax.swing.JLabel;
import javax.swing.JPanel;
import javax.swing.JScrollPane;
import javax.swing.JTable;
import javax.swing.table.AbstractTableModel;
import javax.swing.table.DefaultTableCellRenderer;
import slam.health_t;

/** Shows a HealthModel: one sentence, then tables of devices, stages and counters. */
final class HealthPanel extends JPanel {
  private static final Font TEXT = new Font(Font.SANS_SERIF, Font.PLAIN, 14);
  private final HealthModel model;
  private final JLabel summary = new JLabel("waiting for SLAM_HEALTH");
  private final JLabel machine = new JLabel(" ");
  private final Rows devices = new Rows(HealthModel.DEVICE_COLUMNS);
  private final Rows stages = new Rows(HealthModel.STAGE_COLUMNS);
  private final Rows counters = new Rows(HealthModel.COUNTER_COLUMNS);
  private health_t shown;

  HealthPanel(HealthModel model) {
    super(new BorderLayout(8, 8));
    this.model = model;
    setBorder(BorderFactory.createEmptyBorder(10, 10, 10, 10));
    summary.setFont(TEXT.deriveFont(Font.BOLD, 16f));
    machine.setFont(TEXT);
    JPanel head = new JPanel();
    head.setLayout(new BoxLayout(head, BoxLayout.Y_AXIS));
    head.add(summary);
    head.add(machine);
    JPanel lower = new JPanel(new GridLayout(1, 2, 8, 8));
    lower.add(scrolled(stages, 125, 70, 80, 80, 85));
    lower.add(scrolled(counters, 220, 100));
    JScrollPane upper = scrolled(devices, 65, 105, 105, 75, 80, 75, 330);
    upper.setPreferredSize(new Dimension(900, 160));
    JPanel body = new JPanel(new BorderLayout(8, 8));
    body.add(upper, BorderLayout.NORTH);
    body.add(lower, BorderLayout.CENTER);
    add(head, BorderLayout.NORTH);
    add(body, BorderLayout.CENTER);
  }

  /** @param widths [pixels] of the columns, which share the window in this proportion */
  private static JScrollPane scrolled(Rows rows, int... widths) {
    JTable table = new JTable(rows);
    table.setFont(TEXT);
    table.getTableHeader().setFont(TEXT.deriveFont(Font.BOLD, 12f));
    table.setRowHeight(24);
    table.setShowVerticalLines(false);
    table.setDefaultRenderer(Object.class, new Colours(rows));
    for (int i = 0; i < widths.length; ++i) table.getColumnModel().getColumn(i).setPreferredWidth(widths[i]);
    return new JScrollPane(table);
  }

  void refresh() {
    health_t health = model.health();
    if (health == null || health == shown) return;
    shown = health;
    summary.setForeground(States.localisationColour(health.localisation));
    summary.setText(HealthModel.summary(health));
    machine.setText(HealthModel.machine(health));
    devices.show(HealthModel.devices(health));
    stages.show(HealthModel.stages(health));
    counters.show(HealthModel.counters(health));
  }

  private static final class Rows extends AbstractTableModel {
    private final String[] columns;
    private List<HealthModel.Row> rows = List.of();

    Rows(String[] columns) {
      this.columns = columns;
    }

    /** Keeps what is selected where no row came or went. */
    void show(List<HealthModel.Row> newer) {
      boolean same = newer.size() == rows.size();
      rows = newer;
      if (same && !rows.isEmpty()) fireTableRowsUpdated(0, rows.size() - 1);
      else fireTableDataChanged();
    }

    Color colour(int row) {
      return rows.get(row).colour();
    }

    @Override
    public int getRowCount() {
      return rows.size();
    }

    @Override
    public int getColumnCount() {
      return columns.length;
    }

    @Override
    public String getColumnName(int column) {
      return columns[column];
    }

    @Override
    public Object getValueAt(int row, int column) {
      return rows.get(row).cells()[column];
    }
  }

  private static final class Colours extends DefaultTableCellRenderer {
    private final Rows rows;

    Colours(Rows rows) {
      this.rows = rows;
    }

    @Override
    public Component getTableCellRendererComponent(JTable table, Object value, boolean selected, boolean focus, int row,
        int column) {
      super.getTableCellRendererComponent(table, value, selected, focus, row, column);
      if (!selected) setForeground(column == 1 ? rows.colour(row) : Color.BLACK);
      boolean state = rows.getColumnCount() == HealthModel.DEVICE_COLUMNS.length && column == 1;
      setFont(state ? TEXT.deriveFont(Font.BOLD) : TEXT);
      setToolTipText(value.toString());
      return this;
    }
  }
}
