// What the viewer shows: one object, which a link can hold whole. All changes go through `set`.
"use strict";

{
  const DEFAULTS = {
    scene: 0, a: null, b: null, show: "b", layout: "single", over: "scene", map: "signed",
    ev: null, mev: null, tone: "srgb", gamma: 2.2, channel: "rgb", lo: null, hi: null, log: 1,
    zoom: null, cx: 0.5, cy: 0.5, split: 0.5, tiles: 0, blame: 0, line: null, pin: null, cpu: 0,
  };
  const WORDS = {
    show: ["b", "a", "map"],
    layout: ["single", "side", "split", "grid"],
    over: ["scene", "all"],
    tone: ["srgb", "gamma", "false"],
    channel: ["rgb", "r", "g", "b", "lum"],
  };
  const LIMITS = { ev: [-40, 40], mev: [-40, 40], gamma: [0.2, 8], zoom: [1 / 64, 256], cx: [-1, 2], cy: [-1, 2], split: [0, 1], blame: [0, 99] };

  let state = { ...DEFAULTS };
  const listeners = new Set();
  const there = (number) => number !== null && ltsc.book.images[number] && ltsc.book.images[number].data !== null;

  /** The comparison with which a scene is opened: the first one whose images are there. */
  function choice(scene) {
    const of = ltsc.book.scenes[scene];
    const pair = of.pairs.find((one) => there(one.a) && there(one.b));
    if (pair) return { a: pair.a, b: pair.b };
    const images = of.images.filter(there);
    return { a: images[0] ?? null, b: images[1] ?? images[0] ?? null };
  }

  /** An image of another scene that is called as this one; nothing where that has none. */
  function same(number, scene) {
    const label = ltsc.book.images[number]?.label;
    return ltsc.book.scenes[scene].images.find((one) => ltsc.book.images[one].label === label && there(one)) ?? null;
  }

  /** The same choice of images in another scene, as far as it has them. */
  function moved(scene) {
    const first = choice(scene);
    return { scene, a: same(state.a, scene) ?? first.a, b: same(state.b, scene) ?? first.b, line: null, pin: null };
  }

  function set(patch, quiet) {
    const before = state;
    state = { ...state, ...patch };
    for (const [name, [low, high]] of Object.entries(LIMITS)) {
      if (state[name] !== null) state[name] = ltsc.clamp(state[name], low, high);
    }
    if (!quiet) listeners.forEach((tell) => tell(before));
  }

  /** The scene in which an image is. */
  const scene_of = (number) => ltsc.book.scenes.findIndex((scene) => scene.images.includes(number));

  /** An image in a link: its label, with its scene where that is another one. */
  function named(number) {
    if (number === null) return null;
    const label = ltsc.book.images[number].label;
    const scene = scene_of(number);
    return scene === state.scene ? label : JSON.stringify([ltsc.book.scenes[scene].name, label]);
  }

  function found(text, scene) {
    const find = (at, label) => ltsc.book.scenes[at]?.images.find((one) => ltsc.book.images[one].label === label && there(one)) ?? null;
    const own = find(scene, text);
    if (own !== null || !text.startsWith("[")) return own;
    try {
      const [name, label] = JSON.parse(text);
      return find(ltsc.book.scenes.findIndex((one) => one.name === name), label);
    } catch {
      return null;
    }
  }

  /** The view as the part of an address behind `#`. */
  function link() {
    const words = new URLSearchParams();
    words.set("scene", ltsc.book.scenes[state.scene]?.name ?? "");
    for (const side of ["a", "b"]) if (state[side] !== null) words.set(side, named(state[side]));
    for (const [name, value] of Object.entries(state)) {
      if (["scene", "a", "b"].includes(name) || value === DEFAULTS[name] || value === null) continue;
      words.set(name, String(value));
    }
    return `#view?${words}`;
  }

  /** Takes a view from an address; what it says wrongly is left as it is by default. */
  function take(hash) {
    const words = new URLSearchParams(hash.replace(/^#view\??/, ""));
    const scene = Math.max(ltsc.book.scenes.findIndex((one) => one.name === words.get("scene")), 0);
    const first = choice(scene);
    const patch = { ...DEFAULTS, scene, ...first };
    state = { ...state, scene };
    for (const side of ["a", "b"]) if (words.has(side)) patch[side] = found(words.get(side), scene) ?? first[side];
    for (const [name, fallback] of Object.entries(DEFAULTS)) {
      if (!words.has(name) || ["scene", "a", "b"].includes(name)) continue;
      const text = words.get(name);
      if (WORDS[name]) {
        if (WORDS[name].includes(text)) patch[name] = text;
      } else if (name === "map") {
        if (ltsc.book.maps.some((map) => map.name === text)) patch.map = text;
      } else if (name === "line" || name === "pin") {
        const numbers = text.split(",").map(Number);
        if (numbers.every(Number.isFinite) && numbers.length === (name === "line" ? 4 : 2)) patch[name] = numbers;
      } else if (Number.isFinite(Number(text)) && text !== "") {
        patch[name] = Number(text);
      } else {
        patch[name] = fallback;
      }
    }
    set(patch);
  }

  /** The comparison of two images that the results hold, with its scene. */
  function pair(a, b) {
    for (const scene of ltsc.book.scenes) {
      const one = scene.pairs.find((pair) => pair.a === a && pair.b === b);
      if (one) return one;
    }
    return null;
  }

  const comparable = (a, b) => {
    if (!there(a) || !there(b)) return false;
    const [p, q] = [ltsc.book.images[a].data, ltsc.book.images[b].data];
    return p.width === q.width && p.height === q.height;
  };

  /** Why two images cannot be compared, or nothing. */
  function why_not(a, b) {
    if (!there(a) || !there(b)) return "one of the two images is not there";
    if (comparable(a, b)) return null;
    const size = (n) => `${ltsc.book.images[n].data.width} × ${ltsc.book.images[n].data.height}`;
    return `the images differ in size: ${size(a)} and ${size(b)} pixels`;
  }

  // What of the images decides: kept for each pair and form of its images.
  const kept = new Map();
  function once(key, make) {
    if (!kept.has(key)) {
      if (kept.size > 400) kept.clear();
      kept.set(key, make());
    }
    return kept.get(key);
  }

  /** Both images in one form, for what is computed of all their pixels: whole, or both smaller. */
  function forms(a, b) {
    const [p, q] = [a, b].map(ltsc.store.entry);
    if (ltsc.store.complete(p.full) && ltsc.store.complete(q.full)) return [p.full, q.full];
    if (p.pre && q.pre && p.pre.factor === q.pre.factor) return [p.pre, q.pre];
    return null;
  }
  const key_of = (a, b, of) => `${a} ${b} ${of[0].factor} ${of[0].version} ${of[1].version}`;

  const guards = (a, b) => {
    const of = forms(a, b);
    return of ? once(`guards ${key_of(a, b, of)}`, () => ltsc.maths.guards(of[0].array, of[1].array)) : null;
  };

  const BOUNDED = { ssim: 0, flip: 0, "hdr-flip": 0, smape: -1, "smape-fixed": -1 };

  /** Stops at which a map is well seen where none are chosen: its 95th percentile at 0.8, or its whole range where that is bounded. */
  function auto(map, a, b) {
    if (map in BOUNDED) return BOUNDED[map];
    const of = comparable(a, b) ? forms(a, b) : null;
    if (!of) return 0;
    return once(`auto ${map} ${key_of(a, b, of)}`, () => {
      const g = guards(a, b);
      const count = of[0].width * of[0].height;
      const stride = Math.max(1, Math.floor(count / 20000));
      const values = [];
      for (let i = 0; i < count; i += stride) {
        const [p, q] = of.map((one) => one.array.subarray(3 * i, 3 * i + 3));
        values.push(Math.abs(ltsc.maths.PIXEL[map](p, q, g)));
      }
      const bright = ltsc.maths.percentile(values, 0.95) || ltsc.maths.percentile(values, 1);
      return bright > 0 ? Math.round(2 * Math.log2(0.8 / bright)) / 2 : 0;
    });
  }

  /** The range of false colors where none is chosen: from the 1st to the 99.5th percentile of luminance. */
  function range(number) {
    const of = there(number) ? ltsc.store.best(number) : null;
    if (!of) return [-6, 4];
    return once(`range ${number} ${of.factor} ${of.version} ${state.log}`, () => {
      const values = [];
      const stride = 3 * Math.max(1, Math.floor(of.array.length / 60000));
      for (let i = 0; i + 2 < of.array.length; i += stride) values.push(ltsc.maths.luminance(of.array, i));
      const light = state.log ? values.filter((value) => value > 0) : values;
      const ends = [0.01, 0.995].map((share) => ltsc.maths.percentile(light, share) ?? 1);
      const [low, high] = state.log ? ends.map((value) => Math.floor(2 * Math.log2(value)) / 2) : ends;
      return high > low ? [low, high] : [low - 1, low + 1];
    });
  }

  /** Stops at which images are shown: those that are chosen, or of A; of another scene's A where all scenes are seen at once. */
  const exposure = (like) => {
    const a = like ?? state.a;
    return state.ev ?? (there(a) ? ltsc.book.images[a].data.exposure : 0);
  };

  ltsc.state = {
    get now() {
      return state;
    },
    DEFAULTS, set, link, take, choice, moved, there, pair, comparable, why_not, scene_of, forms, guards, auto, range, exposure,
    listen: (tell) => listeners.add(tell),
  };
}
