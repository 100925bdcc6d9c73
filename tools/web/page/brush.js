// SPDX-License-Identifier: BSD-3-Clause
"use strict";

// ---- outlines -----------------------------------------------------------------------------------------------------

const kMostCorners = 180;  // of an edit: a command has 4096 bytes

/// A line with fewer points, none of which was farther off than so much (Douglas and Peucker).
function thinned(line, most) {
  const [a, b] = [line[0], line[line.length - 1]], length = Math.hypot(b[0] - a[0], b[1] - a[1]);
  let far = 0, at = 0;
  for (let i = 1; i < line.length - 1; i++) {
    const [x, y] = [line[i][0] - a[0], line[i][1] - a[1]];
    const off = length > 0 ? Math.abs(x * (b[1] - a[1]) - y * (b[0] - a[0])) / length : Math.hypot(x, y);
    if (off > far) far = off, at = i;
  }
  if (far <= most) return line.length > 1 ? [a, b] : [a];
  return thinned(line.slice(0, at + 1), most).slice(0, -1).concat(thinned(line.slice(at), most));
}

function fewCorners(line, most) {
  let few = thinned(line, most);
  while (few.length > kMostCorners) few = thinned(line, most *= 1.5);
  return few;
}

/// What a brush has touched, as cells: 1, and 0 for the others.
function cellsOf(strokes) {
  const touched = strokes.flatMap((stroke) => stroke.path), radius = Math.min(...strokes.map((stroke) => stroke.radius));
  const reach = Math.max(...strokes.map((stroke) => stroke.radius)) + radius;
  const [left, bottom] = [0, 1].map((i) => Math.min(...touched.map((p) => p[i])) - reach);
  const [wide, high] = [0, 1].map((i) => Math.max(...touched.map((p) => p[i])) + reach - [left, bottom][i]);
  const cell = Math.max(radius / 4, wide / 800, high / 800), columns = Math.ceil(wide / cell) + 2, rows = Math.ceil(high / cell) + 2;
  const mask = new Int32Array(columns * rows);
  for (const { path, radius } of strokes) for (let i = 0; i < path.length; i++) {
    const a = path[Math.max(0, i - 1)], b = path[i], steps = Math.ceil(2 * Math.hypot(b[0] - a[0], b[1] - a[1]) / cell) + 1, n = Math.ceil(radius / cell);
    for (let s = 0; s <= steps; s++) {
      const x = (a[0] + (b[0] - a[0]) * s / steps - left) / cell, y = (a[1] + (b[1] - a[1]) * s / steps - bottom) / cell;
      for (let r = -n; r <= n; r++) for (let c = -n; c <= n; c++)
        if (Math.hypot(Math.floor(x) + c + 0.5 - x, Math.floor(y) + r + 0.5 - y) * cell <= radius) mask[(Math.floor(y) + r) * columns + Math.floor(x) + c] = 1;
    }
  }
  for (let again = true; again;) {  // no two cells touch at a corner alone
    again = false;
    for (let i = 0; i < mask.length - columns - 1; i++) {
      const a = mask[i], b = mask[i + 1];
      if (a === b || mask[i + columns] === a || mask[i + columns + 1] === b) continue;
      again = true;
      mask[a ? i + 1 : i] = 1;
    }
  }
  return { mask, columns, left, bottom, cell };
}

/// The same as outlines without holes: the cells are parted into pieces, and each has a border.
function outlinesOf(strokes) {
  const { mask, columns, left, bottom, cell } = cellsOf(strokes), outlines = [];
  let pieces = 1;
  const pieceFrom = (first, within, from, to) => {  // of cells of a piece, between two columns
    const piece = ++pieces, due = [first];
    mask[first] = piece;
    while (due.length > 0) {
      const at = due.pop();
      for (const next of [at - 1, at + 1, at - columns, at + columns]) {
        const column = next % columns;
        if (mask[next] === within && column >= from && column < to) mask[next] = piece, due.push(next);
      }
    }
    outline(piece);
  };
  const split = (piece, column) => {
    for (const [from, to] of [[0, column], [column, columns]])
      for (let i = 0; i < mask.length; i++) if (mask[i] === piece && i % columns >= from && i % columns < to) pieceFrom(i, piece, from, to);
  };
  const outline = (piece) => {  // with the piece on its left
    const start = mask.indexOf(piece), seen = new Set(), corners = [];
    let x = start % columns, y = Math.floor(start / columns), dx = 1, dy = 0;
    const isIn = (ahead, side) => {  // a cell beside the way from this corner; side 1: left
      const column = x + (ahead * dx - side * dy - 1) / 2, row = y + (ahead * dy + side * dx - 1) / 2;
      return mask[row * columns + column] === piece;
    };
    const begin = [x, y].join();
    do {
      corners.push([left + (x + dx / 2) * cell, bottom + (y + dy / 2) * cell]);
      seen.add([x, y, dx].join());
      x += dx, y += dy;
      if (isIn(1, -1)) [dx, dy] = [dy, -dx];
      else if (!isIn(1, 1)) [dx, dy] = [-dy, dx];
    } while ([x, y].join() !== begin);
    for (let i = columns; i < mask.length; i++) {  // an upper or lower edge that is not on it is a hole's
      const r = Math.floor(i / columns), c = i % columns;
      if (mask[i] === piece && mask[i - columns] !== piece && !seen.has([c, r, 1].join())) return split(piece, c + 1);
    }
    outlines.push(fewCorners([...corners, corners[0]], cell / 2).slice(0, -1));
  };
  for (let i = 0; i < mask.length; i++) if (mask[i] === 1) pieceFrom(i, 1, 0, columns);
  return outlines;
}
