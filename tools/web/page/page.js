// SPDX-License-Identifier: BSD-3-Clause
"use strict";

// ---- what is known of the robot -----------------------------------------------------------------------------------

const kLongestTrail = 8000;  // numbers: x and y in turn [cm]
const kFlash = 3000;         // [ms] that a new loop closure is shown by a growing ring

const robot = {
  session: null, pose: null, scan: [], depth: [], trail: [], closures: [],
  map: { id: null, version: 0, wanted: 0, layers: false, resolution: 0.05, side: 64, tiles: [new Map(), new Map(), new Map()] },
};
robot.problems = [], robot.devices = [];
robot.silent = false;  // what is shown is not of now
robot.locked = false;  // reading needs the token
robot.since = null;    // when the page saw the present state begin
const link = { open: false, heard: performance.now(), silence: 0 };
const view = { x: 0, y: 0, scale: 40, follow: false, moved: false, layer: 0 };  // centre [m], [pixel/m]
const place = { armed: false, from: null, to: null };  // a pose that is being drawn as an arrow [m]
// For tests and curious people.
window.slam = { robot, view, firstTile: null, lag: [] };

const canvas = $("map");
const paint = canvas.getContext("2d");
const ratioOf = () => window.devicePixelRatio || 1;

// ---- tiles --------------------------------------------------------------------------------------------------------

// Colour of each occupancy [percent]; 255 is unknown.
const kColours = new Uint32Array(256);
for (let percent = 0; percent <= 100; percent++) {
  const grey = percent < 50 ? 255 - percent * 0.9 : 210 - (percent - 50) * 3.8;
  const level = Math.max(24, Math.round(grey));
  kColours[percent] = (255 << 24) | ((level + (percent > 50 ? 6 : 0)) << 16) | (level << 8) | level;
}

function beginMap(id) {
  for (const tiles of robot.map.tiles) tiles.clear();
  robot.map.id = id;
  robot.map.version = 0;
  view.moved = view.follow;  // a new map is shown as a whole, unless the robot is followed
}

function takeTiles(buffer) {
  const bytes = new DataView(buffer);
  if (bytes.byteLength < 32 || bytes.getUint32(0, false) !== 0x534c4d54) throw new Error("not a map");
  const id = bytes.getInt32(12, true);
  if (id !== robot.map.id) beginMap(id);
  robot.map.resolution = bytes.getFloat64(16, true);
  const side = robot.map.side = bytes.getInt32(24, true);
  const count = bytes.getInt32(28, true);
  for (let i = 0, at = 32; i < count; i++, at += 12 + side * side) {
    const layer = bytes.getInt32(at, true), column = bytes.getInt32(at + 4, true), row = bytes.getInt32(at + 8, true);
    const cells = new Uint8Array(buffer, at + 12, side * side);
    const key = column + "," + row;
    let tile = robot.map.tiles[layer].get(key);
    if (!tile) {
      const picture = element("canvas");
      picture.width = picture.height = side;
      tile = { column, row, picture };
      robot.map.tiles[layer].set(key, tile);
    }
    const context = tile.picture.getContext("2d");
    const image = context.createImageData(side, side);
    const pixels = new Uint32Array(image.data.buffer);
    tile.left = tile.bottom = side, tile.right = tile.top = 0;  // of its known cells
    for (let r = 0; r < side; r++) {  // the first row of a tile is its lowest
      for (let c = 0; c < side; c++) {
        const percent = cells[r * side + c];
        pixels[(side - 1 - r) * side + c] = kColours[percent];
        if (percent > 100) continue;
        tile.left = Math.min(tile.left, c), tile.right = Math.max(tile.right, c + 1);
        tile.bottom = Math.min(tile.bottom, r), tile.top = Math.max(tile.top, r + 1);
      }
    }
    context.putImageData(image, 0, 0);
  }
  robot.map.version = bytes.getFloat64(4, true);
  if (count > 0 && window.slam.firstTile === null) window.slam.firstTile = performance.now();
  if (!view.moved && !view.follow && robot.map.tiles[0].size > 0) fit();  // also as it grows
  redraw();
}

