// SPDX-License-Identifier: BSD-3-Clause
package slamd.spy;

import java.awt.Dimension;
import java.awt.Window;
import java.awt.event.ActionEvent;
import java.awt.event.WindowAdapter;
import java.awt.event.WindowEvent;
import javax.swing.AbstractAction;
import javax.swing.Action;
import javax.swing.JComponent;
import javax.swing.JDesktopPane;
import javax.swing.JFrame;
import javax.swing.SwingUtilities;
import javax.swing.Timer;

/** Opens a view in the window that lcm-spy made for a plug-in, and ends its feed with the window. */
final class ViewWindow {
  /** What a plug-in shows: its component, and the feed behind it. */
  record View(JComponent component, Feed feed, Runnable refresh) {}

  interface Maker {
    View make();
  }

  private ViewWindow() {}

  /** lcm-spy asks for an action each time that its menu shows: nothing begins before it is chosen. */
  static Action action(String name, JDesktopPane desktop, Dimension size, int period, Maker maker) {
    return new AbstractAction(name) {
      @Override
      public void actionPerformed(ActionEvent e) {
        show(name, desktop, size, period, maker.make());
      }
    };
  }

  private static void show(String name, JDesktopPane desktop, Dimension size, int period, View view) {
    Window owner = desktop == null ? null : SwingUtilities.getWindowAncestor(desktop);
    JFrame frame = owner instanceof JFrame f ? f : new JFrame();
    Timer timer = new Timer(period, tick -> view.refresh().run());
    frame.setTitle(name);
    frame.setContentPane(view.component());
    frame.setSize(size);
    frame.setDefaultCloseOperation(JFrame.DISPOSE_ON_CLOSE);
    frame.addWindowListener(new WindowAdapter() {
      @Override
      public void windowClosed(WindowEvent e) {
        timer.stop();
        view.feed().close();
      }
    });
    view.feed().open();
    timer.start();
    frame.setVisible(true);
    frame.validate();
  }
}
