// FLIP and HDR-FLIP (Andersson et al. 2020, 2021), by the formulas of the command line, in a worker: a comparison of large images takes
// seconds, in which the page must answer. A worker may not load a file from a disk, so that it is made from the text of a function.
"use strict";

{
  /** Everything that the worker needs. */
  function worker() {
    const PPD = (0.7 * (3840 / 0.7) * Math.PI) / 180;
    const TO_XYZ = [[0.4338873, 0.376224, 0.1898886], [0.212639, 0.7151687, 0.0721923], [0.01775, 0.1094476, 0.8728023]];
    const TO_RGB = [[3.080399, -1.5373832, -0.5430159], [-0.9212234, 1.8759675, 0.0452559], [0.0528739, -0.203977, 1.151103]];
    const BLUE_YELLOW = [[34.1, 0.04], [13.5, 0.025]];
    const deviation = (b) => (Math.sqrt(b / 2) / Math.PI) * PPD;
    const HALO = Math.ceil(3 * deviation(BLUE_YELLOW[0][1]));
    const gaussian = (radius, s) => Array.from({ length: 2 * radius + 1 }, (_, i) => Math.exp(-0.5 * ((i - radius) / s) ** 2));
    const unit = (taps) => {
      const sum = taps.reduce((x, y) => x + y, 0);
      return taps.map((tap) => tap / sum);
    };
    const balanced = (taps) => {
      const above = taps.filter((tap) => tap > 0).reduce((x, y) => x + y, 0);
      const below = taps.filter((tap) => tap < 0).reduce((x, y) => x + y, 0);
      return taps.map((tap) => (tap > 0 ? tap / above : -tap / below));
    };
    const narrow = (b) => {
      const radius = Math.min(HALO, Math.ceil(6 * deviation(b)));
      return unit(gaussian(radius, deviation(b)));
    };
    const wide = BLUE_YELLOW.map(([, b]) => gaussian(HALO, deviation(b)));
    const weights = BLUE_YELLOW.map(([a, b], at) => a * Math.sqrt(Math.PI / b) * wide[at].reduce((x, y) => x + y, 0) ** 2);
    const both = wide.map(unit);
    const down = both.map((taps, at) => taps.map((tap) => (tap * weights[at]) / (weights[0] + weights[1])));
    const sharp = 0.5 * 0.082 * PPD;
    const reach = Math.ceil(3 * sharp);
    const smooth = gaussian(reach, sharp);
    const first = balanced(smooth.map((tap, i) => -(i - reach) * tap));
    const second = balanced(smooth.map((tap, i) => ((i - reach) ** 2 / (sharp * sharp) - 1) * tap));
    const even = unit(smooth);

    /** Filters a plane along one axis; beyond its border it goes on as it ends. */
    function filter(source, width, height, taps, vertical, out) {
      const radius = (taps.length - 1) / 2;
      const count = taps.length;
      const step = vertical ? width : 1;
      for (let y = 0; y < height; y++) {
        for (let x = 0; x < width; x++) {
          let sum = 0;
          const at = vertical ? y : x;
          if (at >= radius && at < (vertical ? height : width) - radius) {
            // Away from the border nothing is looked for beyond it.
            let from = y * width + x - radius * step;
            for (let k = 0; k < count; k++, from += step) sum += taps[k] * source[from];
            out[y * width + x] = sum;
            continue;
          }
          for (let k = 0; k < taps.length; k++) {
            const u = vertical ? x : Math.min(Math.max(x + k - radius, 0), width - 1);
            const v = vertical ? Math.min(Math.max(y + k - radius, 0), height - 1) : y;
            sum += taps[k] * source[v * width + u];
          }
          out[y * width + x] = sum;
        }
      }
      return out;
    }
    const lightness = (t) => (t > (6 / 29) ** 3 ? Math.cbrt(t) : t / (3 * (6 / 29) ** 2) + 4 / 29);
    const times = (m, x, y, z) => m.map((row) => row[0] * x + row[1] * y + row[2] * z);
    const clamp = (x) => Math.min(Math.max(x, 0), 1);
    function perceived(y, red, blue) {
      const rgb = times(TO_RGB, y + red, y, y - blue).map(clamp);
      const [X, Y, Z] = times(TO_XYZ, rgb[0], rgb[1], rgb[2]).map(lightness);
      const l = 116 * Y - 16;
      return [l, 0.01 * l * (500 * (X - Y)), 0.01 * l * (200 * (Y - Z))];
    }
    const opponent = (rgb) => {
      const [x, y, z] = times(TO_XYZ, rgb[0], rgb[1], rgb[2]);
      return [y, x - y, y - z];
    };
    const distance = (a, b) => Math.abs(a[0] - b[0]) + Math.hypot(a[1] - b[1], a[2] - b[2]);
    const most = distance(perceived(...opponent([0, 1, 0])), perceived(...opponent([0, 0, 1]))) ** 0.7;
    const middle = 0.4 * most;
    const scaled = (d) => {
      const raised = d ** 0.7;
      return raised < middle ? (raised * 0.95) / middle : Math.min(0.95 + ((raised - middle) / (most - middle)) * 0.05, 1);
    };

    /** An image as it is perceived: filtered colors, edges and points. */
    function see(pixels, width, height, tone) {
      const count = width * height;
      const plane = () => new Float32Array(count);
      const [y, red, blue] = [plane(), plane(), plane()];
      for (let i = 0; i < count; i++) {
        [y[i], red[i], blue[i]] = opponent([tone(pixels[3 * i]), tone(pixels[3 * i + 1]), tone(pixels[3 * i + 2])]);
      }
      const across = plane();
      const run = (source, along, up) => filter(filter(source, width, height, along, false, across), width, height, up, true, plane());
      const color = [run(y, narrow(0.0047), narrow(0.0047)), run(red, narrow(0.0053), narrow(0.0053)), run(blue, both[0], down[0])];
      const other = run(blue, both[1], down[1]);
      for (let i = 0; i < count; i++) {
        [color[0][i], color[1][i], color[2][i]] = perceived(color[0][i], color[1][i], color[2][i] + other[i]);
      }
      const edges = [run(y, first, even), run(y, even, first)];
      const points = [run(y, second, even), run(y, even, second)];
      return { color, edges, points };
    }

    /** Raises each pixel to its FLIP at one tone mapping, in bands of rows, so that little memory is needed. */
    function raise(found, a, b, width, height, tone) {
      const BAND = Math.max(64, Math.floor(2000000 / width));
      for (let top = 0; top < height; top += BAND) {
        const from = Math.max(top - HALO, 0);
        const to = Math.min(top + BAND + HALO, height);
        const part = (image) => image.subarray(3 * from * width, 3 * to * width);
        const [p, q] = [see(part(a), width, to - from, tone), see(part(b), width, to - from, tone)];
        for (let row = top; row < Math.min(top + BAND, height); row++) {
          for (let x = 0; x < width; x++) {
            const i = (row - from) * width + x;
            const length = (planes) => Math.hypot(planes[0][i], planes[1][i]);
            const edge = Math.abs(length(p.edges) - length(q.edges));
            const point = Math.abs(length(p.points) - length(q.points));
            const feature = Math.min(Math.sqrt(Math.max(edge, point) * Math.SQRT1_2), 1);
            const d = distance([p.color[0][i], p.color[1][i], p.color[2][i]], [q.color[0][i], q.color[1][i], q.color[2][i]]);
            const value = d > 0 ? scaled(d) ** (1 - feature) : 0;
            if (value > found[row * width + x]) found[row * width + x] = value;
          }
        }
      }
    }

    const F = [2.51 * 0.36, 0.03 * 0.6, 2.43 * 0.36, 0.59 * 0.6, 0.14];

    /** Factors of the exposures of HDR-FLIP: from where the brightest pixel of A is mapped to 0.85 to where the median is. */
    function exposures(a, known) {
      let values = [];
      for (let i = 0; i < known.length; i++) {
        if (!known[i]) continue;
        const y = TO_XYZ[1][0] * a[3 * i] + TO_XYZ[1][1] * a[3 * i + 1] + TO_XYZ[1][2] * a[3 * i + 2];
        values.push(Math.min(Math.max(Math.fround(y), 0), 3.4028234663852886e38));
      }
      const sorted = (list) => Float64Array.from(list).sort();
      values = sorted(values);
      const median = (list) => (list.length > 0 ? list[Math.floor(list.length / 2)] : 0);
      if (median(values) <= 0) values = values.filter((value) => value > 0);
      if (values.length === 0) return null;
      const [A, B, C, D, E] = F;
      const [square, linear, constant] = [A - 0.85 * C, B - 0.85 * D, -0.85 * E];
      const mapped = (-linear + Math.sqrt(linear * linear - 4 * square * constant)) / (2 * square);
      const [start, stop] = [Math.log2(mapped / values[values.length - 1]), Math.log2(mapped / median(values))];
      const count = Math.min(Math.max(Math.ceil(stop - start), 2), 64);
      return Array.from({ length: count }, (_, at) => Math.pow(2, start + ((stop - start) / (count - 1)) * at));
    }

    self.onmessage = (event) => {
      const { id, name, a, b, width, height, exposure } = event.data;
      const count = width * height;
      const known = new Uint8Array(count);
      const finite = (image, i) => Number.isFinite(image[3 * i]) && Number.isFinite(image[3 * i + 1]) && Number.isFinite(image[3 * i + 2]);
      // A pixel that is not finite in one image has the color of the other, and is black where it is finite in neither.
      for (let i = 0; i < count; i++) {
        const [own, other] = [finite(a, i), finite(b, i)];
        known[i] = own && other ? 1 : 0;
        if (known[i]) continue;
        for (let c = 3 * i; c < 3 * i + 3; c++) {
          const value = own ? a[c] : other ? b[c] : 0;
          a[c] = value;
          b[c] = value;
        }
      }
      const found = new Float32Array(count);
      if (name === "flip") {
        const gain = Math.pow(2, exposure);
        raise(found, a, b, width, height, (value) => clamp(value * gain));
      } else {
        const gains = exposures(a, known);
        if (gains === null) {
          found.fill(b.every((value) => value <= 0) ? 0 : NaN);
        } else {
          for (const gain of gains) {
            raise(found, a, b, width, height, (value) => {
              const x = Math.min(Math.max(value * gain, 0), 1e6);
              return Math.min((x * (F[0] * x + F[1])) / (x * (F[2] * x + F[3]) + F[4]), 1);
            });
          }
        }
      }
      for (let i = 0; i < count; i++) if (!known[i]) found[i] = NaN;
      self.postMessage({ id, map: found }, [found.buffer]);
    };
  }

  let running = null;
  let next = 0;
  const waiting = new Map();

  function start() {
    const text = `"use strict";(${worker.toString()})();`;
    running = new Worker(URL.createObjectURL(new Blob([text], { type: "text/javascript" })));
    running.onmessage = (event) => {
      const done = waiting.get(event.data.id);
      waiting.delete(event.data.id);
      if (done) done(event.data.map);
    };
  }

  /** The map of a pair, some time later. */
  ltsc.flip = (name, a, b, width, height, exposure) =>
    new Promise((resolve) => {
      if (!running) start();
      const id = next++;
      waiting.set(id, resolve);
      running.postMessage({ id, name, a: a.slice(), b: b.slice(), width, height, exposure });
    });
}
