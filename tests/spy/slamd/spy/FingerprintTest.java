// SPDX-License-Identifier: BSD-3-Clause
package slamd.spy;

import java.io.BufferedReader;
import java.io.IOException;
import java.io.InputStreamReader;
import java.util.ArrayList;
import java.util.List;
import java.util.jar.JarEntry;
import java.util.jar.JarFile;

/** The jar's types are those of the daemon: reads "package.type fingerprint" from stdin, as fingerprints.cpp prints. */
public final class FingerprintTest {
  private FingerprintTest() {}

  /** @param args the jar of types */
  public static void main(String[] args) throws IOException, ReflectiveOperationException {
    List<String> cpp = new ArrayList<>();
    BufferedReader in = new BufferedReader(new InputStreamReader(System.in));
    for (String line = in.readLine(); line != null; line = in.readLine()) cpp.add(line);
    List<String> java = new ArrayList<>();
    try (JarFile jar = new JarFile(args[0])) {
      for (JarEntry entry : (Iterable<JarEntry>) jar.stream()::iterator) {
        if (!entry.getName().endsWith(".class")) continue;
        String name = entry.getName().replace('/', '.').replace(".class", "");
        long fingerprint = Class.forName(name).getField("LCM_FINGERPRINT").getLong(null);
        java.add(String.format("%s %016x", name, fingerprint));
      }
    }
    cpp.sort(null);
    java.sort(null);
    if (!cpp.isEmpty() && cpp.equals(java)) return;
    System.err.println("C++:  " + cpp + "\nJava: " + java);
    System.exit(1);
  }
}
