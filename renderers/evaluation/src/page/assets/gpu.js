// Drawing by WebGL 2: one context for all panes, which are copied from it. Textures hold what the store holds.
"use strict";

{
  let gl = null;
  let canvas = null;
  let vertex = null;
  let broken = false;
  const programs = new Map();
  const textures = new Map();
  const maps = new Map();

  function compile(type, text) {
    const shader = gl.createShader(type);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS) && !gl.isContextLost()) {
      throw new Error(gl.getShaderInfoLog(shader));
    }
    return shader;
  }

  /** The program that draws so, and where its settings are; made when it is first needed. */
  function programOf({ kind, map, tone, taps, raw }) {
    const what = { kind, map: kind === 2 ? map : 0, tone, taps, raw: Boolean(raw) };
    const key = Object.values(what).join();
    if (programs.has(key)) return programs.get(key);
    const program = gl.createProgram();
    gl.attachShader(program, vertex);
    gl.attachShader(program, compile(gl.FRAGMENT_SHADER, ltsc.fragment(what)));
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) throw new Error(gl.getProgramInfoLog(program));
    const places = {};
    const count = gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS);
    for (let i = 0; i < count; i++) {
      const { name } = gl.getActiveUniform(program, i);
      places[name.replace("[0]", "")] = gl.getUniformLocation(program, name);
    }
    programs.set(key, { program, places });
    return programs.get(key);
  }

  /** From now on the processor draws. */
  function give_up(error) {
    ltsc.errors.push(`WebGL: ${error}`);
    broken = true;
    gl = null;
  }

  /** Makes the context; false where there is none, or it cannot do what is needed. */
  function start() {
    if (broken) return false;
    if (gl) return !gl.isContextLost();
    try {
      canvas = ltsc.el("canvas", {});
      gl = canvas.getContext("webgl2", { antialias: false, depth: false, alpha: true, premultipliedAlpha: false });
      if (!gl) return false;
      vertex = compile(gl.VERTEX_SHADER, ltsc.VERTEX);
      programOf({ kind: 0, map: 0, tone: 0, taps: 1, raw: false });
      gl.bindVertexArray(gl.createVertexArray());
      canvas.addEventListener("webglcontextlost", () => {
        gl = null;
        textures.clear();
        maps.clear();
        programs.clear();
      });
      return true;
    } catch (error) {
      give_up(error);
      return false;
    }
  }

  function texture(width, height, format) {
    const made = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, made);
    gl.texStorage2D(gl.TEXTURE_2D, 1, format, width, height);
    for (const name of ["MIN", "MAG"]) gl.texParameteri(gl.TEXTURE_2D, gl[`TEXTURE_${name}_FILTER`], gl.NEAREST);
    for (const name of ["S", "T"]) gl.texParameteri(gl.TEXTURE_2D, gl[`TEXTURE_WRAP_${name}`], gl.CLAMP_TO_EDGE);
    return made;
  }

  /** Brings what has changed of an image into its texture. Numbers that are not finite stay here: shaders treat them as they like. */
  function upload(of) {
    let known = textures.get(of);
    if (!known) {
      known = { texture: texture(of.width, of.height, gl.RGBA32F), version: -1, at: 0 };
      textures.set(of, known);
    }
    if (known.version === of.version) return known.texture;
    gl.bindTexture(gl.TEXTURE_2D, known.texture);
    for (const [x, y, w, h] of of.dirty.slice(known.at)) {
      const some = new Float32Array(4 * w * h);
      for (let row = 0; row < h; row++) {
        let from = 3 * ((y + row) * of.width + x);
        let to = 4 * row * w;
        for (let i = 0; i < w; i++, from += 3, to += 4) {
          const r = of.array[from];
          const g = of.array[from + 1];
          const b = of.array[from + 2];
          // What is finite is 0 less itself; this loop is the longest of the page.
          if (r - r === 0 && g - g === 0 && b - b === 0) {
            some[to] = r;
            some[to + 1] = g;
            some[to + 2] = b;
            some[to + 3] = 1;
          }
        }
      }
      gl.texSubImage2D(gl.TEXTURE_2D, 0, x, y, w, h, gl.RGBA, gl.FLOAT, some);
    }
    known.at = of.dirty.length;
    known.version = of.version;
    return known.texture;
  }

  function uploadMap(map, width, height) {
    if (maps.has(map)) return maps.get(map);
    if (maps.size > 8) {
      const [oldest] = maps.keys();
      gl.deleteTexture(maps.get(oldest));
      maps.delete(oldest);
    }
    const made = texture(width, height, gl.RG32F);
    const some = new Float32Array(2 * width * height);
    for (let i = 0; i < map.length; i++) {
      if (Number.isNaN(map[i])) continue;
      some[2 * i] = map[i];
      some[2 * i + 1] = 1;
    }
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, width, height, gl.RG, gl.FLOAT, some);
    maps.set(map, made);
    return made;
  }

  /** Frees the texture of an image that is no longer kept. */
  function forget(of) {
    const known = textures.get(of);
    if (known && gl) gl.deleteTexture(known.texture);
    textures.delete(of);
  }

  /** Sets everything for one drawing of `job`, whose sizes are those of the screen. */
  function prepare(job) {
    const { a, b } = job;
    const { program, places } = programOf(job);
    gl.useProgram(program);
    const bind = (unit, name, made) => {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, made);
      gl.uniform1i(places[name], unit);
    };
    const of = [a || b, b || a].map(upload);
    const map = job.values ? uploadMap(job.values, job.size[0], job.size[1]) : null;
    bind(0, "uA", of[0]);
    bind(1, "uB", of[1]);
    bind(2, "uM", map || of[0]);
    gl.uniform2f(places.uSize, job.size[0], job.size[1]);
    gl.uniform1f(places.uScaleA, 1 / (a || b).factor);
    gl.uniform1f(places.uScaleB, 1 / (b || a).factor);
    gl.uniform3fv(places.uGuard, job.guards || [-1, -1, -1]);
    gl.uniform1f(places.uShown, job.shown);
    gl.uniform1f(places.uGain, job.gain);
    gl.uniform1f(places.uGamma, job.gamma);
    gl.uniform1i(places.uChannel, job.channel);
    gl.uniform3fv(places.uRange, job.range);
    gl.uniform3fv(places.uColors, ltsc.maths.TABLES[job.table].flat());
    gl.uniform1i(places.uFlip, job.flip ? 1 : 0);
    gl.uniform2f(places.uOrigin, job.origin[0], job.origin[1]);
    gl.uniform1f(places.uStep, job.step);
    gl.uniform1f(places.uHeight, job.height);
    gl.uniform1f(places.uSplit, job.split);
  }

  /** Draws into the context of a pane. */
  function draw(context, job) {
    if (canvas.width < job.width) canvas.width = job.width;
    if (canvas.height < job.height) canvas.height = job.height;
    try {
      prepare(job);
    } catch (error) {
      give_up(error);
      ltsc.cpu.draw(context, job);
      return;
    }
    gl.viewport(0, 0, job.width, job.height);
    gl.disable(gl.BLEND);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    context.clearRect(0, 0, job.width, job.height);
    context.drawImage(canvas, 0, canvas.height - job.height, job.width, job.height, 0, 0, job.width, job.height);
  }

  /** The numbers behind a drawing, as the processor computed them: four for each pixel, the last one whether there is a value. */
  function read(job) {
    if (!gl.getExtension("EXT_color_buffer_float")) return null;
    const { width, height } = job;
    const target = texture(width, height, gl.RGBA32F);
    const buffer = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, buffer);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, target, 0);
    // Last: a texture that is made takes the place of one that is bound.
    try {
      prepare({ ...job, raw: true });
    } catch (error) {
      give_up(error);
      return null;
    }
    gl.viewport(0, 0, width, height);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    const out = new Float32Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.FLOAT, out);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.deleteFramebuffer(buffer);
    gl.deleteTexture(target);
    return out;
  }

  /** Whether an image fits into a texture. */
  const fits = (width, height) => start() && Math.max(width, height) <= gl.getParameter(gl.MAX_TEXTURE_SIZE);

  ltsc.gpu = { start, draw, read, fits, forget };
}
