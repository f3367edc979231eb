// What the graphics processor computes for each pixel of the screen. The formulas are those of maths.js, in single precision.
"use strict";

{
  /** Maps that the shader knows, by their number in it. */
  ltsc.MAPS = ["signed", "absolute", "relative", "squared", "relative-squared", "mape", "smape", "relative-squared-fixed", "mape-fixed", "smape-fixed", "ssim"];

  ltsc.VERTEX = `#version 300 es
void main() {
  vec2 corner = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);
  gl_Position = vec4(corner * 2.0 - 1.0, 0.0, 1.0);
}`;

  /** The program of one kind of drawing: what does not change while it is looked at is a constant, so that only what is needed is computed. */
  ltsc.fragment = ({ kind, map, tone, taps, raw }) => `#version 300 es
precision highp float;
precision highp int;
precision highp sampler2D;
// Images: colors, and 1 where all three are finite. A map that was computed elsewhere: its value, and 1 where it has one.
uniform sampler2D uA, uB, uM;
uniform vec2 uSize;
uniform float uScaleA, uScaleB;
// 0 A, 1 B, 2 a map, 3 a map computed elsewhere, 4 A beside B.
const int uKind = ${kind}, uMap = ${map};
uniform vec3 uGuard;
uniform float uShown;
// What is shown: gain, tone (0 sRGB, 1 gamma, 2 false colors, 3 signed, 4 share), channel (0 all, 1 2 3, 4 luminance).
uniform float uGain, uGamma;
const int uTone = ${tone};
uniform int uChannel;
uniform vec3 uRange;
uniform vec3 uColors[10];
uniform bool uFlip;
// From the screen to pixels: the upper left corner, pixels a step, samples along each side of a step.
uniform vec2 uOrigin;
uniform float uStep, uHeight, uSplit;
const int uTaps = ${taps};
const bool uRaw = ${raw};
out vec4 result;

const vec3 LUMINANCE = vec3(0.2126, 0.7152, 0.0722);

float srgb(float x) {
  float v = clamp(x, 0.0, 1.0);
  return v <= 0.0031308 ? 12.92 * v : 1.055 * pow(v, 1.0 / 2.4) - 0.055;
}
vec4 ofA(vec2 p) { return texelFetch(uA, ivec2(floor(p * uScaleA)), 0); }
vec4 ofB(vec2 p) { return texelFetch(uB, ivec2(floor(p * uScaleB)), 0); }
float mean(vec3 v) { return (v.r + v.g + v.b) / 3.0; }
float signedLength(vec3 d) {
  float size = length(d);
  return size == 0.0 || d.r + d.g + d.b > 0.0 ? size : -size;
}
float quotient(float over, float under) { return under > 0.0 ? over / under : 0.0; }
float guarded(vec3 over, vec3 under) {
  float sum = 0.0, count = 0.0;
  for (int c = 0; c < 3; c++) {
    if (uGuard[c] < 0.0) continue;
    sum += over[c] / under[c];
    count += 1.0;
  }
  return sum / count;
}
float shown(vec3 color) { return srgb(dot(LUMINANCE, clamp(color * uShown, 0.0, 1.0))); }

// Structural similarity; sums are of differences from the middle, whose squares single precision holds better.
float ssim(vec2 p) {
  vec2 middle = vec2(shown(ofA(p).rgb), shown(ofB(p).rgb));
  float n = 0.0, ab = 0.0;
  vec2 sum = vec2(0.0), squares = vec2(0.0);
  for (int v = -2; v <= 2; v++) {
    for (int u = -2; u <= 2; u++) {
      vec2 q = floor(p) + vec2(float(u), float(v)) + 0.5;
      if (q.x < 0.0 || q.y < 0.0 || q.x >= uSize.x || q.y >= uSize.y) continue;
      vec4 a = ofA(q), b = ofB(q);
      if (a.a * b.a < 0.5) continue;
      vec2 s = vec2(shown(a.rgb), shown(b.rgb)) - middle;
      n += 1.0;
      sum += s;
      squares += s * s;
      ab += s.x * s.y;
    }
  }
  vec2 off = sum / n;
  vec2 variance = max(squares / n - off * off, 0.0);
  float most = sqrt(variance.x * variance.y);
  float both = clamp(ab / n - off.x * off.y, -most, most);
  vec2 m = middle + off;
  return (2.0 * m.x * m.y + 1e-4) / (m.x * m.x + m.y * m.y + 1e-4) * (2.0 * both + 9e-4) / (variance.x + variance.y + 9e-4);
}

// The value of the map, and whether there is one.
vec2 mapped(vec2 p) {
  if (uKind == 3) return texelFetch(uM, ivec2(floor(p)), 0).rg;
  vec4 A = ofA(p), B = ofB(p);
  if (A.a * B.a < 0.5) return vec2(0.0);
  vec3 a = A.rgb, b = B.rgb, d = b - a, size = abs(a), both = abs(a) + abs(b);
  float value = 0.0;
  if (uMap == 0) value = signedLength(d);
  else if (uMap == 1) value = length(d);
  else if (uMap == 2) value = signedLength(d / mix(size, vec3(1.0), equal(a, vec3(0.0))));
  else if (uMap == 3) value = mean(d * d);
  else if (uMap == 4 || uMap == 5) {
    if (max(uGuard.r, max(uGuard.g, uGuard.b)) < 0.0) return vec2(0.0);
    value = uMap == 4 ? guarded(d * d, a * a + uGuard * uGuard) : guarded(abs(d), size + uGuard);
  }
  else if (uMap == 6) value = mean(vec3(quotient(2.0 * abs(d.r), both.r), quotient(2.0 * abs(d.g), both.g), quotient(2.0 * abs(d.b), both.b)));
  else if (uMap == 7) value = mean(d * d / (a * a + 1e-4));
  else if (uMap == 8) value = mean(abs(d) / (size + 0.01));
  else if (uMap == 9) value = mean(2.0 * abs(d) / (both + 0.02));
  else value = ssim(p);
  return vec2(value, 1.0);
}

vec3 table(float share) {
  float t = clamp(share, 0.0, 1.0) * 9.0;
  int at = int(min(floor(t), 8.0));
  return mix(uColors[at], uColors[at + 1], t - float(at));
}

vec3 toned(vec3 color) {
  vec3 v = color;
  if (uChannel == 4) v = vec3(dot(LUMINANCE, color));
  else if (uChannel > 0) v = vec3(color[uChannel - 1]);
  if (uTone == 2) {
    float y = uChannel == 0 ? dot(LUMINANCE, color) : v.r;
    float share = uRange.z > 0.5 ? (log2(max(y, 1e-37)) - uRange.x) / (uRange.y - uRange.x) : (y - uRange.x) / (uRange.y - uRange.x);
    return table(share);
  }
  v *= uGain;
  if (uTone == 1) return pow(clamp(v, 0.0, 1.0), vec3(1.0 / uGamma));
  return vec3(srgb(v.r), srgb(v.g), srgb(v.b));
}

vec3 colored(float value) {
  if (uTone == 3) {
    float v = srgb(abs(value) * uGain);
    return value > 0.0 ? vec3(0.0, v, 0.0) : vec3(v, 0.0, 0.0);
  }
  return table((uFlip ? 1.0 - value : value) * uGain);
}

void main() {
  vec2 screen = vec2(gl_FragCoord.x, uRaw ? gl_FragCoord.y : uHeight - gl_FragCoord.y);
  bool second = uKind == 1 || (uKind == 4 && screen.x >= uSplit);
  bool image = uKind < 2 || uKind == 4;
  vec3 sum = vec3(0.0);
  float count = 0.0;
  bool bad = false;
  for (int v = 0; v < uTaps; v++) {
    for (int u = 0; u < uTaps; u++) {
      vec2 p = uOrigin + (screen - 0.5 + (vec2(float(u), float(v)) + 0.5) / float(uTaps)) * uStep;
      if (p.x < 0.0 || p.y < 0.0 || p.x >= uSize.x || p.y >= uSize.y) continue;
      if (image) {
        vec4 color = second ? ofB(p) : ofA(p);
        bad = bad || color.a < 0.5;
        sum += color.rgb;
      } else {
        vec2 value = mapped(p);
        bad = bad || value.y < 0.5;
        sum.r += value.x;
      }
      count += 1.0;
    }
  }
  if (count == 0.0) { result = vec4(0.0); return; }
  sum /= count;
  if (uRaw) { result = vec4(sum, bad ? 0.0 : 1.0); return; }
  // What is not finite has a color that nothing else has.
  result = vec4(bad ? vec3(0.0, 0.0, 1.0) : image ? toned(sum) : colored(sum.r), 1.0);
}`;
}
