// SPDX-License-Identifier: BSD-3-Clause
"use strict";
// Keeps the page itself, so that it opens where the robot is not reached; what it shows is always of the robot.
const kShell = ["/", "/words.js", "/german.js", "/page.js", "/state.js", "/draw.js", "/hands.js", "/maps.js", "/brush.js", "/edit.js", "/tools.js", "/logs.js", "/day.js", "/access.js", "/drive.js", "/commands.js", "/page.css", "/manifest.webmanifest", "/icon.svg"];
const kCache = "slamd";

self.addEventListener("install", (event) => {
  self.skipWaiting();
  event.waitUntil(caches.open(kCache).then((cache) => cache.addAll(kShell)));
});
self.addEventListener("activate", (event) => event.waitUntil(self.clients.claim()));
self.addEventListener("fetch", (event) => {
  const url = new URL(event.request.url);
  if (event.request.method !== "GET" || url.origin !== location.origin || !kShell.includes(url.pathname)) return;
  event.respondWith(fetch(event.request).then(async (answer) => {
    if (answer.ok) await (await caches.open(kCache)).put(url.pathname, answer.clone());
    return answer;
  }).catch(() => caches.match(url.pathname)));
});
