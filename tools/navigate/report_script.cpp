// Style and script of the report: plain canvas drawing, no library, no network.
#include "tools/navigate/report_page.hpp"

namespace kawara::navigate {

const char* const kReportStyle = R"css(
:root { color-scheme: light; }
body { font: 14px/1.4 system-ui, sans-serif; margin: 1rem auto; max-width: 1500px; padding: 0 1rem; color: #1d2733; background: #fff; }
h1 { font-size: 1.2rem; margin: 0 0 .3rem; overflow-wrap: anywhere; }
h2 { font-size: 1rem; margin: 1rem 0 .3rem; }
#legend { display: flex; flex-wrap: wrap; gap: .2rem 1rem; margin-bottom: .5rem; color: #445; }
#legend i { display: inline-block; width: .8em; height: .8em; border-radius: 2px; margin-right: .35em; vertical-align: -.05em; }
#page { display: grid; grid-template-columns: minmax(320px, 2fr) 3fr; gap: 1rem; align-items: start; }
#page > div { min-width: 0; }
@media (max-width: 900px) { #page { grid-template-columns: 1fr; } }
canvas { display: block; width: 100%; touch-action: pan-y; }
#panels canvas { cursor: crosshair; }
.cap { display: flex; justify-content: space-between; gap: 1rem; font-size: 12px; margin: .45rem 0 .1rem; }
.cap b { white-space: nowrap; }
.cap span { color: #556; white-space: nowrap; overflow: hidden; font-variant-numeric: tabular-nums; }
pre { background: #f5f7f9; border: 1px solid #dde3ea; border-radius: 4px; padding: .7rem; overflow-x: auto; font-size: 11px; }
.none { padding: 2rem; background: #f5f7f9; }
)css";

const char* const kReportScript = R"js(
const COLOURS = ['#999999', '#9aa5b1', '#d62728', '#8e44ad', '#d2691e', '#e0a800', '#2e9e5b'];  // by state
const AXES = ['#1f6fc4', '#d9642b', '#3a9d3a'];
const ROLES = ['given', 'held out', 'blanked'];
const FIXES = ['none', 'autonomous', 'dgps', 'float', 'fixed', 'dead-reckoning'];
const end = D.t.length ? D.t[D.t.length - 1] : 1;
const full = [D.t.length ? Math.min(D.t[0], D.ft.length ? D.ft[0] : D.t[0]) : 0, Math.max(end, D.ft.length ? D.ft[D.ft.length - 1] : end)];
let range = full.slice(), hover = null, drag = null;
const panels = [];

function element(parent, tag, html) {
  const e = document.createElement(tag);
  if (html !== undefined) e.innerHTML = html;
  parent.appendChild(e);
  return e;
}
function first(array, t) {  // index of the first that is not before t
  let a = 0, b = array.length;
  while (a < b) { const m = (a + b) >> 1; if (array[m] < t) a = m + 1; else b = m; }
  return a;
}
function nearest(array, t) {
  const i = first(array, t);
  if (i === 0) return 0;
  return i === array.length || t - array[i - 1] < array[i] - t ? i - 1 : i;
}
function ticks(lo, hi, most) {
  const raw = (hi - lo) / most, p = Math.pow(10, Math.floor(Math.log10(raw)));
  const step = [1, 2, 5, 10].map(k => k * p).find(s => s >= raw * 0.999);
  const out = [];
  for (let k = Math.ceil(lo / step); k * step <= hi + step * 1e-9; k++) out.push(k * step);
  return {at: out, digits: Math.max(0, -Math.floor(Math.log10(step) + 1e-9))};
}
function prepare(canvas, height) {
  const ratio = window.devicePixelRatio || 1, width = canvas.clientWidth;
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  canvas.style.height = height + 'px';
  const c = canvas.getContext('2d');
  c.setTransform(ratio, 0, 0, ratio, 0, 0);
  c.clearRect(0, 0, width, height);
  c.font = '11px system-ui, sans-serif';
  c.lineJoin = 'round';
  return {c, width, height};
}
const LEFT = 52, RIGHT = 8, TOP = 4, BOTTOM = 18;

// One panel over time: series {name, colour, t, y, dots, keep}; options {log, unit, digits, turn}.
function panel(title, series, options) {
  const caption = element(document.getElementById('panels'), 'div');
  caption.className = 'cap';
  element(caption, 'b').textContent = title;
  const values = element(caption, 'span');
  const canvas = element(document.getElementById('panels'), 'canvas');
  const p = {canvas, values, draw, options, series};
  panels.push(p);
  listen(p);

  function bounds() {
    let lo = Infinity, hi = -Infinity;
    for (const s of series) {
      const a = Math.max(0, first(s.t, range[0]) - 1), b = Math.min(s.t.length, first(s.t, range[1]) + 1);
      const seen = [];
      for (let i = a; i < b; i++) if (s.y[i] !== null && (!options.log || s.y[i] > 0)) seen.push(s.y[i]);
      if (s.dots && seen.length > 50) {  // a few far ones must not hide the rest
        seen.sort((x, y) => x - y);
        lo = Math.min(lo, seen[Math.floor(seen.length * .005)] * 1.3);
        hi = Math.max(hi, seen[Math.floor(seen.length * .995)] * 1.3);
      } else for (const y of seen) { if (y < lo) lo = y; if (y > hi) hi = y; }
    }
    if (!(hi >= lo)) return [0, 1];
    if (options.log) return [lo / 1.2, hi * 1.2];
    const spare = Math.max((hi - lo) * .06, options.least || 1e-3);
    return [lo - spare, hi + spare];
  }
  function draw() {
    const {c, width, height} = prepare(canvas, options.height || 118);
    p.width = width;
    const [lo, hi] = bounds(), f = options.log ? Math.log10 : (x => x), flo = f(lo), fhi = f(hi);
    const X = t => LEFT + (t - range[0]) / (range[1] - range[0]) * (width - LEFT - RIGHT);
    const Y = y => height - BOTTOM - (f(y) - flo) / (fhi - flo) * (height - TOP - BOTTOM);
    shade(c, X, TOP, height - BOTTOM);
    c.strokeStyle = '#e3e8ee'; c.fillStyle = '#667'; c.textAlign = 'right'; c.textBaseline = 'middle'; c.lineWidth = 1;
    let marks, text;
    if (options.log) {
      marks = [];
      for (let d = Math.floor(flo); d <= fhi; d++) for (const k of fhi - flo > 1.7 ? [1] : [1, 2, 5]) {
        const y = k * Math.pow(10, d);
        if (y >= lo && y <= hi) marks.push(y);
      }
      text = y => String(+y.toPrecision(2));
    } else {
      const k = ticks(lo, hi, 5);
      marks = k.at; text = y => y.toFixed(k.digits);
    }
    for (const y of marks) {
      c.beginPath(); c.moveTo(LEFT, Y(y)); c.lineTo(width - RIGHT, Y(y)); c.stroke();
      c.fillText(text(y), LEFT - 5, Y(y));
    }
    timeAxis(c, X, width, height);
    c.save();
    c.beginPath(); c.rect(LEFT, 0, width - LEFT - RIGHT, height - BOTTOM); c.clip();
    for (const s of series) {
      const a = Math.max(0, first(s.t, range[0]) - 1), b = Math.min(s.t.length, first(s.t, range[1]) + 1);
      c.strokeStyle = c.fillStyle = s.colour;
      if (s.dots) {
        for (let i = a; i < b; i++) if (s.y[i] !== null) c.fillRect(X(s.t[i]) - 1, Y(s.y[i]) - 1, 2, 2);
        continue;
      }
      c.lineWidth = 1.2;
      c.beginPath();
      let down = false;
      for (let i = a; i < b; i++) {
        const jump = down && (s.t[i] - s.t[i - 1] > 2 || (options.turn && Math.abs(s.y[i] - s.y[i - 1]) > options.turn / 2));
        if (!down || jump) c.moveTo(X(s.t[i]), Y(s.y[i])); else c.lineTo(X(s.t[i]), Y(s.y[i]));
        down = true;
      }
      c.stroke();
    }
    c.restore();
    cursor(c, X, TOP, height - BOTTOM);
    values.innerHTML = series.map(s => {
      let v = '';
      if (hover !== null && s.t.length) { const i = nearest(s.t, hover); if (Math.abs(s.t[i] - hover) < 3 && s.y[i] !== null) v = ' ' + s.y[i].toFixed(options.digits); }
      return '<span style="color:' + s.colour + '">' + s.name + v + '</span>';
    }).join(' &nbsp; ') + ' ' + options.unit;
  }
  return p;
}
function shade(c, X, top, bottom) {
  c.fillStyle = 'rgba(90, 100, 120, .16)';
  for (const [a, b] of D.blanks) if (b > range[0] && a < range[1]) {
    const x = Math.max(LEFT, X(a));
    c.fillRect(x, top, Math.max(1, Math.min(X(range[1]), X(b)) - x), bottom - top);
  }
}
function timeAxis(c, X, width, height) {
  const k = ticks(D.t0 + range[0], D.t0 + range[1], Math.max(3, width / 90));
  c.textAlign = 'center'; c.textBaseline = 'top';
  for (const t of k.at) {
    const x = X(t - D.t0);
    c.strokeStyle = '#eef1f5'; c.fillStyle = '#667';
    c.beginPath(); c.moveTo(x, TOP); c.lineTo(x, height - BOTTOM); c.stroke();
    c.fillText(t.toFixed(k.digits), Math.min(x, width - 26), height - BOTTOM + 4);
  }
  c.strokeStyle = '#b8c2cd';
  c.strokeRect(LEFT, TOP, width - LEFT - RIGHT, height - TOP - BOTTOM);
}
function cursor(c, X, top, bottom) {
  if (drag) {
    c.fillStyle = 'rgba(31, 111, 196, .18)';
    c.fillRect(X(Math.min(...drag)), top, Math.abs(X(drag[1]) - X(drag[0])), bottom - top);
  }
  if (hover === null || hover < range[0] || hover > range[1]) return;
  c.strokeStyle = '#445'; c.lineWidth = .7;
  c.beginPath(); c.moveTo(X(hover), top); c.lineTo(X(hover), bottom); c.stroke();
}
function listen(p) {
  const time = event => {
    const box = p.canvas.getBoundingClientRect();
    const t = range[0] + (event.clientX - box.left - LEFT) / (box.width - LEFT - RIGHT) * (range[1] - range[0]);
    return Math.min(range[1], Math.max(range[0], t));
  };
  p.canvas.addEventListener('pointermove', e => { hover = time(e); if (drag) drag[1] = hover; redraw(); });
  p.canvas.addEventListener('pointerleave', () => { if (!drag) { hover = null; redraw(); } });
  p.canvas.addEventListener('pointerdown', e => { p.canvas.setPointerCapture(e.pointerId); drag = [time(e), time(e)]; });
  p.canvas.addEventListener('pointerup', () => {
    if (drag && Math.abs(drag[1] - drag[0]) > (range[1] - range[0]) * .01) range = [Math.min(...drag), Math.max(...drag)];
    drag = null; redraw();
  });
  p.canvas.addEventListener('dblclick', () => { range = full.slice(); redraw(); });
}

function statePanel() {
  const caption = element(document.getElementById('panels'), 'div');
  caption.className = 'cap';
  element(caption, 'b').textContent = 'State';
  const values = element(caption, 'span');
  const canvas = element(document.getElementById('panels'), 'canvas');
  const p = {canvas, values, draw() {
    const {c, width, height} = prepare(canvas, 46);
    const X = t => LEFT + (t - range[0]) / (range[1] - range[0]) * (width - LEFT - RIGHT);
    timeAxis(c, X, width, height);
    for (const [a, b, state] of D.spans) if (b >= range[0] && a <= range[1]) {
      c.fillStyle = COLOURS[state];
      const x = Math.max(LEFT, X(a));
      c.fillRect(x, TOP, Math.max(1, Math.min(width - RIGHT, X(b)) - x), height - TOP - BOTTOM);
    }
    cursor(c, X, TOP, height - BOTTOM);
    const at = hover === null ? null : D.spans.find(s => hover >= s[0] && hover <= s[1]);
    values.textContent = hover === null ? '' : 't ' + (D.t0 + hover).toFixed(2) + (at ? ': ' + D.states[at[2]] + ', ' + at[3] : '');
  }};
  panels.push(p);
  listen(p);
}

function plan() {
  const parent = document.getElementById('plan');
  const caption = element(parent, 'div');
  caption.className = 'cap';
  element(caption, 'b').textContent = 'Plan, metres north and east of the first position';
  const values = element(caption, 'span');
  const canvas = element(parent, 'canvas');
  panels.push({canvas, values, draw() {
    const {c, width, height} = prepare(canvas, Math.min(canvas.clientWidth, Math.max(300, window.innerHeight - 140)));
    const a = first(D.t, range[0]), b = Math.max(a + 1, first(D.t, range[1]));
    let n0 = Infinity, n1 = -Infinity, e0 = Infinity, e1 = -Infinity;
    for (let i = a; i < b && i < D.t.length; i++) {
      n0 = Math.min(n0, D.n[i]); n1 = Math.max(n1, D.n[i]); e0 = Math.min(e0, D.e[i]); e1 = Math.max(e1, D.e[i]);
    }
    if (!(n1 >= n0)) return;
    const w = width - LEFT - RIGHT, h = height - TOP - BOTTOM;
    const scale = Math.min(w / (e1 - e0 + .2), h / (n1 - n0 + .2)) * .92;
    const X = e => LEFT + w / 2 + (e - (e0 + e1) / 2) * scale, Y = n => TOP + h / 2 - (n - (n0 + n1) / 2) * scale;
    c.strokeStyle = '#e8ecf1'; c.fillStyle = '#667'; c.lineWidth = 1;
    const ke = ticks((e0 + e1) / 2 - w / 2 / scale, (e0 + e1) / 2 + w / 2 / scale, w / 80), kn = ticks((n0 + n1) / 2 - h / 2 / scale, (n0 + n1) / 2 + h / 2 / scale, h / 60);
    c.textAlign = 'center'; c.textBaseline = 'top';
    for (const e of ke.at) { c.beginPath(); c.moveTo(X(e), TOP); c.lineTo(X(e), TOP + h); c.stroke(); c.fillText(e.toFixed(ke.digits), X(e), TOP + h + 4); }
    c.textAlign = 'right'; c.textBaseline = 'middle';
    for (const n of kn.at) { c.beginPath(); c.moveTo(LEFT, Y(n)); c.lineTo(LEFT + w, Y(n)); c.stroke(); c.fillText(n.toFixed(kn.digits), LEFT - 5, Y(n)); }
    c.strokeStyle = '#b8c2cd'; c.strokeRect(LEFT, TOP, w, h);
    c.save(); c.beginPath(); c.rect(LEFT, TOP, w, h); c.clip();
    for (let i = first(D.ft, range[0]); i < D.ft.length && D.ft[i] <= range[1]; i++) {
      c.fillStyle = D.fr[i] === 0 ? (D.fq[i] === 4 ? '#9bb8d8' : '#e7c46a') : '#c2185b';
      const r = D.fr[i] === 0 ? 1.2 : 1.8;
      c.fillRect(X(D.fe[i]) - r, Y(D.fn[i]) - r, 2 * r, 2 * r);
    }
    c.lineWidth = 1.8;
    for (let i = a + 1; i < b && i < D.t.length; i++) {
      if (D.t[i] - D.t[i - 1] > 2) continue;
      c.strokeStyle = COLOURS[D.st[i]];
      c.beginPath(); c.moveTo(X(D.e[i - 1]), Y(D.n[i - 1]));
      while (i + 1 < b && i + 1 < D.t.length && D.st[i + 1] === D.st[i] && D.t[i + 1] - D.t[i] <= 2) { c.lineTo(X(D.e[i]), Y(D.n[i])); i++; }
      c.lineTo(X(D.e[i]), Y(D.n[i]));
      c.stroke();
    }
    if (hover !== null) {
      const i = nearest(D.t, hover), yaw = D.yaw[i] * Math.PI / 180, x = X(D.e[i]), y = Y(D.n[i]);
      c.fillStyle = '#111'; c.strokeStyle = '#fff'; c.lineWidth = 1.5;
      c.beginPath();
      for (const [k, [r, turn]] of [[11, 0], [8, 2.5], [8, -2.5]].entries()) {
        const px = x + r * Math.sin(yaw + turn), py = y - r * Math.cos(yaw + turn);
        if (k === 0) c.moveTo(px, py); else c.lineTo(px, py);
      }
      c.closePath(); c.fill(); c.stroke();
    }
    c.restore();
    values.textContent = hover === null ? '' : 'N ' + D.n[nearest(D.t, hover)].toFixed(2) + '  E ' + D.e[nearest(D.t, hover)].toFixed(2);
  }});
}
function redraw() {
  if (redraw.asked) return;
  redraw.asked = true;
  requestAnimationFrame(() => { redraw.asked = false; for (const p of panels) p.draw(); });
}
function legend() {
  const parent = document.getElementById('legend'), seen = new Set(D.spans.map(s => s[2]));
  for (let i = D.states.length - 1; i >= 0; i--) if (seen.has(i)) element(parent, 'span', '<i style="background:' + COLOURS[i] + '"></i>' + D.states[i]);
  if (D.fq.some((q, i) => q === 4 && !D.fr[i])) element(parent, 'span', '<i style="background:#9bb8d8"></i>GNSS, fixed');
  if (D.fq.some((q, i) => q !== 4 && !D.fr[i])) element(parent, 'span', '<i style="background:#e7c46a"></i>GNSS, not fixed');
  if (D.fr.some(r => r)) element(parent, 'span', '<i style="background:#c2185b"></i>GNSS, withheld');
  if (D.blanks.length) element(parent, 'span', '<i style="background:#d8dce2"></i>blanked');
  element(parent, 'span', '<small>drag over time to look closer, double click for all</small>');
}
if (D.t.length) {
  legend();
  plan();
  statePanel();
  const three = (names, keys, t, dots) => keys.map((k, i) => ({name: names[i], colour: AXES[i], t, y: D[k], dots}));
  panel('GNSS minus solution', three(['N', 'E', 'D'], ['rn', 're', 'rd'], D.ft, true), {unit: 'm', digits: 3, least: .005});
  panel('Standard deviation of position', three(['N', 'E', 'D'], ['sn', 'se', 'sd'], D.t), {unit: 'm', digits: 4, log: true});
  panel('Standard deviation of attitude', three(['roll', 'pitch', 'yaw'], ['sr', 'sp', 'sy'], D.t), {unit: 'deg', digits: 3, log: true});
  panel('Height above the ellipsoid', [{name: 'h', colour: AXES[0], t: D.t, y: D.h}], {unit: 'm', digits: 3, least: .05});
  panel('Velocity', three(['N', 'E', 'D'], ['vn', 've', 'vd'], D.t), {unit: 'm/s', digits: 3, least: .05});
  panel('Roll and pitch', three(['roll', 'pitch'], ['roll', 'pitch'], D.t), {unit: 'deg', digits: 2, least: .2});
  panel('Yaw', [{name: 'yaw', colour: AXES[2], t: D.t, y: D.yaw}], {unit: 'deg', digits: 2, turn: 360, least: .5});
  window.addEventListener('resize', redraw);
  redraw();
} else {
  element(document.getElementById('panels'), 'div', 'No solution: nothing to draw.').className = 'none';
}
)js";

}  // namespace kawara::navigate
