// The viewer: its controls, and what pointers do on the panes.
"use strict";

{
  const S = ltsc.state;
  const { el } = ltsc;
  let controls = {};
  let hover = null;

  const set = (patch) => S.set(patch);

  /** A row of buttons of which one is pressed. */
  function choose(name, label, list) {
    const buttons = list.map(([value, text, title]) =>
      el("button", { type: "button", title, "data-value": value, on: { click: () => set({ [name]: value }) } }, text));
    controls[name] = () => buttons.forEach((one) => one.setAttribute("aria-pressed", String(String(S.now[name]) === one.dataset.value)));
    return el("div", { class: "choose", role: "group", "aria-label": label }, buttons);
  }

  /** A list of which one is chosen. */
  function select(name, label, options, act, value) {
    const list = el("select", { "aria-label": label, on: { change: () => act(list.value) } });
    controls[name] = () => {
      list.replaceChildren(...options());
      list.value = String(value() ?? "");
    };
    return el("label", { class: "field" }, el("span", {}, label), list);
  }

  /** A number that may be left to the page. */
  function numeric(name, label, step, shown, auto) {
    const input = el("input", { type: "number", step, "aria-label": label, on: { change: () => {
      const value = Number(input.value);
      if (input.value !== "" && Number.isFinite(value)) set({ [name]: value });
    } } });
    const reset = auto ? el("button", { type: "button", class: "auto", title: `${label}: as the page chooses`, on: { click: () => set({ [name]: null }) } }, "auto") : null;
    controls[name] = () => {
      if (document.activeElement !== input) input.value = String(Number(shown().toFixed(3)));
      if (reset) reset.setAttribute("aria-pressed", String(S.now[name] === null));
    };
    return el("label", { class: "field" }, el("span", {}, label), input, reset);
  }

  /** Names of images for a list: those of the scene, then those of others. */
  function images() {
    const option = (n) => {
      const one = ltsc.book.images[n];
      const gone = S.there(n) ? "" : ` (${one.status})`;
      return el("option", { value: n, disabled: !S.there(n) }, `${one.label}${gone}`);
    };
    return ltsc.book.scenes.map((scene, at) => [scene, at]).sort((p, q) => (q[1] === S.now.scene) - (p[1] === S.now.scene)).map(([scene, at]) =>
      at === S.now.scene ? scene.images.map(option) : el("optgroup", { label: scene.name }, scene.images.map(option))).flat();
  }

  const button = (text, title, act, name) => {
    const made = el("button", { type: "button", title, on: { click: act } }, text);
    if (name) controls[name] = () => made.setAttribute("aria-pressed", String(Boolean(S.now[name])));
    return made;
  };

  function bar() {
    const gamma = numeric("gamma", "Gamma", 0.1, () => S.now.gamma, false);
    const [low, high] = [["lo", "From", 0], ["hi", "To", 1]].map(([name, label, side]) =>
      numeric(name, label, 0.5, () => S.now[name] ?? S.range(S.there(S.now.a) ? S.now.a : S.now.b)[side], true));
    const log = button("log", "Logarithmic scale: ends are powers of 2", () => set({ log: S.now.log ? 0 : 1, lo: null, hi: null }), "log");
    const mev = numeric("mev", "Difference", 0.5, () => S.now.mev ?? S.auto(S.now.map, S.now.a, S.now.b), true);
    const split = el("input", { type: "range", min: 0, max: 1, step: 0.005, "aria-label": "Where the split lies", on: { input: () => set({ split: Number(split.value) }) } });
    const divide = el("label", { class: "field" }, el("span", {}, "Split"), split);
    const over = choose("over", "What the grid holds", [["scene", "this scene"], ["all", "all scenes"]]);
    controls.extras = () => {
      const map = S.now.show === "map" || S.now.layout === "side";
      gamma.hidden = S.now.tone !== "gamma";
      low.hidden = high.hidden = log.hidden = S.now.tone !== "false";
      mev.hidden = !map;
      divide.hidden = S.now.layout !== "split";
      over.hidden = S.now.layout !== "grid";
      if (document.activeElement !== split) split.value = String(S.now.split);
    };
    return el("div", { class: "bars" },
      el("div", { class: "bar", role: "toolbar", "aria-label": "What is compared" },
        el("a", { class: "home", href: "#index" }, "← Index"),
        select("scene", "Scene", () => ltsc.book.scenes.map((scene, at) => el("option", { value: at }, scene.name)), (value) => set(S.moved(Number(value))), () => S.now.scene),
        select("a", "A", images, (value) => set({ a: Number(value) }), () => S.now.a),
        select("b", "B", images, (value) => set({ b: Number(value) }), () => S.now.b),
        button("⇄", "Exchange A and B (w)", () => set({ a: S.now.b, b: S.now.a })),
        choose("layout", "Layout", [["single", "Single", "One image; space flips between A and B (1)"], ["side", "Side by side", "A, B and their difference"], ["split", "Split", "A and B with a slider between"], ["grid", "Grid", "All images"]]),
        choose("show", "What is shown", [["a", "A", "The reference (space flips)"], ["b", "B", "The image (space flips)"], ["map", "Difference", "The comparison of A and B, by the map that is chosen (d)"]]),
        over,
        select("map", "by", () => ltsc.book.maps.map((map) => el("option", { value: map.name, title: map.summary }, map.name)), (value) => set({ map: value, mev: null }), () => S.now.map),
        divide,
        button("? Keys", "All keys (?)", () => ltsc.sheet())),
      el("div", { class: "bar", role: "toolbar", "aria-label": "How it is shown" },
        numeric("ev", "Exposure", 0.5, () => S.exposure(), true), mev,
        choose("tone", "Tone", [["srgb", "sRGB", "As a screen shows it (t)"], ["gamma", "Gamma", "A power (t)"], ["false", "False color", "Luminance as colors (t)"]]),
        gamma, low, high, log,
        choose("channel", "Channel", [["rgb", "RGB"], ["r", "R", "red"], ["g", "G", "green"], ["b", "B", "blue"], ["lum", "Y", "luminance"]].map(([v, t, title]) => [v, t, title ?? "all channels"])),
        el("div", { class: "choose", role: "group", "aria-label": "Zoom" },
          button("−", "Smaller (-)", () => ltsc.zoom(0.5)), el("output", { class: "zoom" }), button("+", "Larger (=)", () => ltsc.zoom(2)),
          button("fit", "The whole image (f)", () => set({ zoom: null, cx: 0.5, cy: 0.5 })), button("1:1", "A pixel of the image for one of the screen (0)", () => set({ zoom: 1 / (window.devicePixelRatio || 1) }))),
        button("Tiles", "Tiles with their verdicts (v)", () => set({ tiles: S.now.tiles ? 0 : 1 }), "tiles"),
        el("div", { class: "choose", role: "group", "aria-label": "Keep" },
          button("Save PNG", "What is shown, as a picture (s)", ltsc_save), button("Save PFM", "The numbers of the first pane, in full", save_numbers),
          button("Link", "The address of this view (c)", copy))));
  }

  function title() {
    const { scene, a, b, show, map } = S.now;
    const label = (n) => ltsc.book.images[n]?.label ?? "none";
    const what = show === "map" ? `${map} ${label(b)} against ${label(a)}` : label(show === "a" ? a : b);
    return `${ltsc.book.scenes[scene]?.name ?? "images"} ${what}`;
  }

  function ltsc_save() {
    ltsc.draw.shot().toBlob((blob) => ltsc.download(`${title()}.png`, blob));
  }

  /** The numbers of the first pane as PFM: three of each pixel of an image, one of a comparison. */
  async function save_numbers() {
    try {
      const { width, height, numbers, image } = await ltsc.draw.values(false);
      ltsc.download(`${title()}.pfm`, new Blob([ltsc.pfm(width, height, numbers, image ? 3 : 1)]));
    } catch (error) {
      ltsc.tell(`Nothing to save: ${error.message}`);
    }
  }

  /** A file of floats, rows from the bottom, little end first; what has no number is NaN. */
  ltsc.pfm = (width, height, numbers, channels) => {
    const head = new TextEncoder().encode(`${channels === 3 ? "PF" : "Pf"}\n${width} ${height}\n-1.0\n`);
    const out = new Uint8Array(head.length + 4 * channels * width * height);
    out.set(head);
    const view = new DataView(out.buffer, head.length);
    let at = 0;
    for (let y = height - 1; y >= 0; y--) {
      for (let x = 0; x < width; x++) {
        const i = 4 * (y * width + x);
        for (let c = 0; c < channels; c++, at += 4) view.setFloat32(at, numbers[i + 3] > 0.5 ? numbers[i + c] : NaN, true);
      }
    }
    return out;
  };

  async function copy() {
    const address = location.href.split("#")[0] + S.link();
    try {
      await navigator.clipboard.writeText(address);
      ltsc.tell("The link is copied.");
    } catch {
      ltsc.tell("The link is in the address bar.");
    }
  }
  ltsc.save = ltsc_save;
  ltsc.copy = copy;

  /** Zooms by a factor around a place of a pane, given as shares of the image, or around the middle. */
  ltsc.zoom = (factor, around) => {
    const pane = ltsc.draw.panes().find((one) => ltsc.draw.lacks(one) === null);
    if (!pane) return;
    const { zoom } = ltsc.draw.place(pane);
    const next = ltsc.clamp(zoom * factor, 1 / 64, 256);
    if (!around) return set({ zoom: next });
    const keep = (middle, fixed) => fixed + (middle - fixed) * (zoom / next);
    return set({ zoom: next, cx: keep(S.now.cx, around[0]), cy: keep(S.now.cy, around[1]) });
  };

  /** The pane of an event and the place in its image, as shares and as a pixel. */
  function spot(event) {
    const figure = event.target.closest(".pane");
    const pane = figure && ltsc.draw.panes()[Number(figure.dataset.at)];
    if (!pane || ltsc.draw.lacks(pane) !== null) return null;
    const at = ltsc.draw.place(pane);
    const box = pane.canvas.getBoundingClientRect();
    const [px, py] = [event.clientX - box.left, event.clientY - box.top];
    const [x, y] = [at.origin[0] + px / at.zoom, at.origin[1] + py / at.zoom];
    return { pane, at, px, py, share: [x / at.data.width, y / at.data.height], pixel: [Math.floor(x), Math.floor(y)] };
  }

  function pointers(stage) {
    let drag = null;
    stage.addEventListener("pointerdown", (event) => {
      const here = spot(event);
      if (!here || event.button !== 0) return;
      stage.focus({ preventScroll: true });
      const split = here.pane.kind === "split" && Math.abs(here.px - S.now.split * here.at.w) < 12;
      drag = { kind: split ? "split" : event.shiftKey ? "line" : "pan", from: here, x: event.clientX, y: event.clientY, cx: S.now.cx, cy: S.now.cy, moved: false };
      stage.setPointerCapture(event.pointerId);
      event.preventDefault();
    });
    stage.addEventListener("pointermove", (event) => {
      if (!drag) {
        const here = spot(event);
        hover = here && here.share.every((x) => x >= 0 && x < 1) ? here.share : null;
        ltsc.draw.hover(hover);
        ltsc.side.values(hover);
        return;
      }
      const [dx, dy] = [event.clientX - drag.x, event.clientY - drag.y];
      if (Math.hypot(dx, dy) > 3) drag.moved = true;
      const { at } = drag.from;
      if (drag.kind === "split") set({ split: (drag.from.px + dx) / at.w });
      else if (drag.kind === "line") {
        const end = [Math.floor(drag.from.pixel[0] + dx / at.zoom), Math.floor(drag.from.pixel[1] + dy / at.zoom)];
        set({ line: [...drag.from.pixel, ...end] });
      } else if (drag.moved) {
        set({ cx: drag.cx - dx / (at.zoom * at.data.width), cy: drag.cy - dy / (at.zoom * at.data.height), zoom: S.now.zoom ?? at.zoom });
      }
    });
    const end = () => {
      if (drag && drag.kind === "pan" && !drag.moved) {
        const { pixel, at, pane } = drag.from;
        const inside = pixel[0] >= 0 && pixel[1] >= 0 && pixel[0] < at.data.width && pixel[1] < at.data.height;
        set({ pin: inside ? pixel : null, ...(pane.pick !== undefined ? { b: pane.pick } : {}) });
      }
      drag = null;
    };
    stage.addEventListener("pointerup", end);
    stage.addEventListener("pointercancel", () => (drag = null));
    stage.addEventListener("pointerleave", () => {
      hover = null;
      ltsc.draw.hover(null);
    });
    stage.addEventListener("dblclick", (event) => {
      const here = spot(event);
      if (here && here.pane.at !== undefined) set({ ...S.moved(here.pane.at), layout: "single" });
      else if (here && here.pane.pick !== undefined) set({ b: here.pane.pick, layout: "single" });
    });
    stage.addEventListener("wheel", (event) => {
      const here = spot(event);
      // A grid that is taller than the screen scrolls, and zooms with Control.
      if (!here || (S.now.layout === "grid" && !event.ctrlKey)) return;
      event.preventDefault();
      ltsc.zoom(Math.pow(2, -event.deltaY / 300), here.share);
    }, { passive: false });
  }

  /** Builds the viewer. */
  function build(app) {
    controls = {};
    const stage = el("div", { class: "stage", tabindex: 0, role: "group", "aria-label": "Images. Arrows move, minus and equals zoom, question mark lists all keys." });
    app.replaceChildren(el("main", { id: "main", class: "viewer" }, el("h1", { class: "hidden" }, ltsc.book.title), bar(), el("div", { class: "middle" }, stage, ltsc.side.make())));
    pointers(stage);
    ltsc.draw.on(stage);
    refresh();
  }

  /** Brings controls and panes up to date. */
  function refresh() {
    Object.values(controls).forEach((update) => update());
    ltsc.draw.layout();
    ltsc.draw.ask();
    document.title = `${title()} – ${ltsc.book.title}`;
  }

  ltsc.drawn = () => {
    const pane = ltsc.draw.panes().find((one) => ltsc.draw.lacks(one) === null);
    const output = document.querySelector("output.zoom");
    if (pane && output) output.textContent = `${Number((100 * ltsc.draw.place(pane).zoom).toPrecision(3))} %`;
    ltsc.side.update(hover);
    for (const one of ["mev", "lo", "hi", "ev"]) controls[one]?.();
  };

  ltsc.viewer = { build, refresh };
}
