// The same drawing without a graphics processor: slower, and the same picture. Maps are computed once for a pair and kept.
"use strict";

{
  const kept = new Map();

  /** The map of a pair, computed here. */
  function values(job) {
    if (job.values) return job.values;
    const { a, b } = job;
    const name = ltsc.MAPS[job.map];
    const key = `${name} ${job.key} ${a.version} ${b.version} ${job.shown}`;
    if (!kept.has(key)) {
      if (kept.size > 6) kept.delete(kept.keys().next().value);
      const [one, other] = [a, b].map((of) => spread(of, job.size));
      kept.set(key, ltsc.maths.whole(name, one, other, job.size[0], job.size[1], Math.log2(job.shown)));
    }
    return kept.get(key);
  }

  /** A smaller image at the size of the whole one. */
  function spread(of, [width, height]) {
    if (of.factor === 1) return of.array;
    const out = new Float32Array(3 * width * height);
    for (let y = 0; y < height; y++) {
      for (let x = 0; x < width; x++) {
        const from = 3 * (Math.floor(y / of.factor) * of.width + Math.floor(x / of.factor));
        for (let c = 0; c < 3; c++) out[3 * (y * width + x) + c] = of.array[from + c];
      }
    }
    return out;
  }

  function toned(job, color) {
    const { srgb, LUMINANCE } = ltsc.maths;
    const y = LUMINANCE[0] * color[0] + LUMINANCE[1] * color[1] + LUMINANCE[2] * color[2];
    const v = job.channel === 0 ? color : Array(3).fill(job.channel === 4 ? y : color[job.channel - 1]);
    if (job.tone === 2) {
      const of = job.channel === 0 ? y : v[0];
      const [low, high, log] = job.range;
      const at = log > 0.5 ? Math.log2(Math.max(of, 1e-37)) : of;
      return ltsc.maths.color(job.table, (at - low) / (high - low));
    }
    if (job.tone === 1) return v.map((x) => Math.pow(ltsc.clamp(x * job.gain, 0, 1), 1 / job.gamma));
    return v.map((x) => srgb(x * job.gain));
  }

  function colored(job, value) {
    if (job.tone === 3) {
      const v = ltsc.maths.srgb(Math.abs(value) * job.gain);
      return value > 0 ? [0, v, 0] : [v, 0, 0];
    }
    return ltsc.maths.color(job.table, (job.flip ? 1 - value : value) * job.gain);
  }

  /** Draws into the context of a pane. */
  function draw(context, job) {
    const { width, height, size, taps } = job;
    const picture = context.createImageData(width, height);
    const image = job.kind < 2 || job.kind === 4;
    const map = image ? null : values(job);
    const sum = [0, 0, 0];
    for (let y = 0; y < height; y++) {
      for (let x = 0; x < width; x++) {
        const of = job.kind === 1 || (job.kind === 4 && x + 0.5 >= job.split) ? job.b : job.a;
        let [count, bad] = [0, false];
        sum.fill(0);
        for (let v = 0; v < taps; v++) {
          for (let u = 0; u < taps; u++) {
            const px = Math.floor(job.origin[0] + (x + (u + 0.5) / taps) * job.step);
            const py = Math.floor(job.origin[1] + (y + (v + 0.5) / taps) * job.step);
            if (px < 0 || py < 0 || px >= size[0] || py >= size[1]) continue;
            count++;
            if (image) {
              const at = 3 * (Math.floor(py / of.factor) * of.width + Math.floor(px / of.factor));
              for (let c = 0; c < 3; c++) sum[c] += of.array[at + c];
            } else {
              sum[0] += map[py * size[0] + px];
            }
          }
        }
        if (count === 0) continue;
        for (let c = 0; c < 3; c++) {
          sum[c] /= count;
          bad = bad || !Number.isFinite(sum[c]);
        }
        const color = bad ? [0, 0, 1] : image ? toned(job, sum) : colored(job, sum[0]);
        const at = 4 * (y * width + x);
        for (let c = 0; c < 3; c++) picture.data[at + c] = Math.round(color[c] * 255);
        picture.data[at + 3] = 255;
      }
    }
    context.putImageData(picture, 0, 0);
  }

  /** The numbers behind a drawing, in the form of the graphics processor's. */
  function read(job) {
    const [width, height] = job.size;
    const out = new Float32Array(4 * width * height);
    const image = job.kind < 2;
    const map = image ? null : values(job);
    const of = job.kind === 1 ? job.b : job.a;
    for (let i = 0; i < width * height; i++) {
      const found = image ? [of.array[3 * i], of.array[3 * i + 1], of.array[3 * i + 2]] : [map[i], 0, 0];
      const ok = found.every(Number.isFinite);
      if (ok) out.set([...found, 1], 4 * i);
    }
    return out;
  }

  ltsc.cpu = { draw, read, spread };
}
