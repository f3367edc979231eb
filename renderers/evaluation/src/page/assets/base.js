// The name that all scripts share, and small tools. Text becomes text nodes only: no name of a scene can become HTML.
"use strict";

const ltsc = { book: null, errors: [] };

{
  const SVG = "http://www.w3.org/2000/svg";

  function fill(node, attributes, children) {
    for (const [name, value] of Object.entries(attributes || {})) {
      if (value === null || value === undefined || value === false) continue;
      if (name === "on") {
        for (const [event, act] of Object.entries(value)) node.addEventListener(event, act);
      } else if (name === "value" || name === "checked" || name === "disabled") {
        node[name] = value;
      } else {
        node.setAttribute(name, value === true ? "" : String(value));
      }
    }
    for (const child of children.flat(Infinity)) {
      if (child === null || child === undefined || child === false) continue;
      node.append(child.nodeType ? child : document.createTextNode(String(child)));
    }
    return node;
  }

  /** An element of HTML with attributes, events under `on`, and children; strings are text. */
  ltsc.el = (name, attributes, ...children) => fill(document.createElement(name), attributes, children);

  /** The same of SVG. */
  ltsc.svg = (name, attributes, ...children) => fill(document.createElementNS(SVG, name), attributes, children);

  /** A number as people read it. */
  ltsc.number = (value, digits = 4) => {
    if (value === null || value === undefined) return "–";
    if (Number.isNaN(value)) return "NaN";
    if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
    if (value === 0) return "0";
    const size = Math.abs(value);
    const text = size >= 1e5 || size < 1e-4 ? value.toExponential(digits - 1) : value.toPrecision(digits);
    return text.replace("-", "−");
  };

  /** A whole number with thin spaces between thousands. */
  ltsc.whole = (value) => (value === null || value === undefined ? "–" : String(value).replace(/\B(?=(\d{3})+$)/g, "\u202f"));

  ltsc.clamp = (value, low, high) => Math.min(Math.max(value, low), high);

  /** Verdicts: word, symbol, class. Color is never all that tells them apart. */
  const VERDICTS = {
    agree: ["agree", "✓"],
    differ: ["differ", "≠"],
    undecided: ["undecided", "?"],
    none: ["no verdict", "–"],
    missing: ["missing", "✗"],
  };
  ltsc.verdict = (word) => VERDICTS[word] || VERDICTS.none;

  /** A badge that says a verdict. */
  ltsc.badge = (word) => {
    const [words, symbol] = ltsc.verdict(word);
    return ltsc.el("span", { class: `badge ${word || "none"}` }, ltsc.el("span", { "aria-hidden": "true" }, symbol), " ", words);
  };

  /** A link to a file beside the page: each part of its path is encoded, so that no name can be another address. */
  ltsc.path = (path) => path.split("/").map((part) => (part === ".." ? part : encodeURIComponent(part))).join("/");

  /** Hands the person a file. */
  ltsc.download = (name, blob) => {
    const address = URL.createObjectURL(blob);
    const link = ltsc.el("a", { href: address, download: name.replace(/[^\p{L}\p{N} ._,+=-]/gu, "-").slice(0, 120) });
    document.body.append(link);
    link.click();
    link.remove();
    setTimeout(() => URL.revokeObjectURL(address), 10000);
  };

  /** Says something to those who do not see it. */
  ltsc.tell = (text) => {
    const place = document.getElementById("status");
    if (place && place.textContent !== text) place.textContent = text;
  };

  /** Text with empty lines between its paragraphs. */
  ltsc.paragraphs = (text) =>
    (text || "").split(/\n\s*\n/).filter((part) => part.trim()).map((part) => ltsc.el("p", {}, part.trim()));

  window.addEventListener("error", (event) => ltsc.errors.push(String(event.message)));
  window.addEventListener("unhandledrejection", (event) => ltsc.errors.push(String(event.reason)));
}
