// SPDX-License-Identifier: BSD-3-Clause
package slamd.spy;

import java.awt.AWTError;
import java.awt.GraphicsEnvironment;
import java.awt.HeadlessException;
import java.io.IOException;
import lcm.lcm.LCM;
import lcm.spy.Spy;

/** Starts lcm-spy where there is a display and a network for it; says in one line what is missing where not. */
public final class Main {
  private Main() {}

  /** @param args the LCM URL */
  public static void main(String[] args) {
    try {
      GraphicsEnvironment.getLocalGraphicsEnvironment().getDefaultScreenDevice();
    } catch (AWTError | HeadlessException | NoClassDefFoundError e) {
      fail("display " + System.getenv("DISPLAY") + " cannot be opened; start it on a desktop, or log in with ssh -X");
    }
    try {
      Pose2.parse(System.getProperty("slamd.lidar", "0,0,0"));
      Feed.share(new LCM(args[0]));
    } catch (IOException e) {
      fail("no LCM network at " + args[0] + " (" + e.getMessage()
          + "); check the address, or give it a route: ip route add 224.0.0.0/4 dev IFACE");
    } catch (RuntimeException e) {
      fail("LCM URL or --lidar is not understood (" + e.getMessage() + "); see slam-spy --help");
    }
    Spy.main(new String[] {"--lcm-url=" + args[0]});
  }

  private static void fail(String words) {
    System.err.println("slam-spy: " + words);
    System.exit(1);
  }
}
