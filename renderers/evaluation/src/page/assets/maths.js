// The numbers of a comparison, in double precision: the same formulas as in the command line, which a test compares. A is the reference.
"use strict";

{
  const finite = (x) => Number.isFinite(x);
  const signed = (d) => {
    const length = Math.hypot(d[0], d[1], d[2]);
    return length === 0 || d[0] + d[1] + d[2] > 0 ? length : -length;
  };
  const mean = (of) => (of(0) + of(1) + of(2)) / 3;
  /** The mean of a term over the channels that are not black in A; a guard below 0 stands for those. */
  const guarded = (guards, of) => {
    let sum = 0;
    let count = 0;
    for (let c = 0; c < 3; c++) {
      if (guards[c] < 0) continue;
      sum += of(c, guards[c]);
      count++;
    }
    return count > 0 ? sum / count : NaN;
  };
  const square = (x) => x * x;

  /** Maps of a pixel alone: a and b are its three values. */
  const PIXEL = {
    signed: (a, b) => signed([b[0] - a[0], b[1] - a[1], b[2] - a[2]]),
    absolute: (a, b) => Math.hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]),
    relative: (a, b) => signed([0, 1, 2].map((c) => (b[c] - a[c]) / (a[c] === 0 ? 1 : Math.abs(a[c])))),
    squared: (a, b) => mean((c) => square(b[c] - a[c])),
    "relative-squared": (a, b, g) => guarded(g, (c, e) => square(b[c] - a[c]) / (a[c] * a[c] + e * e)),
    mape: (a, b, g) => guarded(g, (c, e) => Math.abs(b[c] - a[c]) / (Math.abs(a[c]) + e)),
    smape: (a, b) => mean((c) => {
      const sum = Math.abs(a[c]) + Math.abs(b[c]);
      return sum > 0 ? (2 * Math.abs(b[c] - a[c])) / sum : 0;
    }),
    "relative-squared-fixed": (a, b) => mean((c) => square(b[c] - a[c]) / (a[c] * a[c] + 1e-4)),
    "mape-fixed": (a, b) => mean((c) => Math.abs(b[c] - a[c]) / (Math.abs(a[c]) + 0.01)),
    "smape-fixed": (a, b) => mean((c) => (2 * Math.abs(b[c] - a[c])) / (Math.abs(a[c]) + Math.abs(b[c]) + 0.02)),
  };

  const LUMINANCE = [0.2126, 0.7152, 0.0722];

  function srgb(x) {
    const v = Math.min(Math.max(x, 0), 1);
    return v <= 0.0031308 ? 12.92 * v : 1.055 * Math.pow(v, 1 / 2.4) - 0.055;
  }

  /** Structural similarity in windows of 5 x 5 pixels, which end at the border and leave out what is not finite. */
  function ssim(a, b, width, height, exposure) {
    const gain = Math.pow(2, exposure);
    const count = width * height;
    const seen = [new Float64Array(count), new Float64Array(count)];
    [a, b].forEach((image, side) => {
      for (let i = 0; i < count; i++) {
        let sum = 0;
        for (let c = 0; c < 3; c++) sum += LUMINANCE[c] * Math.min(Math.max(image[3 * i + c] * gain, 0), 1);
        seen[side][i] = srgb(sum);
      }
    });
    const known = both(a, b, count);
    const out = new Float32Array(count).fill(NaN);
    for (let y = 0; y < height; y++) {
      for (let x = 0; x < width; x++) {
        if (!known[y * width + x]) continue;
        let [n, sa, sb, saa, sbb, sab] = [0, 0, 0, 0, 0, 0];
        for (let v = Math.max(y - 2, 0); v < Math.min(y + 3, height); v++) {
          for (let u = Math.max(x - 2, 0); u < Math.min(x + 3, width); u++) {
            const i = v * width + u;
            if (!known[i]) continue;
            const [p, q] = [seen[0][i], seen[1][i]];
            n++;
            sa += p;
            sb += q;
            saa += p * p;
            sbb += q * q;
            sab += p * q;
          }
        }
        const [ma, mb] = [sa / n, sb / n];
        const va = Math.max(saa / n - ma * ma, 0);
        const vb = Math.max(sbb / n - mb * mb, 0);
        const most = Math.sqrt(va * vb);
        const cov = Math.min(Math.max(sab / n - ma * mb, -most), most);
        out[y * width + x] = ((2 * ma * mb + 1e-4) / (ma * ma + mb * mb + 1e-4)) * ((2 * cov + 9e-4) / (va + vb + 9e-4));
      }
    }
    return out;
  }

  /** Where both images are finite. */
  function both(a, b, count) {
    const known = new Uint8Array(count);
    for (let i = 0; i < count; i++) {
      let ok = 1;
      for (let c = 3 * i; c < 3 * i + 3; c++) if (!finite(a[c]) || !finite(b[c])) ok = 0;
      known[i] = ok;
    }
    return known;
  }

  /** 1 % of the mean of |A| in each channel over pixels that are finite in both, -1 where that is 0. */
  function guards(a, b) {
    const sums = [0, 0, 0];
    let count = 0;
    for (let i = 0; i < a.length; i += 3) {
      if (!finite(a[i] + a[i + 1] + a[i + 2]) || !finite(b[i] + b[i + 1] + b[i + 2])) continue;
      for (let c = 0; c < 3; c++) sums[c] += Math.abs(a[i + c]);
      count++;
    }
    return sums.map((sum) => (count > 0 && sum > 0 ? (0.01 * sum) / count : -1));
  }

  /** A map of all pixels: not a number where a pixel is not finite in A or B. */
  function whole(name, a, b, width, height, exposure) {
    if (name === "ssim") return ssim(a, b, width, height, exposure);
    const of = PIXEL[name];
    const g = guards(a, b);
    const count = width * height;
    const out = new Float32Array(count).fill(NaN);
    const p = [0, 0, 0];
    const q = [0, 0, 0];
    for (let i = 0; i < count; i++) {
      let ok = true;
      for (let c = 0; c < 3; c++) {
        p[c] = a[3 * i + c];
        q[c] = b[3 * i + c];
        ok = ok && finite(p[c]) && finite(q[c]);
      }
      if (ok) out[i] = of(p, q, g);
    }
    return out;
  }

  /** Ten colors from dark to bright, each as one number; between them colors are mixed. The maps of matplotlib at ninths. */
  const COLORS = {
    inferno: [0x000004, 0x1b0c41, 0x4a0c6b, 0x781c6d, 0xa52c60, 0xcf4446, 0xed6925, 0xfb9b06, 0xf7d13d, 0xfcffa4],
    magma: [0x000004, 0x180f3d, 0x440f76, 0x721f81, 0x9e2f7f, 0xcd4071, 0xf1605d, 0xfd9668, 0xfeca8d, 0xfcfdbf],
    viridis: [0x440154, 0x482878, 0x3e4989, 0x31688e, 0x26828e, 0x1f9e89, 0x35b779, 0x6ece58, 0xb5de2b, 0xfde725],
  };
  const parts = (color) => [(color >> 16) / 255, ((color >> 8) & 255) / 255, (color & 255) / 255];
  const TABLES = Object.fromEntries(Object.entries(COLORS).map(([name, list]) => [name, list.map(parts)]));

  /** The color of a share of a scale, 0 to 1 in each channel. */
  function color(table, share) {
    const t = Math.min(Math.max(share, 0), 1) * 9;
    const at = Math.min(Math.floor(t), 8);
    const [low, high] = [TABLES[table][at], TABLES[table][at + 1]];
    return low.map((value, c) => value + (high[c] - value) * (t - at));
  }

  /** A value at a share of all, of those that are finite; every so many are looked at. */
  function percentile(values, share, stride = 1) {
    const some = [];
    for (let i = 0; i < values.length; i += stride) if (finite(values[i])) some.push(values[i]);
    if (some.length === 0) return null;
    some.sort((x, y) => x - y);
    return some[Math.min(Math.floor(some.length * share), some.length - 1)];
  }

  const luminance = (array, at) => LUMINANCE[0] * array[at] + LUMINANCE[1] * array[at + 1] + LUMINANCE[2] * array[at + 2];

  ltsc.maths = { PIXEL, LUMINANCE, TABLES, srgb, guards, whole, color, percentile, luminance, both };
}
