// SPDX-License-Identifier: BSD-3-Clause
package slamd.spy;

import java.io.DataInput;
import java.io.IOException;
import java.util.ArrayList;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.function.Consumer;
import lcm.lcm.LCM;
import lcm.lcm.LCMDataInputStream;
import lcm.lcm.LCMSubscriber;

/**
 * Subscriptions of one window. A message that does not decode is counted and dropped: whatever the network sends, the
 * thread that receives for all windows goes on.
 */
final class Feed implements LCMSubscriber, AutoCloseable {
  /** As the generated types have it. */
  interface Decoder<T> {
    T decode(DataInput in) throws IOException;
  }

  private interface Handler {
    void take(LCMDataInputStream in) throws IOException;
  }

  private static LCM shared;
  private final LCM lcm;
  private final Map<String, Handler> handlers = new HashMap<>();
  private final List<String> channels = new ArrayList<>();
  private volatile long refused;

  Feed(LCM lcm) {
    this.lcm = lcm;
  }

  /** The bus that Main opened, or lcm's own where plain lcm-spy loaded these classes. */
  static synchronized LCM bus() {
    return shared != null ? shared : LCM.getSingleton();
  }

  static synchronized void share(LCM lcm) {
    shared = lcm;
  }

  /** All before the first message: call it before the window shows. */
  <T> void on(String channel, Decoder<T> decoder, Consumer<T> consumer) {
    handlers.put(channel, in -> consumer.accept(decoder.decode(in)));
    channels.add(channel);
  }

  void open() {
    for (String channel : channels) lcm.subscribe(channel, this);
  }

  @Override
  public void close() {
    for (String channel : channels) lcm.unsubscribe(channel, this);
  }

  long refused() {
    return refused;
  }

  @Override
  public void messageReceived(LCM from, String channel, LCMDataInputStream in) {
    Handler handler = handlers.get(channel);
    if (handler == null) return;
    try {
      handler.take(in);
    } catch (IOException | RuntimeException | OutOfMemoryError e) {
      // The generated types allocate what a message claims to hold before they look for it: too much, or less than none.
      ++refused;
    }
  }
}
