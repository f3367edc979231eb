// The index: what was compared, and how it came out.
"use strict";

{
  const { el, number } = ltsc;
  const picture = (n) => ltsc.book.images[n];
  const link = (scene, a, b, more) => {
    const words = new URLSearchParams({ scene: scene.name });
    if (a !== null && a !== undefined) words.set("a", picture(a).label);
    if (b !== null && b !== undefined) words.set("b", picture(b).label);
    for (const [name, value] of Object.entries(more ?? {})) words.set(name, value);
    return `#view?${words}`;
  };

  /** The comparison in which an image is judged, or the one that tells most. */
  function judged(scene, n) {
    const rank = { differ: 0, undecided: 1, agree: 2 };
    return scene.pairs.filter((pair) => pair.b === n).sort((p, q) => (rank[p.verdict] ?? 3) - (rank[q.verdict] ?? 3))[0] ?? null;
  }

  /** Columns of the matrix: labels of images, in the order in which scenes have them. */
  function columns() {
    const labels = [];
    for (const scene of ltsc.book.scenes) for (const n of scene.images) if (picture(n).kind === "image" && !labels.includes(picture(n).label)) labels.push(picture(n).label);
    return labels;
  }

  function cell(scene, label) {
    const n = scene.images.find((one) => picture(one).label === label && picture(one).kind === "image");
    if (n === undefined) return el("td", { class: "cell empty" }, el("span", { class: "quiet" }, "not asked for"));
    const one = picture(n);
    if (!one.data) return el("td", { class: "cell missing" }, ltsc.badge("missing"), el("span", { class: "small" }, `${one.status}${one.why ? `: ${one.why}` : ""}`));
    const pair = judged(scene, n);
    const first = scene.pairs.find((one) => one.a === n);
    const metric = pair?.metrics.find(([name]) => name === "relative-mse")?.[1];
    const words = pair ? [ltsc.badge(pair.verdict), el("span", { class: "small" }, `against ${pair.a_label}`), metric !== undefined && metric !== null ? el("span", { class: "small" }, `relative MSE ${number(metric, 3)}`) : null]
      : [el("span", { class: "badge reference" }, first ? "reference" : "not compared")];
    const a = pair?.a ?? null;
    return el("td", { class: `cell ${pair?.verdict ?? "none"}` }, el("a", { href: link(scene, a ?? n, n, pair && a !== null ? { show: "map", tiles: pair.tiles?.words.length ? 1 : 0 } : {}) },
      one.thumb ? el("img", { src: one.thumb, alt: `${one.label} of ${scene.name}`, loading: "lazy", width: 96, height: 96 }) : null, el("span", { class: "words" }, words)));
  }

  function matrix() {
    const labels = columns();
    const row = (scene) => {
      const n = scene.images.find((one) => picture(one).thumb);
      return el("tr", {},
        el("th", { scope: "row" }, el("a", { href: link(scene, null, null) }, n === undefined ? null : el("img", { src: picture(n).thumb, alt: "", loading: "lazy", width: 64, height: 64 }), el("span", {}, scene.name)),
          scene.parameters.length > 0 ? el("span", { class: "small" }, scene.parameters.map(([name, value]) => `${name} = ${value}`).join(", ")) : null),
        labels.map((label) => cell(scene, label)));
    };
    return el("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": "Matrix of scenes and images" },
      el("table", { class: "matrix" }, el("caption", { class: "hidden" }, "Verdicts by scene and image"),
        el("thead", {}, el("tr", {}, el("th", { scope: "col" }, "scene"), labels.map((label) => el("th", { scope: "col" }, label)))),
        el("tbody", {}, ltsc.book.scenes.map(row))));
  }

  /** A table whose columns sort it. Cells are text, numbers (with their text), or elements with a value to sort by. */
  function sortable(caption, heads, rows) {
    let [by, up] = [null, true];
    const body = el("tbody", {});
    const plain = (x) => (x && x.sort !== undefined ? x.sort : x);
    const buttons = heads.map((head, at) => el("button", { type: "button", on: { click: () => {
      up = by === at ? !up : true;
      by = at;
      fill();
    } } }, head, el("span", { class: "arrow", "aria-hidden": "true" })));
    const cells = buttons.map((button) => el("th", { scope: "col", "aria-sort": "none" }, button));
    function fill() {
      const list = [...rows];
      if (by !== null) {
        list.sort((p, q) => {
          const [x, y] = [plain(p[by]), plain(q[by])];
          // What is not known comes last, whichever way.
          if (x === null || x === undefined || y === null || y === undefined) return (x === null || x === undefined) - (y === null || y === undefined);
          const order = typeof x === "number" && typeof y === "number" ? x - y : String(x).localeCompare(String(y), undefined, { numeric: true });
          return up ? order : -order;
        });
      }
      cells.forEach((one, at) => one.setAttribute("aria-sort", by === at ? (up ? "ascending" : "descending") : "none"));
      body.replaceChildren(...list.map((row) => el("tr", {}, row.map((x, at) => {
        const shown = x && x.show !== undefined ? x.show : typeof x === "number" ? number(x) : (x ?? "–");
        const numeric = typeof plain(x) === "number";
        return at === 0 ? el("th", { scope: "row" }, shown) : el("td", { class: numeric ? "number" : null }, shown);
      }))));
    }
    fill();
    return el("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": `${caption}: table` }, el("table", { class: "plain" }, el("caption", { class: "hidden" }, caption), el("thead", {}, el("tr", {}, cells)), body));
  }

  function images() {
    const rows = ltsc.book.scenes.flatMap((scene) => scene.images.map((n) => {
      const one = picture(n);
      const shown = one.data ? el("a", { href: link(scene, null, n) }, one.label) : one.label;
      return [{ sort: `${scene.name} ${one.label}`, show: [scene.name, ": ", shown] }, one.renderer || one.kind, one.status,
        one.data ? { sort: one.data.width * one.data.height, show: `${one.data.width} × ${one.data.height}` } : null,
        one.samples === null ? null : { sort: one.samples, show: ltsc.whole(one.samples) },
        one.noise === null ? null : { sort: one.noise, show: `${(100 * one.noise).toFixed(2)} %` },
        one.seconds === null ? null : { sort: one.seconds, show: one.seconds.toFixed(1) },
        one.data ? one.data.non_finite : null];
    }));
    return sortable("Images", ["image", "renderer", "status", "pixels", "samples", "noise of a pixel", "seconds", "not finite"], rows);
  }

  function comparisons() {
    const all = ltsc.book.scenes.flatMap((scene) => scene.pairs.map((pair) => ({ scene, pair })));
    if (all.length === 0) return el("p", { class: "quiet" }, "Nothing is compared.");
    const names = ltsc.book.metrics.map((one) => one.name).filter((name) => all.some(({ pair }) => pair.metrics.some(([known]) => known === name)));
    const rows = all.map(({ scene, pair }) => [
      { sort: `${scene.name} ${pair.b_label}`, show: [scene.name, ": ", pair.b === null || !picture(pair.b).data ? pair.b_label : el("a", { href: link(scene, pair.a, pair.b, { show: "map" }) }, pair.b_label), el("span", { class: "small" }, `against ${pair.a_label}`)] },
      { sort: pair.verdict ?? "no verdict", show: [ltsc.badge(pair.verdict), pair.verdict ? null : el("span", { class: "small" }, pair.refused ?? ""), pair.notes.some((note) => note.startsWith("not comparable")) ? el("span", { class: "small" }, "not comparable") : null] },
      ...names.map((name) => pair.metrics.find(([known]) => known === name)?.[1] ?? null),
    ]);
    return sortable("Comparisons", ["B against A", "verdict", ...names], rows);
  }

  function plots(list) {
    return el("div", { class: "plots" }, list.map((plot) => el("figure", { class: "plot" },
      el("img", { src: plot.svg, alt: `${plot.title}. ${plot.text}`, loading: "lazy", width: 640, height: 460 }),
      el("figcaption", {}, plot.title, " ", el("span", { class: "links" }, el("a", { href: plot.svg, download: true }, "SVG"), el("a", { href: plot.csv, download: true }, "CSV"))))));
  }

  /** How many comparisons came out how. */
  function counts() {
    const of = { agree: 0, differ: 0, undecided: 0, none: 0 };
    for (const scene of ltsc.book.scenes) for (const pair of scene.pairs) of[pair.verdict ?? "none"]++;
    const missing = ltsc.book.images.filter((one) => !one.data).length;
    return el("ul", { class: "counts" }, Object.entries(of).map(([word, count]) => el("li", {}, el("b", {}, count), " ", ltsc.badge(word))), missing > 0 ? el("li", {}, el("b", {}, missing), " ", ltsc.badge("missing")) : null);
  }

  function build(app) {
    const book = ltsc.book;
    document.title = book.title;
    const start = book.scenes.find((scene) => scene.images.some((n) => picture(n).data));
    app.replaceChildren(el("main", { id: "main", class: "index" },
      el("header", {},
        el("h1", {}, book.title),
        ltsc.paragraphs(book.description),
        el("p", { class: "quiet" }, [book.date, ...book.facts.map(([name, value]) => `${name} ${value}`)].filter(Boolean).join(" · ")),
        start ? el("p", {}, el("a", { class: "button", href: link(start, null, null) }, "Open the viewer"), " ", el("a", { class: "button second", href: link(start, null, null, { layout: "grid", over: "all" }) }, "All scenes at once")) : null,
        counts()),
      book.remarks.length > 0 ? el("ul", { class: "notes" }, book.remarks.map((text) => el("li", {}, text))) : null,
      book.scenes.length === 0 ? el("p", {}, "There are no images here. Put OpenEXR or PFM files into this folder, and make the page again by ", el("code", {}, "ltsc report"), ".") : [
        el("section", { "aria-labelledby": "h-matrix" }, el("h2", { id: "h-matrix" }, "Scenes and images"), matrix()),
        el("section", { "aria-labelledby": "h-comparisons" }, el("h2", { id: "h-comparisons" }, "Comparisons"), comparisons()),
        el("section", { "aria-labelledby": "h-images" }, el("h2", { id: "h-images" }, "Images"), images()),
      ],
      book.cases.length > 0 ? el("section", { "aria-labelledby": "h-cases" }, el("h2", { id: "h-cases" }, "Test cases"), book.cases.map((one) => el("details", { class: "panel" }, el("summary", {}, el("b", {}, one.name), one.description ? ` — ${one.description}` : ""), el("pre", { tabindex: 0 }, one.settings)))) : null,
      book.scenes.some((scene) => scene.documentation) ? el("section", { "aria-labelledby": "h-scenes" }, el("h2", { id: "h-scenes" }, "About the scenes"), about()) : null,
      book.plots.length > 0 ? el("section", { "aria-labelledby": "h-swept" }, el("h2", { id: "h-swept" }, "Over parameters"), plots(book.plots)) : null,
      book.scenes.some((scene) => scene.plots.length > 0) ? el("section", { "aria-labelledby": "h-plots" }, el("h2", { id: "h-plots" }, "Plots"), book.scenes.filter((scene) => scene.plots.length > 0).map((scene, at) => el("details", { class: "panel", open: at === 0 }, el("summary", {}, scene.name), plots(scene.plots)))) : null,
      el("section", { "aria-labelledby": "h-terms" }, el("h2", { id: "h-terms" }, "What the numbers mean"), el("details", { class: "panel" }, el("summary", {}, "Metrics and comparisons"), el("dl", { class: "terms" }, [...book.metrics, ...book.maps].map((row) => [el("dt", {}, row.name), el("dd", {}, row.summary, ". ", el("span", { class: "formula" }, row.formula))])))),
      el("footer", { class: "quiet" }, `A is the reference: ratios are B / A, differences B − A. Made by ${book.generator}; everything is in this folder, and nothing is loaded from elsewhere.`)));
  }

  function about() {
    const seen = new Set();
    return book_scenes().filter((scene) => scene.documentation && !seen.has(scene.scene) && seen.add(scene.scene)).map((scene) => el("details", { class: "panel" }, el("summary", {}, scene.scene), ltsc.paragraphs(scene.documentation)));
  }
  const book_scenes = () => ltsc.book.scenes;

  ltsc.index = { build };
}
