// Keys: everything that pointers do. Where JERI has a key for something, it is the same one.
"use strict";

{
  const S = ltsc.state;
  const { el } = ltsc;
  const set = (patch) => S.set(patch);
  const round = (x) => Math.round(2 * x) / 2;

  /** The images of the scene that are there. */
  const images = () => ltsc.book.scenes[S.now.scene].images.filter(S.there);

  function step(list, now, by) {
    const at = list.indexOf(now);
    return list[(Math.max(at, by > 0 ? -1 : 0) + by + list.length) % list.length];
  }

  function exposure(by) {
    if (S.now.show === "map" && S.now.layout !== "side") set({ mev: round(S.now.mev ?? S.auto(S.now.map, S.now.a, S.now.b)) + by });
    else set({ ev: round(S.exposure()) + by });
  }

  function pan(x, y) {
    const pane = ltsc.draw.panes().find((one) => ltsc.draw.lacks(one) === null);
    if (!pane) return;
    const { zoom, w, h, data } = ltsc.draw.place(pane);
    set({ zoom, cx: S.now.cx + (0.1 * x * w) / (zoom * data.width), cy: S.now.cy + (0.1 * y * h) / (zoom * data.height) });
  }

  function inspect(x, y) {
    const data = ltsc.book.images[S.now.b ?? S.now.a]?.data;
    if (!data) return;
    const [u, v] = S.now.pin ?? [Math.floor(S.now.cx * data.width), Math.floor(S.now.cy * data.height)];
    const pin = [ltsc.clamp(u + x, 0, data.width - 1), ltsc.clamp(v + y, 0, data.height - 1)];
    set({ pin });
    const value = ltsc.value_at(S.now.a, S.now.b, pin[0], pin[1]);
    ltsc.tell(`column ${pin[0]}, row ${pin[1]}${value === null ? "" : `, ${S.now.map} ${ltsc.number(value)}`}`);
  }

  function line() {
    const data = ltsc.book.images[S.now.b ?? S.now.a]?.data;
    if (!data) return;
    const row = S.now.pin ? S.now.pin[1] : Math.floor(data.height / 2);
    set({ line: S.now.line ? null : [0, row, data.width - 1, row] });
  }

  const scenes = (by) => {
    const list = ltsc.book.scenes.map((_, at) => at);
    set(S.moved(step(list, S.now.scene, by)));
  };
  const maps = (by) => set({ map: step(ltsc.book.maps.map((map) => map.name), S.now.map, by), mev: null, show: "map" });

  /** Keys by name, with what they do; several keys may do one thing. */
  const KEYS = [
    [["e"], "1/2 stop brighter", () => exposure(0.5)],
    [["E"], "1/2 stop darker", () => exposure(-0.5)],
    [["r"], "everything as at first: exposure, tone, zoom", () => set({ ev: null, mev: null, tone: "srgb", gamma: 2.2, channel: "rgb", lo: null, hi: null, zoom: null, cx: 0.5, cy: 0.5, split: 0.5 })],
    [["t"], "next tone: sRGB, gamma, false color", () => set({ tone: step(["srgb", "gamma", "false"], S.now.tone, 1) })],
    [["k"], "next channel: RGB, red, green, blue, luminance", () => set({ channel: step(["rgb", "r", "g", "b", "lum"], S.now.channel, 1) })],
    [["f"], "the whole image", () => set({ zoom: null, cx: 0.5, cy: 0.5 })],
    [["0"], "a pixel of the image for one of the screen", () => set({ zoom: 1 / (window.devicePixelRatio || 1) })],
    [["-", "_"], "smaller", () => ltsc.zoom(0.5)],
    [["=", "+"], "larger", () => ltsc.zoom(2)],
    [["ArrowLeft"], "move left", () => pan(-1, 0)],
    [["ArrowRight"], "move right", () => pan(1, 0)],
    [["ArrowUp"], "move up", () => pan(0, -1)],
    [["ArrowDown"], "move down", () => pan(0, 1)],
    [["1–9"], "B is the first image of the scene, the second, …", null],
    [["Shift+1–9"], "the same for A", null],
    [["Shift+ArrowLeft"], "previous image as B", () => set({ b: step(images(), S.now.b, -1) })],
    [["Shift+ArrowRight"], "next image as B", () => set({ b: step(images(), S.now.b, 1) })],
    [["Shift+ArrowUp"], "previous scene", () => scenes(-1)],
    [["Shift+ArrowDown"], "next scene", () => scenes(1)],
    [["["], "previous comparison", () => maps(-1)],
    [["]"], "next comparison", () => maps(1)],
    [[" ", "x"], "flip between A and B", () => set({ show: S.now.show === "a" ? "b" : "a", layout: S.now.layout === "split" || S.now.layout === "side" ? "single" : S.now.layout })],
    [["d"], "comparison, and back", () => set({ show: S.now.show === "map" ? "b" : "map" })],
    [["w"], "exchange A and B", () => set({ a: S.now.b, b: S.now.a })],
    [["m"], "next layout: single, side by side, split, grid", () => set({ layout: step(["single", "side", "split", "grid"], S.now.layout, 1) })],
    [["g"], "grid of this scene, of all scenes", () => set({ layout: "grid", over: S.now.layout === "grid" && S.now.over === "scene" ? "all" : "scene" })],
    [[","], "split further left", () => set({ layout: "split", split: S.now.split - 0.02 })],
    [["."], "split further right", () => set({ layout: "split", split: S.now.split + 0.02 })],
    [["v"], "the verdict on tiles", () => set({ tiles: S.now.tiles ? 0 : 1 })],
    [["b"], "where the difference lies: each part that is to blame, and no longer", () => set({ blame: (S.now.blame + 1) % ((S.pair(S.now.a, S.now.b)?.blame.length ?? 0) + 1) })],
    [["p"], "inspect a pixel, and no longer", () => (S.now.pin ? set({ pin: null }) : inspect(0, 0))],
    [["Alt+ArrowLeft"], "inspect the pixel to the left", () => inspect(-1, 0)],
    [["Alt+ArrowRight"], "inspect the pixel to the right", () => inspect(1, 0)],
    [["Alt+ArrowUp"], "inspect the pixel above", () => inspect(0, -1)],
    [["Alt+ArrowDown"], "inspect the pixel below", () => inspect(0, 1)],
    [["l"], "plot along the row of that pixel", line],
    [["s"], "save what is shown as PNG", () => ltsc.save()],
    [["c"], "copy a link to this view", () => ltsc.copy()],
    [["i"], "the index", () => (location.hash = "#index")],
    [["?"], "this sheet", () => ltsc.sheet()],
  ];
  const SHIFTED = "!@#$%^&*(";
  const known = new Map(KEYS.flatMap(([names, , act]) => (act ? names.map((name) => [name, act]) : [])));

  document.addEventListener("keydown", (event) => {
    if (!document.querySelector(".viewer") || event.ctrlKey || event.metaKey) return;
    const field = event.target.closest("input, select, textarea, dialog[open]");
    if (field && !(field.type === "range" && !event.key.startsWith("Arrow"))) return;
    // A focused control keeps what it does itself.
    if (event.target.closest("button, a, summary") && (event.key === " " || event.key === "Enter")) return;
    const arrow = event.key.startsWith("Arrow");
    const name = `${event.altKey && arrow ? "Alt+" : ""}${event.shiftKey && arrow ? "Shift+" : ""}${event.key}`;
    const digit = /^Digit[1-9]$/.test(event.code) ? Number(event.code.slice(5)) : SHIFTED.indexOf(event.key) + 1;
    if (digit > 0 && !event.altKey) {
      const image = ltsc.book.scenes[S.now.scene].images[digit - 1];
      if (!S.there(image ?? null)) return;
      set(event.shiftKey ? { a: image } : { b: image, show: S.now.show === "a" ? "b" : S.now.show });
    } else if (known.has(name)) {
      known.get(name)();
    } else {
      return;
    }
    event.preventDefault();
  });

  const shown = (name) => ({ " ": "space", ArrowLeft: "←", ArrowRight: "→", ArrowUp: "↑", ArrowDown: "↓" })[name] ?? name.replace("ArrowLeft", "←").replace("ArrowRight", "→").replace("ArrowUp", "↑").replace("ArrowDown", "↓");

  /** All keys, in a dialog. */
  ltsc.sheet = () => {
    const close = el("button", { type: "button", on: { click: () => dialog.close() } }, "Close");
    const rows = KEYS.map(([names, words]) => el("div", { class: "key-row" }, el("dt", {}, names.map((name) => el("kbd", {}, shown(name)))), el("dd", {}, words)));
    const dialog = el("dialog", { class: "sheet", "aria-labelledby": "sheet-title" }, el("div", { class: "sheet-head" }, el("h2", { id: "sheet-title" }, "Keys"), close),
      el("dl", {}, rows),
      el("p", { class: "quiet" }, "Drag moves; Shift and drag draws a line; a click pins a pixel; the wheel zooms, in a grid with Control; a double click in a grid opens an image."));
    dialog.addEventListener("close", () => dialog.remove());
    document.body.append(dialog);
    dialog.showModal();
  };
}
