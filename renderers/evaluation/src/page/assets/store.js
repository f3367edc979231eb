// Pixels, loaded where they are looked at: a script beside the page brings a part of an image as deflated planes of bytes. First comes a
// smaller image, then parts of the whole; what is not needed any more goes.
"use strict";

{
  /** Scripts that load at once, and bytes of whole images that are kept. */
  const AT_ONCE = 4;
  const MOST = 900e6;

  const entries = new Map();
  const loading = new Set();
  let wanted = [];
  let clock = 0;
  const listeners = new Set();

  /** An image: its smaller form and its whole one, each with its version, which grows with each part. */
  function entry(number) {
    if (!entries.has(number)) {
      const data = ltsc.book.images[number].data;
      entries.set(number, { number, data, pre: null, full: null, used: 0, failed: null });
    }
    return entries.get(number);
  }

  const level = (width, height, factor, count) => ({
    array: new Float32Array(3 * width * height), width, height, factor, version: 0, done: new Set(), count, dirty: [],
  });

  /** Planes of bytes as numbers, three for each pixel. */
  function numbers(bytes, data, count) {
    const out = new Float32Array(3 * count);
    const bits = new Uint32Array(1);
    const value = new Float32Array(bits.buffer);
    const channels = data.grey ? 1 : 3;
    for (let c = 0; c < channels; c++) {
      const base = c * data.bytes * count;
      for (let i = 0; i < count; i++) {
        let word = 0;
        for (let k = 0; k < data.bytes; k++) word |= bytes[base + k * count + i] << (24 - 8 * k);
        bits[0] = word;
        out[3 * i + c] = value[0];
      }
    }
    if (data.grey) for (let i = 0; i < count; i++) out[3 * i + 1] = out[3 * i + 2] = out[3 * i];
    return out;
  }

  async function inflate(text) {
    const raw = atob(text);
    const bytes = new Uint8Array(raw.length);
    for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  }

  /** Called by the scripts of the data. */
  ltsc.bring = async (number, part, text) => {
    const one = entry(number);
    const data = one.data;
    try {
      const bytes = await inflate(text);
      if (part === "p") {
        const { width, height, factor } = data.preview;
        const pre = level(width, height, factor, 1);
        pre.array = numbers(bytes, data, width * height);
        settle(pre, "p", [0, 0, width, height]);
        one.pre = pre;
      } else {
        const tile = data.tiles[Number(part)];
        const [x, y, w, h] = tile;
        if (!one.full) one.full = begin(one);
        const rows = numbers(bytes, data, w * h);
        for (let row = 0; row < h; row++) {
          one.full.array.set(rows.subarray(3 * row * w, 3 * (row + 1) * w), 3 * ((y + row) * data.width + x));
        }
        settle(one.full, part, tile);
      }
    } catch (error) {
      one.failed = `its data cannot be read: ${error}`;
    }
    loading.delete(`${number}-${part}`);
    listeners.forEach((tell) => tell());
    pump();
  };

  const masks = new Map();

  /** Called by the scripts of groups: a number for each pixel. */
  ltsc.groups = async (name, text) => {
    masks.set(name, await inflate(text));
    listeners.forEach((tell) => tell());
  };

  /** Numbers of groups by the name of their script; nothing until they have come. */
  function mask(name) {
    if (masks.has(name)) return masks.get(name);
    masks.set(name, null);
    const script = ltsc.el("script", { src: name });
    script.onload = () => script.remove();
    script.onerror = () => {
      masks.set(name, new Uint8Array(0));
      script.remove();
    };
    document.head.append(script);
    return null;
  }

  function settle(to, part, tile) {
    to.done.add(part);
    to.dirty.push(tile);
    to.version++;
  }

  /** A whole image before its parts: the smaller one, enlarged. */
  function begin(one) {
    const { width, height } = one.data;
    const full = level(width, height, 1, one.data.tiles.length);
    if (one.pre) {
      const { array, width: w, factor } = one.pre;
      for (let y = 0; y < height; y++) {
        const row = Math.floor(y / factor) * w;
        for (let x = 0; x < width; x++) {
          const from = 3 * (row + Math.floor(x / factor));
          const to = 3 * (y * width + x);
          full.array[to] = array[from];
          full.array[to + 1] = array[from + 1];
          full.array[to + 2] = array[from + 2];
        }
      }
      full.dirty.push([0, 0, width, height]);
      full.version++;
    }
    return full;
  }

  const complete = (of) => of !== null && of.done.size === of.count;

  /** The parts of an image that are still to come, those near a point first. */
  function missing(number, whole, near) {
    const one = entry(number);
    const parts = [];
    if (one.failed || !one.data) return parts;
    if (one.data.preview && !one.pre) parts.push("p");
    if (whole || !one.data.preview) {
      const far = ([x, y, w, h]) => Math.hypot(x + w / 2 - near[0] * one.data.width, y + h / 2 - near[1] * one.data.height);
      const open = one.data.tiles.map((tile, at) => [String(at), far(tile)]).filter(([at]) => !one.full || !one.full.done.has(at));
      parts.push(...open.sort((p, q) => p[1] - q[1]).map(([at]) => at));
    }
    return parts;
  }

  /** Loads what is wanted most; what nobody wants any more is not loaded. */
  function pump() {
    for (const { number, whole, near } of wanted) {
      for (const part of missing(number, whole, near)) {
        if (loading.size >= AT_ONCE) return;
        const name = `${number}-${part}`;
        // Parts are laid over the smaller image, which comes first.
        if (loading.has(name) || (part !== "p" && loading.has(`${number}-p`))) continue;
        loading.add(name);
        const script = ltsc.el("script", { src: `data/${name}.js` });
        script.onload = () => script.remove();
        script.onerror = () => {
          script.remove();
          loading.delete(name);
          entry(number).failed = `its file data/${name}.js is missing`;
          listeners.forEach((tell) => tell());
          pump();
        };
        document.head.append(script);
      }
    }
  }

  /** Says what is looked at: numbers of images, whether each is needed whole, and what point is near. */
  ltsc.want = (list) => {
    wanted = list;
    clock++;
    for (const { number } of list) entry(number).used = clock;
    evict();
    pump();
  };

  function evict() {
    const size = (one) => (one.full ? one.full.array.byteLength : 0);
    let total = [...entries.values()].reduce((sum, one) => sum + size(one), 0);
    const old = [...entries.values()].filter((one) => one.full && one.used < clock).sort((p, q) => p.used - q.used);
    for (const one of old) {
      if (total <= MOST) break;
      total -= size(one);
      ltsc.gpu.forget(one.full);
      one.full = null;
    }
  }

  /** The best form of an image that is there: whole or smaller; nothing where neither is. */
  const best = (number) => {
    const one = entry(number);
    return one.full || one.pre;
  };

  ltsc.store = {
    entry, best, complete, mask,
    done: (number) => complete(entry(number).full),
    failed: (number) => entry(number).failed,
    busy: () => loading.size + [...masks.values()].filter((one) => one === null).length,
    loaded: () => [...entries.values()].filter((one) => one.full || one.pre).map((one) => one.number),
    listen: (tell) => listeners.add(tell),
    /** Waits until an image is there as a whole. */
    whole: (number) =>
      new Promise((resolve, reject) => {
        const look = () => {
          if (complete(entry(number).full)) resolve(entry(number).full);
          else if (entry(number).failed) reject(new Error(entry(number).failed));
          else return false;
          listeners.delete(look);
          return true;
        };
        if (look()) return;
        listeners.add(look);
        if (!wanted.some((one) => one.number === number && one.whole)) {
          wanted = [...wanted, { number, whole: true, near: [0.5, 0.5] }];
        }
        pump();
      }),
  };
}
