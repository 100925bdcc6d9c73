// SPDX-License-Identifier: BSD-3-Clause
package slamd.spy;

import java.awt.Dimension;
import javax.swing.Action;
import javax.swing.JDesktopPane;
import lcm.spy.ChannelData;
import lcm.spy.SpyPlugin;
import slam.health_t;

/** Health in words and colours. */
public final class HealthPlugin implements SpyPlugin {
  @Override
  public boolean canHandle(long fingerprint) {
    return fingerprint == health_t.LCM_FINGERPRINT;
  }

  @Override
  public Action getAction(JDesktopPane desktop, ChannelData channel) {
    return ViewWindow.action("slamd: health", desktop, new Dimension(960, 720), 200, () -> {
      HealthModel model = new HealthModel();
      Feed feed = new Feed(Feed.bus());
      feed.on(channel.name, health_t::new, model::take);
      HealthPanel panel = new HealthPanel(model);
      return new ViewWindow.View(panel, feed, panel::refresh);
    });
  }
}
