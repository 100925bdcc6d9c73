// SPDX-License-Identifier: BSD-3-Clause
package slamd.spy;

import java.awt.Dimension;
import javax.swing.Action;
import javax.swing.JDesktopPane;
import lcm.spy.ChannelData;
import lcm.spy.SpyPlugin;
import slam.map_meta_t;
import slam.map_tile_t;
import slam.pose_estimate_t;
import slam.scan_t;

/** The growing map with robot, scan and trail, on each of their channels. */
public final class MapPlugin implements SpyPlugin {
  @Override
  public boolean canHandle(long fingerprint) {
    return fingerprint == map_meta_t.LCM_FINGERPRINT || fingerprint == map_tile_t.LCM_FINGERPRINT
        || fingerprint == scan_t.LCM_FINGERPRINT || fingerprint == pose_estimate_t.LCM_FINGERPRINT;
  }

  @Override
  public Action getAction(JDesktopPane desktop, ChannelData channel) {
    return ViewWindow.action("slamd: map", desktop, new Dimension(900, 700), 50, () -> {
      MapModel model = new MapModel(Pose2.parse(System.getProperty("slamd.lidar", "0,0,0")));
      Feed feed = new Feed(Feed.bus());
      feed.on("SLAM_MAP_META", map_meta_t::new, model::take);
      feed.on("SLAM_MAP_TILE", map_tile_t::new, model::take);
      feed.on("SLAM_POSE", pose_estimate_t::new, model::take);
      feed.on("SLAM_SCAN", scan_t::new, model::take);
      MapPanel panel = new MapPanel(model);
      return new ViewWindow.View(panel, feed, panel::repaint);
    });
  }
}
