// SPDX-License-Identifier: BSD-3-Clause
package slamd.spy;

/** Pose of a frame in another: [m], [m], [rad]. */
record Pose2(double x, double y, double theta) {
  Pose2 times(Pose2 b) {
    double c = Math.cos(theta), s = Math.sin(theta);
    return new Pose2(x + c * b.x - s * b.y, y + s * b.x + c * b.y, theta + b.theta);
  }

  boolean finite() {
    return Double.isFinite(x) && Double.isFinite(y) && Double.isFinite(theta);
  }

  /** @param text "X,Y,DEGREES" */
  static Pose2 parse(String text) {
    String[] parts = text.split(",", -1);
    if (parts.length != 3) throw new IllegalArgumentException(text);
    Pose2 pose = new Pose2(Double.parseDouble(parts[0]), Double.parseDouble(parts[1]),
        Math.toRadians(Double.parseDouble(parts[2])));
    if (!pose.finite()) throw new IllegalArgumentException(text);
    return pose;
  }
}
