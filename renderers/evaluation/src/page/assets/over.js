// What is drawn over the pixels of a pane: their grid and numbers, the verdict on tiles, the inspected pixel, the line.
"use strict";

{
  const S = ltsc.state;
  const COLORS = { agree: "#37c871", differ: "#ff5d5d", undecided: "#ffc23d" };

  /** CSS pixels of the screen for a place in the image. */
  const to = (at, x, y) => [(x - at.origin[0]) * at.zoom, (y - at.origin[1]) * at.zoom];

  function grid(context, at) {
    const { zoom, w, h, data } = at;
    if (zoom < 10) return;
    const [left, top] = at.origin.map((x) => Math.max(Math.floor(x), 0));
    const right = Math.min(Math.ceil(at.origin[0] + w / zoom), data.width);
    const bottom = Math.min(Math.ceil(at.origin[1] + h / zoom), data.height);
    context.strokeStyle = "rgba(128,128,128,0.45)";
    context.lineWidth = 1 / at.ratio;
    context.beginPath();
    for (let x = left; x <= right; x++) {
      const [u] = to(at, x, 0);
      context.moveTo(u, to(at, 0, top)[1]);
      context.lineTo(u, to(at, 0, bottom)[1]);
    }
    for (let y = top; y <= bottom; y++) {
      const [, v] = to(at, 0, y);
      context.moveTo(to(at, left, 0)[0], v);
      context.lineTo(to(at, right, 0)[0], v);
    }
    context.stroke();
  }

  /** The numbers of pixels that are large enough. */
  function numbers(context, at, pane) {
    if (at.zoom < 56) return;
    const of = ltsc.store.best(pane.b);
    if (!of || of.factor !== 1) return;
    const map = pane.kind === "map";
    context.font = `${Math.min(at.zoom / 5, 14)}px ui-monospace, monospace`;
    context.textAlign = "center";
    context.textBaseline = "middle";
    const [left, top] = at.origin.map((x) => Math.max(Math.floor(x), 0));
    for (let y = top; y < Math.min(top + at.h / at.zoom + 1, at.data.height); y++) {
      for (let x = left; x < Math.min(left + at.w / at.zoom + 1, at.data.width); x++) {
        const [u, v] = to(at, x + 0.5, y + 0.5);
        const values = map ? [ltsc.value_at(pane.a, pane.b, x, y)] : [0, 1, 2].map((c) => of.array[3 * (y * at.data.width + x) + c]);
        values.forEach((value, line) => {
          const text = ltsc.number(value, 3);
          const row = v + (line - (values.length - 1) / 2) * (at.zoom / 4);
          context.strokeStyle = "rgba(0,0,0,0.75)";
          context.lineWidth = 3;
          context.strokeText(text, u, row);
          context.fillStyle = map ? "#fff" : ["#ffb3b3", "#b8ffb8", "#bcd0ff"][line];
          context.fillText(text, u, row);
        });
      }
    }
  }

  /** The verdict on tiles, with a sign in each, and the cell that is to blame. */
  function tiles(context, at, pane) {
    const pair = S.pair(pane.kind === "map" || pane.kind === "split" ? pane.a : S.now.a, pane.b);
    if (!pair || !pair.tiles) return;
    const { columns, rows, words, ratios } = pair.tiles;
    const { width, height } = at.data;
    context.textAlign = "center";
    context.textBaseline = "middle";
    for (let row = 0; row < rows; row++) {
      for (let column = 0; column < columns; column++) {
        const edge = (i, of, size) => Math.floor((i * size) / of);
        const [x, y] = to(at, edge(column, columns, width), edge(row, rows, height));
        const [u, v] = to(at, edge(column + 1, columns, width), edge(row + 1, rows, height));
        const word = words[row * columns + column];
        const color = COLORS[word] || "#cccccc";
        context.strokeStyle = color;
        context.lineWidth = word === "agree" || !word ? 1 : 2;
        context.globalAlpha = word === "agree" || !word ? 0.55 : 1;
        context.strokeRect(x + 1, y + 1, u - x - 2, v - y - 2);
        context.globalAlpha = 1;
        if (u - x < (word === "agree" ? 38 : 16)) continue;
        const ratio = ratios[row * columns + column];
        const size = Math.min((u - x) / 4.2, 15);
        const lines = [ltsc.verdict(word)[1]];
        if (u - x > 46) lines.push(ratio === null || ratio === undefined ? "–" : ratio.toFixed(3));
        lines.forEach((text, line) => {
          context.font = `600 ${line === 0 ? size * 1.15 : size * 0.95}px system-ui, sans-serif`;
          const middle = (y + v) / 2 + (line - (lines.length - 1) / 2) * size * 1.25;
          context.strokeStyle = "rgba(0,0,0,0.8)";
          context.lineWidth = size < 10 ? 2 : 3;
          context.strokeText(text, (x + u) / 2, middle);
          context.fillStyle = color;
          context.fillText(text, (x + u) / 2, middle);
        });
      }
    }
    if (pair.worst) {
      const { grid: cells, at: [column, row] } = pair.worst;
      const edge = (i, size) => Math.floor((i * size) / cells);
      const [x, y] = to(at, edge(column, width), edge(row, height));
      const [u, v] = to(at, edge(column + 1, width), edge(row + 1, height));
      context.strokeStyle = "#ffffff";
      context.lineWidth = 2.5;
      context.setLineDash([7, 5]);
      context.strokeRect(x, y, u - x, v - y);
      context.setLineDash([]);
    }
  }

  const dims = new Map();

  /** All but the pixels on which a part of the difference lies, darkened. */
  function blamed(context, at, pane) {
    const pair = S.pair(pane.kind === "map" || pane.kind === "split" ? pane.a : S.now.a, pane.b);
    const part = pair?.blame[S.now.blame - 1];
    const { width, height } = at.data;
    const groups = part && ltsc.book.scenes.flatMap((scene) => (scene.pairs.includes(pair) ? scene.groups : [])).find((one) => one.width === width && one.height === height);
    const mask = groups && ltsc.store.mask(groups.data);
    if (!mask || mask.length !== width * height) return;
    const key = `${groups.data} ${part.group}`;
    if (!dims.has(key)) {
      const number = groups.names.indexOf(part.group);
      const picture = ltsc.el("canvas", { width, height });
      const own = picture.getContext("2d");
      const data = own.createImageData(width, height);
      for (let i = 0; i < mask.length; i++) data.data[4 * i + 3] = mask[i] === number ? 0 : 205;
      own.putImageData(data, 0, 0);
      dims.set(key, picture);
    }
    context.imageSmoothingEnabled = false;
    const [x, y] = to(at, 0, 0);
    context.drawImage(dims.get(key), x, y, width * at.zoom, height * at.zoom);
  }

  function mark(context, at, x, y, strong) {
    const [u, v] = to(at, x, y);
    const size = Math.max(at.zoom, 5);
    context.lineWidth = 1;
    context.strokeStyle = "#000";
    context.strokeRect(u - 1.5, v - 1.5, size + 3, size + 3);
    context.strokeStyle = strong ? "#ffd166" : "#fff";
    context.strokeRect(u - 0.5, v - 0.5, size + 1, size + 1);
  }

  function line(context, at, [x0, y0, x1, y1]) {
    const [p, q] = [to(at, x0 + 0.5, y0 + 0.5), to(at, x1 + 0.5, y1 + 0.5)];
    for (const [color, width] of [["#000", 4], ["#ffd166", 2]]) {
      context.strokeStyle = color;
      context.lineWidth = width;
      context.beginPath();
      context.moveTo(...p);
      context.lineTo(...q);
      context.stroke();
    }
  }

  /** Draws all of it; `hover` is the pixel under the pointer as shares of width and height. */
  ltsc.over = (pane, context, at, hover) => {
    context.save();
    context.scale(at.ratio, at.ratio);
    if (S.now.blame) blamed(context, at, pane);
    grid(context, at);
    numbers(context, at, pane);
    if (S.now.tiles) tiles(context, at, pane);
    if (S.now.line) line(context, at, S.now.line);
    if (S.now.pin) mark(context, at, S.now.pin[0], S.now.pin[1], true);
    if (hover && ltsc.draw.panes().length > 1) mark(context, at, Math.floor(hover[0] * at.data.width), Math.floor(hover[1] * at.data.height), false);
    if (pane.kind === "split") {
      const x = S.now.split * at.w;
      context.fillStyle = "#000";
      context.fillRect(x - 1.5, 0, 3, at.h);
      context.fillStyle = "#fff";
      context.fillRect(x - 0.5, 0, 1, at.h);
      context.beginPath();
      context.arc(x, at.h / 2, 9, 0, 2 * Math.PI);
      context.fillStyle = "#fff";
      context.fill();
      context.strokeStyle = "#000";
      context.lineWidth = 1;
      context.stroke();
      context.fillStyle = "#000";
      context.font = "11px system-ui";
      context.textAlign = "center";
      context.textBaseline = "middle";
      context.fillText("↔", x, at.h / 2 + 0.5);
    }
    context.restore();
  };
}
