// The panes: which there are, where their pixels lie, and what is drawn over them. All share one zoom and one middle.
"use strict";

{
  const S = ltsc.state;
  const TONES = { srgb: 0, gamma: 1, false: 2 };
  const CHANNELS = { rgb: 0, r: 1, g: 2, b: 3, lum: 4 };
  const SLOW = ["flip", "hdr-flip"];

  let stage = null;
  let panes = [];
  let asked = false;
  let hover = null;
  const slow = new Map();

  const picture = (number) => ltsc.book.images[number];

  /** What is to be seen: for each pane its kind, images and title. */
  function plan() {
    const now = S.now;
    const { a, b } = now;
    const image = (n, side) => ({ kind: "image", a: n, b: n, title: `${side ? `${side}: ` : ""}${picture(n)?.label ?? "no image"}`, side });
    const map = (p, q, title) => ({ kind: "map", a: p, b: q, title });
    const versus = (p, q) => `${now.map}: ${picture(q)?.label ?? "–"} against ${picture(p)?.label ?? "–"}`;
    if (ltsc.book.scenes.length === 0) return [];
    if (now.layout === "grid") {
      if (now.over === "all") {
        return ltsc.book.scenes.map((scene, at) => {
          const of = (n) => scene.images.find((one) => picture(one).label === picture(n)?.label) ?? null;
          const first = S.choice(at);
          const [p, q] = [(at === now.scene ? a : of(a)) ?? first.a, at === now.scene ? b : of(b)];
          const shown = now.show === "a" ? p : q;
          const title = `${scene.name}: `;
          if (q === null && now.show !== "a") return { kind: "none", title: title + (picture(b)?.label ?? "–"), why: "this scene has no such image", at };
          if (now.show === "map") return { ...map(p, q, title + versus(p, q)), at };
          return { ...image(shown), title: title + (picture(shown)?.label ?? "–"), at, like: p };
        });
      }
      const images = ltsc.book.scenes[now.scene].images;
      if (now.show === "map") return images.filter((n) => n !== a).map((n) => ({ ...map(a, n, versus(a, n)), pick: n }));
      return images.map((n) => ({ ...image(n, n === a ? "A" : n === b ? "B" : ""), pick: n }));
    }
    if (now.layout === "side") return [image(a, "A"), image(b, "B"), map(a, b, versus(a, b))];
    if (now.layout === "split") return [{ kind: "split", a, b, title: `A: ${picture(a)?.label ?? "–"}  |  B: ${picture(b)?.label ?? "–"}` }];
    if (now.show === "map") return [map(a, b, versus(a, b))];
    return [now.show === "a" ? image(a, "A") : image(b, "B")];
  }

  /** Why a pane shows nothing, or nothing. */
  function lacks(pane) {
    if (pane.kind === "none") return pane.why;
    for (const n of [pane.a, pane.b]) {
      if (!S.there(n)) {
        const one = n === null ? null : picture(n);
        return one ? `${one.label}: ${one.status}${one.why ? ` — ${one.why}` : ""}` : "there is no image";
      }
      if (ltsc.store.failed(n)) return `${picture(n).label}: ${ltsc.store.failed(n)}`;
    }
    return pane.kind === "image" ? null : S.why_not(pane.a, pane.b);
  }

  /** Makes the panes anew where there are others than before. */
  function layout() {
    const wanted = plan();
    const key = (list) => list.map((one) => one.kind).join();
    if (key(wanted) !== key(panes) || !stage.firstChild) {
      panes.forEach((pane) => watcher.unobserve(pane.figure));
      stage.replaceChildren();
      panes = wanted.map((one, at) => {
        const canvas = ltsc.el("canvas", { role: "img" });
        const note = ltsc.el("p", { class: "note", hidden: true });
        const caption = ltsc.el("figcaption", {});
        const figure = ltsc.el("figure", { class: "pane" }, ltsc.el("div", { class: "frame" }, canvas, note), caption);
        figure.dataset.at = at;
        stage.append(figure);
        watcher.observe(figure);
        return { ...one, figure, canvas, note, caption, seen: S.now.layout !== "grid" };
      });
    } else {
      panes = wanted.map((one, at) => ({ ...panes[at], pick: undefined, at: undefined, like: undefined, ...one }));
    }
    stage.className = `stage ${S.now.layout}`;
    stage.style.setProperty("--columns", String(columns()));
    for (const pane of panes) {
      pane.caption.replaceChildren(...caption(pane));
      pane.canvas.setAttribute("aria-label", pane.title);
      say(pane);
    }
  }

  /** Says in the place of a picture why there is none. */
  function say(pane) {
    const why = lacks(pane);
    pane.note.hidden = why === null;
    if (pane.note.textContent !== (why ?? "")) pane.note.textContent = why ?? "";
    pane.canvas.hidden = why !== null;
  }

  function caption(pane) {
    const parts = [ltsc.el("span", { class: "title", title: pane.title }, pane.title)];
    if (pane.kind === "map") {
      const pair = S.pair(pane.a, pane.b);
      if (pair) parts.push(ltsc.badge(pair.verdict));
    }
    return parts;
  }

  const columns = () => {
    if (S.now.layout === "side") return 3;
    if (S.now.layout !== "grid") return 1;
    const wide = stage.clientWidth || 1000;
    return ltsc.clamp(Math.ceil(Math.sqrt(panes.length)), 1, Math.max(1, Math.floor(wide / 220)));
  };

  const watcher = new IntersectionObserver((entries) => {
    for (const one of entries) {
      const pane = panes[Number(one.target.dataset.at)];
      if (pane) pane.seen = one.isIntersecting;
    }
    ask();
  }, { rootMargin: "100px" });

  /** Where pixels lie on a pane: zoom in CSS pixels a pixel, and the pixel in the upper left corner. */
  function place(pane) {
    const data = picture(pane.a).data;
    const frame = pane.canvas.parentElement;
    const [w, h] = [Math.max(frame.clientWidth, 1), Math.max(frame.clientHeight, 1)];
    const whole = Math.min(w / data.width, h / data.height);
    // Pixels of one size, unless that leaves much of the pane empty.
    const fit = whole > 1 && Math.floor(whole) > 0.8 * whole ? Math.floor(whole) : whole;
    const zoom = S.now.zoom ?? fit;
    const ratio = window.devicePixelRatio || 1;
    // Borders of pixels lie on borders of pixels of the screen.
    const snap = (x) => Math.round(x * zoom * ratio) / (zoom * ratio);
    const origin = [snap(S.now.cx * data.width - w / (2 * zoom)), snap(S.now.cy * data.height - h / (2 * zoom))];
    return { w, h, zoom, fit, origin, ratio, data };
  }

  /** What a pane's drawing needs, or nothing while pixels are to come. */
  function job(pane, at, raw) {
    const now = S.now;
    const [a, b] = [ltsc.store.best(pane.a), ltsc.store.best(pane.b)];
    if (!a || !b) return null;
    const data = picture(pane.a).data;
    const map = pane.kind === "map";
    const signed = now.map === "signed" || now.map === "relative";
    const gain = map ? now.mev ?? S.auto(now.map, pane.a, pane.b) : S.exposure(pane.like);
    const shown = picture(pane.a).data.exposure;
    let values = null;
    if (map && SLOW.includes(now.map)) {
      values = slowly(pane, shown);
      if (!values) return null;
    }
    const [low, high] = S.range(S.there(now.a) ? now.a : pane.a);
    const kinds = { image: 1, map: values ? 3 : 2, split: 4 };
    const ratio = at ? at.ratio : 1;
    return {
      a, b, key: `${pane.a} ${pane.b}`, size: [data.width, data.height], kind: kinds[pane.kind], map: ltsc.MAPS.indexOf(now.map), values,
      guards: map ? S.guards(pane.a, pane.b) : null, shown: Math.pow(2, shown), gain: Math.pow(2, gain),
      tone: map ? (signed ? 3 : 4) : TONES[now.tone], gamma: now.gamma, channel: map ? 0 : CHANNELS[now.channel],
      range: [now.lo ?? low, now.hi ?? high, now.log], flip: now.map === "ssim",
      table: map ? (SLOW.includes(now.map) ? "magma" : "inferno") : "viridis",
      width: raw ? data.width : Math.round(at.w * ratio), height: raw ? data.height : Math.round(at.h * ratio),
      origin: raw ? [0, 0] : at.origin, step: raw ? 1 : 1 / (at.zoom * ratio),
      split: raw ? 0 : now.split * at.w * ratio,
      taps: raw ? 1 : ltsc.clamp(Math.ceil(1 / (at.zoom * ratio)), 1, 8), raw,
    };
  }

  /** A map that is computed beside the page, and drawn when it is there. */
  function slowly(pane, shown) {
    const key = `${S.now.map} ${pane.a} ${pane.b}`;
    if (slow.has(key)) return slow.get(key);
    if (!ltsc.store.done(pane.a) || !ltsc.store.done(pane.b)) return null;
    if (slow.size > 8) slow.delete(slow.keys().next().value);
    slow.set(key, null);
    const { width, height } = picture(pane.a).data;
    const [a, b] = [pane.a, pane.b].map((n) => ltsc.store.entry(n).full.array);
    ltsc.flip(S.now.map, a, b, width, height, shown).then((map) => {
      slow.set(key, map);
      ask();
    });
    return null;
  }

  /** What draws: the graphics processor where there is one, it is not switched off, and the image fits. */
  const drawer = (data) => (S.now.cpu ? ltsc.cpu : ltsc.gpu.fits(data.width, data.height) ? ltsc.gpu : ltsc.cpu);

  function draw(pane) {
    if (lacks(pane) !== null) return;
    const at = place(pane);
    const { canvas } = pane;
    const [width, height] = [Math.round(at.w * at.ratio), Math.round(at.h * at.ratio)];
    if (canvas.width !== width) canvas.width = width;
    if (canvas.height !== height) canvas.height = height;
    const context = canvas.getContext("2d");
    const what = job(pane, at, false);
    canvas.classList.toggle("waits", !what);
    if (!what) {
      context.clearRect(0, 0, width, height);
      const comes = pane.kind === "map" && SLOW.includes(S.now.map) && ltsc.store.done(pane.a) && ltsc.store.done(pane.b);
      context.fillStyle = "#a3abb5";
      context.font = `${Math.round(14 * at.ratio)}px system-ui, sans-serif`;
      context.textAlign = "center";
      context.fillText(comes ? `computing ${S.now.map} …` : "loading …", width / 2, height / 2);
      return;
    }
    drawer(at.data).draw(context, what);
    ltsc.over(pane, context, at, hover);
  }

  /** Draws everything once, soon. */
  function ask() {
    if (asked) return;
    asked = true;
    requestAnimationFrame(() => {
      asked = false;
      if (stage && stage.isConnected) all(false);
    });
  }

  function all(unseen) {
    const list = [];
    for (const pane of panes) {
      say(pane);
      if ((!pane.seen && !unseen) || lacks(pane) !== null) continue;
      const at = place(pane);
      for (const number of new Set([pane.a, pane.b])) {
        const preview = picture(number).data.preview;
        const slowly = pane.kind === "map" && (SLOW.includes(S.now.map) || S.now.map === "ssim");
        const whole = !preview || at.zoom * at.ratio > 1 / preview.factor || slowly;
        list.push({ number, whole, near: [S.now.cx, S.now.cy] });
      }
    }
    // The other side is flipped to next, and its values stand beside.
    for (const number of [S.now.a, S.now.b]) {
      if (S.there(number) && !list.some((one) => one.number === number)) list.push({ ...list[0], number, whole: list[0]?.whole ?? false, near: [0.5, 0.5] });
    }
    ltsc.want(list);
    for (const pane of panes) if (pane.seen || unseen) draw(pane);
    ltsc.panes = panes;
    if (ltsc.drawn) ltsc.drawn();
  }

  /** The numbers of the first pane, whole, four for each pixel; `cpu` computes them without the graphics processor. */
  async function values(cpu) {
    const pane = panes[0];
    const why = lacks(pane);
    if (why) throw new Error(why);
    await Promise.all([pane.a, pane.b].map(ltsc.store.whole));
    let what = job(pane, null, true);
    while (!what) {
      await new Promise((resolve) => setTimeout(resolve, 30));
      what = job(pane, null, true);
    }
    const by = cpu ? ltsc.cpu : drawer(picture(pane.a).data);
    return { width: what.width, height: what.height, numbers: by.read(what) ?? ltsc.cpu.read(what), image: pane.kind === "image" };
  }

  /** All panes as one picture, as they are shown. */
  function shot() {
    all(true);
    const around = stage.getBoundingClientRect();
    const ratio = window.devicePixelRatio || 1;
    const made = panes.filter((pane) => !pane.canvas.hidden);
    const places = made.map((pane) => pane.canvas.getBoundingClientRect());
    const right = Math.max(...places.map((one) => one.right), around.left + 1);
    const bottom = Math.max(...places.map((one) => one.bottom), around.top + 1);
    const [left, top] = [Math.min(...places.map((one) => one.left)), Math.min(...places.map((one) => one.top))];
    const picture = ltsc.el("canvas", { width: Math.round((right - left) * ratio), height: Math.round((bottom - top) * ratio) });
    const context = picture.getContext("2d");
    context.fillStyle = "#111";
    context.fillRect(0, 0, picture.width, picture.height);
    made.forEach((pane, at) => {
      context.drawImage(pane.canvas, Math.round((places[at].left - left) * ratio), Math.round((places[at].top - top) * ratio));
    });
    return picture;
  }

  ltsc.draw = {
    ask, all, layout, place, values, shot, lacks, job,
    panes: () => panes,
    busy: () => asked || later !== null || ltsc.store.busy() > 0 || [...slow.values()].includes(null) || panes.some((pane) => pane.seen && lacks(pane) === null && pane.canvas.classList.contains("waits")),
    slow: (pane) => slow.get(`${S.now.map} ${pane.a} ${pane.b}`) ?? null,
    hover: (at) => {
      hover = at;
      ask();
    },
    on: (element) => {
      stage = element;
      panes = [];
      new ResizeObserver(ask).observe(stage);
    },
  };
  // While parts come one after the other, what is there is drawn now and then.
  let later = null;
  ltsc.store.listen(() => {
    if (ltsc.store.busy() === 0) ask();
    else later ??= setTimeout(() => {
      later = null;
      ask();
    }, 300);
  });
}