let fetching = false;
async function fetchTiles() {
  if (fetching || robot.map.wanted <= robot.map.version) return;
  fetching = true;
  try {
    const since = robot.map.version, layers = robot.map.layers;
    const answer = await fetch("/api/v1/map?since=" + since + (layers ? "&layers=1" : ""));
    if (answer.ok) {
      const buffer = await answer.arrayBuffer();
      // Else the map began anew meanwhile, or more of it is wanted.
      if (since === robot.map.version && layers === robot.map.layers) takeTiles(buffer);
    }
  } catch (error) { /* the stream of events breaks, too, and asks again */ }
  fetching = false;
  if (robot.map.wanted > robot.map.version && link.open) setTimeout(fetchTiles, 300);
}

// ---- events -------------------------------------------------------------------------------------------------------

function points(data) {
  const text = atob(data.p), list = new Float32Array(text.length / 2);
  const word = (i) => {
    const value = text.charCodeAt(2 * i) | text.charCodeAt(2 * i + 1) << 8;
    return value > 32767 ? value - 65536 : value;
  };
  for (let i = 0; i < list.length; i += 2) {
    list[i] = (data.x + word(i)) / 100;
    list[i + 1] = (data.y + word(i + 1)) / 100;
  }
  return list;
}

const takers = {
  hello(data) {
    if (robot.session !== null && robot.session !== data.session) beginMap(null);
    robot.session = data.session;
    $("version").textContent = data.version;
    robot.locked = false;
    robot.since = data.since > 0 ? new Date(data.since / 1000) : null;
    $("commands").hidden = $("edit-map").hidden = $("keep").hidden = !data.commands;
    $("drive").hidden = !data.drives;
    $("view").classList.toggle("drives", data.drives);
    limits.speed = data.max_speed;
    limits.turn = data.max_turn_rate;
    link.silence = data.silence;
  },
  trail(data) {
    robot.trail = data.cm;
    robot.closures = data.closures.map((c) => ({ ...c, born: -kFlash }));
  },
  pose(data) {
    if (robot.pose && robot.pose.map !== data.map) robot.trail = [], robot.closures = [], robot.scan = [], robot.depth = [];
    if (robot.pose && robot.pose.state !== data.state) robot.since = new Date(), showDay();
    robot.pose = data;
    link.silence = 0;
    const lag = Date.now() - data.utime / 1000;
    window.slam.lag.push(lag);
    if (window.slam.lag.length > 600) window.slam.lag.shift();
    if (isValid(data)) {
      const x = Math.round(100 * data.x), y = Math.round(100 * data.y), n = robot.trail.length;
      if (n === 0 || Math.hypot(x - robot.trail[n - 2], y - robot.trail[n - 1]) >= 5) robot.trail.push(x, y);
      if (robot.trail.length > kLongestTrail) robot.trail.splice(0, 2);
    }
    showPose();
    redraw();
  },
  scan(data) { robot.scan = points(data); redraw(); },
  depth(data) { robot.depth = points(data); redraw(); },
  closure(data) {
    robot.closures.push({ ...data, born: performance.now() });
    if (robot.closures.length > 100) robot.closures.shift();
    redraw();
  },
  map(data) {
    if (robot.map.id !== data.id) beginMap(data.id);
    robot.map.wanted = data.version;
    robot.meta = data;
    showMap();
    fetchTiles();
  },
  health(data) { showHealth(data); },
  beat(data) { link.silence = data.silence; },
};

function connect() {
  const events = new EventSource("/api/v1/events");
  for (const [name, take] of Object.entries(takers)) {
    events.addEventListener(name, (event) => {
      link.open = true;
      link.heard = performance.now();
      take(JSON.parse(event.data));
    });
  }
  events.onerror = async () => {
    link.open = false;
    letGoOfStick(t("linkLost"));
    if (events.readyState !== EventSource.CLOSED) return;  // the browser tries again by itself
    robot.locked = await needsToken();
    if (!robot.locked) return setTimeout(connect, 2000);
    $("commands").hidden = false;
    showState();
    if (token) unlock(token);  // slam-web was started anew
  };
}

async function needsToken() {
  try { return (await fetch("/api/v1/status")).status === 401; } catch (error) { return false; }
}
