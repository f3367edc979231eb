// The panels beside the panes: values, the verdict, histograms, the line, and how images came to be.
"use strict";

{
  const S = ltsc.state;
  const { el, svg, number } = ltsc;
  const picture = (n) => ltsc.book.images[n];
  let places = {};

  function panel(name, title, open) {
    places[name] = el("div", { class: "panel-body" });
    return el("details", { class: "panel", open }, el("summary", {}, title), places[name]);
  }

  /** The panels, empty. */
  function make() {
    places = {};
    return el("aside", { class: "panels", "aria-label": "Numbers" },
      panel("scale", "Scale", true),
      panel("pixel", "Values of a pixel", true),
      panel("verdict", "Verdict", true),
      panel("histogram", "Histogram", true),
      panel("line", "Along a line", false),
      panel("origin", "How it came to be", false));
  }

  /** The value of the chosen map at a pixel, computed here. */
  ltsc.value_at = (a, b, x, y) => {
    if (S.why_not(a, b)) return null;
    const [p, q] = [ltsc.store.best(a), ltsc.store.best(b)];
    if (!p || !q) return null;
    const at = (of) => {
      const i = 3 * (Math.floor(y / of.factor) * of.width + Math.floor(x / of.factor));
      return of.array.subarray(i, i + 3);
    };
    const [one, other] = [at(p), at(q)];
    if (![...one, ...other].every(Number.isFinite)) return NaN;
    const map = ltsc.maths.PIXEL[S.now.map];
    const slow = ltsc.draw.slow({ a, b });
    if (map) return map(one, other, S.guards(a, b) ?? [-1, -1, -1]);
    if (slow) return slow[y * picture(a).data.width + x];
    return S.now.map === "ssim" ? ssim_at(p, q, x, y, picture(a).data.exposure) : null;
  };

  function ssim_at(p, q, x, y, exposure) {
    if (p.factor !== 1 || q.factor !== 1) return null;
    const [left, top] = [Math.max(x - 2, 0), Math.max(y - 2, 0)];
    const [right, bottom] = [Math.min(x + 3, p.width), Math.min(y + 3, p.height)];
    const [w, h] = [right - left, bottom - top];
    const cut = (of) => {
      const out = new Float32Array(3 * w * h);
      for (let row = 0; row < h; row++) {
        const from = 3 * ((top + row) * of.width + left);
        out.set(of.array.subarray(from, from + 3 * w), 3 * row * w);
      }
      return out;
    };
    return ltsc.maths.whole("ssim", cut(p), cut(q), w, h, exposure)[(y - top) * w + (x - left)];
  }

  /** Values under the pointer, or of the pinned pixel, in all images of the scene that are loaded. */
  function values(hover) {
    const now = S.now;
    const base = S.there(now.b) ? now.b : now.a;
    if (!S.there(base)) return;
    const { width, height } = picture(base).data;
    const at = hover ? [Math.floor(hover[0] * width), Math.floor(hover[1] * height)] : now.pin;
    if (!at || at[0] < 0 || at[1] < 0 || at[0] >= width || at[1] >= height) {
      places.pixel.replaceChildren(el("p", { class: "quiet" }, "Point at a pixel, or press p and move with Alt and the arrows."));
      return;
    }
    const [x, y] = at;
    const scene = ltsc.book.scenes[now.scene];
    const list = [...new Set([now.a, now.b, ...scene.images])].filter((n) => S.there(n) && ltsc.store.best(n));
    const rows = list.map((n) => {
      const of = ltsc.store.best(n);
      const data = picture(n).data;
      const [u, v] = [Math.floor(((x + 0.5) / width) * data.width), Math.floor(((y + 0.5) / height) * data.height)];
      const i = 3 * (Math.floor(v / of.factor) * of.width + Math.floor(u / of.factor));
      const name = `${n === now.a ? "A " : ""}${n === now.b ? "B " : ""}${picture(n).label}`;
      return el("tr", {}, el("th", { scope: "row", title: name }, name), [0, 1, 2].map((c) => el("td", {}, number(of.array[i + c], 4))));
    });
    const value = ltsc.value_at(now.a, now.b, x, y);
    places.pixel.replaceChildren(
      el("p", { class: "where" }, `column ${x}, row ${y}`),
      el("table", { class: "values" },
        el("thead", {}, el("tr", {}, ["image", "R", "G", "B"].map((name) => el("th", { scope: "col" }, name)))),
        el("tbody", {}, rows, value === null ? null : el("tr", { class: "map" }, el("th", { scope: "row" }, now.map), el("td", { colspan: 3 }, number(value, 5))))));
  }

  /** The scale of what is shown. */
  function scale() {
    const now = S.now;
    const map = now.show === "map" || now.layout === "side";
    const bars = [];
    const gradient = (table, flip) => {
      const stops = ltsc.maths.TABLES[table].map((color) => `rgb(${color.map((x) => Math.round(255 * x)).join(",")})`);
      return `linear-gradient(to right, ${(flip ? [...stops].reverse() : stops).join(", ")})`;
    };
    const bar = (title, background, ticks) => {
      const strip = el("div", { class: "strip", role: "img", "aria-label": `${title}: ${ticks.join(", ")}` });
      strip.style.background = background;
      bars.push(el("p", { class: "bar-title" }, title), strip, el("div", { class: "ticks" }, ticks.map((tick) => el("span", {}, tick))));
    };
    if (map) {
      const stops = now.mev ?? S.auto(now.map, now.a, now.b);
      const most = Math.pow(2, -stops);
      const row = ltsc.book.maps.find((one) => one.name === now.map);
      if (now.map === "signed" || now.map === "relative") {
        bar(`${now.map} (red: B dimmer, green: B brighter)`, "linear-gradient(to right, #f00, #bc0000, #000, #00bc00, #0f0)",
          [`−${number(most, 3)}`, `−${number(most / 2, 3)}`, "0", number(most / 2, 3), number(most, 3)]);
      } else if (now.map === "ssim") {
        bar("ssim", gradient("inferno", true), [number(1 - most, 3), number(1 - most / 2, 3), "1"]);
      } else {
        bar(now.map, gradient(now.map.endsWith("flip") ? "magma" : "inferno"), ["0", number(most / 2, 3), number(most, 3)]);
      }
      bars.push(el("p", { class: "quiet" }, row.summary), el("p", { class: "formula" }, row.formula));
    }
    if (now.tone === "false" && now.show !== "map") {
      const [low, high] = S.range(S.there(now.a) ? now.a : now.b);
      const ends = [now.lo ?? low, now.hi ?? high];
      const at = [0, 0.5, 1].map((share) => ends[0] + share * (ends[1] - ends[0]));
      bar(`${now.channel === "rgb" || now.channel === "lum" ? "luminance" : now.channel}${now.log ? ", logarithmic" : ""}`, gradient("viridis"),
        at.map((x) => number(now.log ? Math.pow(2, x) : x, 3)));
    }
    if (bars.length === 0) {
      const most = Math.pow(2, -S.exposure());
      bar("radiance that is shown white", "linear-gradient(to right, #000, #fff)", ["0", number(most, 3)]);
    }
    bars.push(el("p", { class: "quiet" }, el("span", { class: "swatch" }), "blue: infinite or not a number"));
    places.scale.replaceChildren(...bars);
  }

  function verdict() {
    const now = S.now;
    const pair = S.pair(now.a, now.b);
    if (!pair) {
      const why = S.why_not(now.a, now.b);
      places.verdict.replaceChildren(el("p", { class: "quiet" }, why ?? "No evaluation has compared these two; the viewer does."));
      return;
    }
    const channels = pair.channels
      ? el("table", { class: "values" },
        el("thead", {}, el("tr", {}, ["B / A", "ratio", "± standard error"].map((name) => el("th", { scope: "col" }, name)))),
        el("tbody", {}, pair.channels.map(([ratio, error], c) =>
          el("tr", {}, el("th", { scope: "row" }, ["red", "green", "blue"][c]), el("td", {}, ratio === null ? "–" : ratio.toFixed(4)), el("td", {}, error.toFixed(4))))))
      : null;
    const metrics = el("table", { class: "values" },
      el("thead", {}, el("tr", {}, el("th", { scope: "col" }, "metric"), el("th", { scope: "col" }, "value"))),
      el("tbody", {}, pair.metrics.map(([name, value]) => {
        const row = ltsc.book.metrics.find((one) => one.name === name);
        return el("tr", {}, el("th", { scope: "row", title: row ? `${row.summary}: ${row.formula}` : name }, name), el("td", {}, number(value, 5)));
      })));
    places.verdict.replaceChildren(...[
      el("p", {}, ltsc.badge(pair.verdict), " ", pair.proof ?? pair.refused ?? ""),
      pair.worst ? el("p", { class: "quiet" }, `Farthest off for its noise: ${pair.worst.words} (dashed among the tiles).`) : null,
      pair.blame.length > 0 ? el("div", { class: "blame", role: "group", "aria-label": "On what the difference lies" }, pair.blame.map((part, at) =>
        el("button", { type: "button", title: "Show where (b)", "aria-pressed": String(now.blame === at + 1), on: { click: () => S.set({ blame: now.blame === at + 1 ? 0 : at + 1 }) } }, part.words))) : null,
      pair.notes.length > 0 ? el("ul", { class: "notes" }, pair.notes.map((note) => el("li", {}, note))) : null,
      channels,
      pair.tiles ? tile_of(pair) : null,
      pair.metrics.length > 0 ? metrics : null,
    ].filter(Boolean));
  }

  /** The numbers of the tile under the pinned pixel. */
  function tile_of(pair) {
    const { columns, rows, ratios, half, words } = pair.tiles;
    const data = picture(pair.a)?.data;
    const count = (word) => words.filter((one) => one === word).length;
    const sum = words.length > 0 ? `${count("agree")} of ${words.length} tiles agree, ${count("differ")} differ, ${count("undecided")} undecided.` : `${columns} × ${rows} tiles, without verdicts.`;
    const pin = S.now.pin;
    const lines = [el("p", {}, sum, S.now.tiles ? "" : " Press v to see them.")];
    if (pin && data && pin[0] < data.width && pin[1] < data.height) {
      // The tile whose edges, rounded down, hold the pixel.
      const of = (x, size, count) => Math.min(Math.floor(((x + 1) * count - 1) / size), count - 1);
      const [column, row] = [of(pin[0], data.width, columns), of(pin[1], data.height, rows)];
      const at = row * columns + column;
      const interval = half[at] === null || half[at] === undefined ? "" : ` ± ${half[at].toFixed(4)} (95 %)`;
      lines.push(el("p", { class: "where" }, `tile ${column}, ${row}: B / A ${ratios[at] === null ? "–" : ratios[at]?.toFixed(4)}${interval} ${words[at] ?? ""}`));
    }
    return el("div", {}, lines);
  }

  /** How much of A and of B is how bright, in half stops. */
  function histogram() {
    const now = S.now;
    const series = [["A", now.a, "#4f9dff"], ["B", now.b, "#ffb347"]].filter(([, n]) => S.there(n) && ltsc.store.best(n));
    if (series.length === 0) return places.histogram.replaceChildren();
    const channel = { r: 0, g: 1, b: 2 }[now.channel];
    const BINS = 64;
    const [low, high] = [-16, 16];
    const counts = series.map(([, n]) => {
      const of = ltsc.store.best(n);
      const bins = new Float64Array(BINS);
      const stride = 3 * Math.max(1, Math.floor(of.array.length / 3 / 200000));
      let [black, all] = [0, 0];
      for (let i = 0; i + 2 < of.array.length; i += stride) {
        const value = channel === undefined ? ltsc.maths.luminance(of.array, i) : of.array[i + channel];
        if (!Number.isFinite(value)) continue;
        all++;
        if (value > 0) bins[ltsc.clamp(Math.floor(((Math.log2(value) - low) / (high - low)) * BINS), 0, BINS - 1)]++;
        else black++;
      }
      return { bins: bins.map((x) => x / Math.max(all, 1)), black: black / Math.max(all, 1) };
    });
    const used = counts.flatMap(({ bins }) => [...bins].map((x, at) => (x > 0 ? at : -1))).filter((at) => at >= 0);
    const [first, last] = used.length > 0 ? [Math.max(Math.min(...used) - 1, 0), Math.min(Math.max(...used) + 2, BINS)] : [0, BINS];
    const most = Math.max(...counts.flatMap(({ bins }) => [...bins]), 1e-9);
    const [w, h] = [280, 110];
    const x = (at) => ((at - first) / (last - first)) * w;
    const paths = counts.map(({ bins }, side) => {
      const points = [];
      for (let at = first; at < last; at++) points.push(`${x(at)},${h - (bins[at] / most) * h} ${x(at + 1)},${h - (bins[at] / most) * h}`);
      return svg("polyline", { points: `0,${h} ${points.join(" ")} ${w},${h}`, fill: series[side][2], "fill-opacity": 0.18, stroke: series[side][2], "stroke-width": 1.5, "stroke-dasharray": side ? "4 2" : "" });
    });
    const stops = (at) => low + (at / BINS) * (high - low);
    const words = `${channel === undefined ? "luminance" : now.channel}, in powers of 2`;
    places.histogram.replaceChildren(
      svg("svg", { viewBox: `0 0 ${w} ${h}`, class: "chart", role: "img", "aria-label": `Histogram of ${words}` }, paths),
      el("div", { class: "ticks" }, [0, 0.5, 1].map((share) => el("span", {}, number(Math.pow(2, stops(first + share * (last - first))), 2)))),
      el("p", { class: "quiet" }, words, "; ", series.map(([side, , color], at) => {
        const key = el("span", { class: "key" }, `${side}${counts[at].black > 0 ? ` (${(100 * counts[at].black).toFixed(1)} % black) ` : " "}`);
        key.style.setProperty("--key", color);
        return key;
      })));
    return null;
  }

  /** Values of A and B along the line. */
  function line() {
    const now = S.now;
    if (!now.line) {
      places.line.replaceChildren(el("p", { class: "quiet" }, "Drag with Shift held to draw a line, or press l for the row of the inspected pixel."));
      return;
    }
    const [x0, y0, x1, y1] = now.line;
    const count = Math.max(Math.ceil(Math.hypot(x1 - x0, y1 - y0)), 1) + 1;
    const series = [["A", now.a, "#4f9dff"], ["B", now.b, "#ffb347"]].filter(([, n]) => S.there(n) && ltsc.store.best(n));
    const channel = { r: 0, g: 1, b: 2 }[now.channel];
    const lists = series.map(([, n]) => {
      const of = ltsc.store.best(n);
      const data = picture(n).data;
      return Array.from({ length: count }, (_, i) => {
        const [x, y] = [Math.round(x0 + ((x1 - x0) * i) / (count - 1)), Math.round(y0 + ((y1 - y0) * i) / (count - 1))];
        if (x < 0 || y < 0 || x >= data.width || y >= data.height) return NaN;
        const at = 3 * (Math.floor(y / of.factor) * of.width + Math.floor(x / of.factor));
        return channel === undefined ? ltsc.maths.luminance(of.array, at) : of.array[at + channel];
      });
    });
    const known = lists.flat().filter(Number.isFinite);
    const [low, high] = known.length > 0 ? [Math.min(...known, 0), Math.max(...known)] : [0, 1];
    const [w, h] = [280, 130];
    const paths = lists.map((list, side) => {
      const points = list.map((value, i) => [value, (i / Math.max(count - 1, 1)) * w]).filter(([value]) => Number.isFinite(value));
      return svg("polyline", { points: points.map(([value, x]) => `${x.toFixed(1)},${(h - ((value - low) / (high - low || 1)) * h).toFixed(1)}`).join(" "), fill: "none", stroke: series[side][2], "stroke-width": 1.4, "stroke-dasharray": side ? "4 2" : "" });
    });
    const table = () => ["step", ...series.map(([side]) => side)].join(",") + "\n" + Array.from({ length: count }, (_, i) => [i, ...lists.map((list) => list[i])].join(",")).join("\n") + "\n";
    places.line.replaceChildren(
      svg("svg", { viewBox: `0 0 ${w} ${h}`, class: "chart", role: "img", "aria-label": `Values from ${x0}, ${y0} to ${x1}, ${y1}: ${number(low)} to ${number(high)}` }, paths),
      el("div", { class: "ticks" }, [`${x0}, ${y0}`, `${number(low, 3)} to ${number(high, 3)}`, `${x1}, ${y1}`].map((text) => el("span", {}, text))),
      el("p", {}, el("button", { type: "button", on: { click: () => ltsc.download("line.csv", new Blob([table()], { type: "text/csv" })) } }, "Save as CSV"), " ",
        el("button", { type: "button", on: { click: () => S.set({ line: null }) } }, "Remove")));
  }

  /** How A and B came to be, and their files. */
  function origin() {
    const of = (side, n) => {
      if (n === null) return null;
      const one = picture(n);
      const links = [
        one.file && S.there(n) ? el("a", { href: ltsc.path(one.file), download: true }, "EXR file") : null,
        one.log ? el("a", { href: ltsc.path(one.log) }, "log") : null,
      ].filter(Boolean);
      return el("section", {},
        el("h2", {}, `${side}: ${one.label}`),
        links.length > 0 ? el("p", { class: "links" }, links) : null,
        one.why ? el("p", {}, `${one.status}: ${one.why}`) : null,
        one.stated.map((text) => el("p", { class: "stated" }, text)),
        el("dl", {}, one.facts.map(([name, value]) => [el("dt", {}, name), el("dd", {}, value)]),
          one.data ? [el("dt", {}, "pixels"), el("dd", {}, `${one.data.width} × ${one.data.height}, ${8 * one.data.bytes} bits a number${one.data.non_finite ? `, ${one.data.non_finite} not finite` : ""}`)] : null));
    };
    places.origin.replaceChildren(...[of("A", S.now.a), S.now.b === S.now.a ? null : of("B", S.now.b)].filter(Boolean));
  }

  let last = "";
  ltsc.side = {
    make, values,
    /** Brings all panels up to date; what depends on pixels alone is left where nothing has changed. */
    update: (hover) => {
      const now = S.now;
      values(hover);
      const version = [now.a, now.b].map((n) => (S.there(n) ? (ltsc.store.best(n)?.version ?? 0) + 1000 * (ltsc.store.best(n)?.factor ?? 0) : 0));
      const key = JSON.stringify([{ ...now, cx: 0, cy: 0, zoom: 0, split: 0 }, version]);
      if (key === last && places.scale.firstChild) return;
      last = key;
      scale();
      verdict();
      histogram();
      line();
      origin();
    },
  };
}
