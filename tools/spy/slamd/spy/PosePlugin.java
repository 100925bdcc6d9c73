// SPDX-License-Identifier: BSD-3-Clause
package slamd.spy;

import java.awt.Dimension;
import javax.swing.Action;
import javax.swing.JDesktopPane;
import lcm.spy.ChannelData;
import lcm.spy.SpyPlugin;
import slam.pose_estimate_t;

/** The last minute of the pose with its deviation. */
public final class PosePlugin implements SpyPlugin {
  @Override
  public boolean canHandle(long fingerprint) {
    return fingerprint == pose_estimate_t.LCM_FINGERPRINT;
  }

  @Override
  public Action getAction(JDesktopPane desktop, ChannelData channel) {
    return ViewWindow.action("slamd: pose and sigma", desktop, new Dimension(900, 640), 100, () -> {
      PoseModel model = new PoseModel();
      Feed feed = new Feed(Feed.bus());
      feed.on(channel.name, pose_estimate_t::new, model::take);
      PosePanel panel = new PosePanel(model);
      return new ViewWindow.View(panel, feed, panel::repaint);
    });
  }
}
