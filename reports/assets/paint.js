// Draws a panel of a figure onto the canvas of a uPlot, and says its ticks: what the SVG shows, at any scale.
const FIGURE = (function () {
  "use strict";
  const INK = "#1a1a1a", LIMIT = "#8b0000", GUIDE = "#4d4d4d";

  function ticks(low, high, log, turn, count) {
    const all = [], decades = Math.log10(high / low);
    if (log && decades > 0.7) {
      const every = Math.max(1, Math.ceil(decades / count));
      for (let d = Math.floor(Math.log10(low)); d <= Math.log10(high); d++)
        for (let k = 1; k < (every > 1 ? 2 : 10); k++) {
          const v = k * Math.pow(10, d);
          if (v >= low && v <= high && (every === 1 || d % every === 0)) all.push(v);
        }
      return all;
    }
    const raw = (high - low) / count, ten = Math.pow(10, Math.floor(Math.log10(raw)));
    let step = [1, 2, 5, 10].find((f) => f * ten >= raw * 0.85) * ten;
    if (turn && high - low >= 45) step = [15, 30, 45, 90, 180, 360].find((s) => s >= raw * 0.85) || step;
    for (let i = Math.ceil(low / step); i <= high / step; i++) all.push(i * step);
    return all;
  }
  function text(v) {
    const s = +v.toPrecision(6), a = Math.abs(s);
    return (a !== 0 && (a < 1e-3 || a >= 1e5) ? s.toExponential() : String(s)).replace(/-/g, "\u2212");
  }
  function labels(u, splits, log) {
    const few = splits.length < 24, decades = log && splits.length ? Math.log10(splits[splits.length - 1] / splits[0]) : 0;
    return splits.map((v) => {
      const lead = Math.round(v / Math.pow(10, Math.floor(Math.log10(v) + 1e-9)));
      return !log || decades <= 0.7 || lead === 1 || (few && (lead === 2 || lead === 5)) ? text(v) : "";
    });
  }

  // Draws a panel onto the canvas of its uPlot: the same things as the SVG, at the present scales.
  function draw(u, p) {
    const c = u.ctx, r = uPlot.pxRatio, b = u.bbox;
    const X = (v) => u.valToPos(v, "x", true), Y = (v) => u.valToPos(v, "y", true);
    const low = (v) => { const y = Y(v); return Number.isFinite(y) ? y : b.top + b.height; };
    const base = p.y.log ? b.top + b.height : Y(0);
    function stroke(colour, width, dash) { c.strokeStyle = colour; c.lineWidth = width * r; c.setLineDash((dash || []).map((d) => d * r)); c.stroke(); }
    function fill(colour, alpha) { c.globalAlpha = alpha; c.fillStyle = colour; c.fill(); c.globalAlpha = 1; }
    function line(points) {
      c.beginPath();
      points.forEach(([x, y]) => { if (Number.isFinite(x) && Number.isFinite(y)) c.lineTo(x, y); });
    }
    function circle(x, y, radius) {
      const rx = Math.abs(X(x + radius) - X(x)), ry = Math.abs(Y(y + radius) - Y(y));
      c.moveTo(X(x) + rx, Y(y));
      c.ellipse(X(x), Y(y), rx, ry, 0, 0, 2 * Math.PI);
    }
    function marker(shape, x, y) {
      const s = 3.4 * r, corner = { square: [[-1, -1], [1, -1], [1, 1], [-1, 1]], triangle: [[0, -1.25], [1.2, 1], [-1.2, 1]], diamond: [[0, -1.25], [1.25, 0], [0, 1.25], [-1.25, 0]] }[shape];
      if (!corner) { c.moveTo(x + s, y); c.arc(x, y, s, 0, 2 * Math.PI); return; }
      corner.forEach(([dx, dy], i) => (i ? c.lineTo(x + dx * s, y + dy * s) : c.moveTo(x + dx * s, y + dy * s)));
      c.closePath();
    }
    function name(label, x, y, colour, align) {
      c.font = 12 * r + "px Helvetica, Arial, sans-serif"; c.textAlign = align; c.textBaseline = "alphabetic";
      c.setLineDash([]); c.lineWidth = 3 * r; c.strokeStyle = "#fff"; c.lineJoin = "round"; c.strokeText(label, x, y); c.fillStyle = colour; c.fillText(label, x, y);
    }
    // A name beside a place: on the other side where it would run out of the picture.
    function beside(label, x, y, colour, room, left) {
      c.font = 12 * r + "px Helvetica, Arial, sans-serif";
      const width = room * r + c.measureText(label).width, right = left ? x - width < b.left : x + width < b.left + b.width;
      name(label, x + (right ? room : -room) * r, y, colour, right ? "left" : "right");
    }
    function errors(s) {
      c.beginPath();
      s.u.forEach((e, i) => {
        const x = X(s.x[i]), k = 3 * r, ends = [low(s.y[i] - e), Y(s.y[i] + e)];
        c.moveTo(x, ends[0]); c.lineTo(x, ends[1]);
        ends.forEach((y) => { c.moveTo(x - k, y); c.lineTo(x + k, y); });
      });
      stroke(s.colour, 0.9);
    }
    const paint = {
      band(s) { line(s.x.map((x, i) => [X(x), Y(s.y[i] + s.u[i])]).concat(s.x.map((x, i) => [X(x), low(s.y[i] - s.u[i])]).reverse())); c.closePath(); fill(s.colour, 0.18); },
      circles(s) { c.beginPath(); s.u.forEach((radius, i) => circle(s.x[i], s.y[i], radius)); fill(s.colour, 0.12); stroke(s.colour, 0.5); },
      histogram(s) { c.beginPath(); s.x.forEach((x, i) => { if (s.y[i]) { const l = X(x - s.u[i]), t = low(s.y[i]); c.rect(l, t, X(x + s.u[i]) - l, base - t); } }); fill(s.colour, 0.55); stroke(s.colour, 0.8); },
      bars(s) { c.beginPath(); if (p.rows.length) { s.x.forEach((x, i) => { c.moveTo(X(0), Y(s.y[i])); c.lineTo(X(x), Y(s.y[i])); }); c.globalAlpha = 0.55; stroke(s.colour, 9); c.globalAlpha = 1; return; } s.x.forEach((x, i) => { c.moveTo(X(x), base); c.lineTo(X(x), low(s.y[i])); }); stroke(s.colour, 2); errors(s); },
      line(s) { line(s.x.map((x, i) => [X(x), Y(s.y[i])])); stroke(s.colour, 1.4, s.dash ? s.dash.split(" ").map(Number) : []); },
      markers(s) { errors(s); c.beginPath(); s.x.forEach((x, i) => marker(s.shape, X(x), Y(s.y[i]))); fill(s.hollow ? "#fff" : s.colour, 1); stroke(s.colour, 1.1); },
    };
    paint.fit = paint.line; paint.excluded = paint.markers;
    c.save(); c.beginPath(); c.rect(b.left, b.top, b.width, b.height); c.clip();
    p.spans.forEach((k) => { c.beginPath(); c.rect(X(k.at[0]), b.top, X(k.at[1]) - X(k.at[0]), b.height); fill(GUIDE, 0.14); });
    p.spans.filter((k, i) => p.spans.findIndex((o) => o.label === k.label) === i).forEach((k, row) => beside(k.label, Math.max(X(k.at[0]), b.left), b.top + b.height - (6 + 14 * row) * r, GUIDE, 3));
    p.circles.forEach((o) => { c.beginPath(); circle(o.at[0], o.at[1], o.radius); if (o.forbidden) fill(LIMIT, 0.1); stroke(o.forbidden ? LIMIT : GUIDE, o.forbidden ? 1.6 : 1, o.forbidden ? [] : [3, 3]); name(o.label, X(o.at[0]), Y(o.at[1] + o.radius) - 4 * r, o.forbidden ? LIMIT : GUIDE, "center"); });
    ["band", "circles", "bars", "histogram", "line", "fit", "excluded", "markers"].forEach((style) =>
      p.series.forEach((s, i) => { if (s.style === style && u.series[p.first[i] + 1].show) paint[style](s); }));
    p.marks.forEach((k, row) => { line([[X(k.at[0]), b.top], [X(k.at[0]), b.top + b.height]]); stroke(GUIDE, 1, [2, 2]); beside(k.label, X(k.at[0]), b.top + 13 * (1 + row % 4) * r, GUIDE, 4); });
    p.limits.forEach((l) => { const e = l.x ? l.x.map(X).map((x, i) => (Number.isFinite(x) ? x : b.left + i * b.width)) : [b.left, b.left + b.width]; line([[e[0], Y(l.y)], [e[1], Y(l.y)]]); stroke(LIMIT, 1.6, [10, 3, 2, 3]); name(l.label, Math.min(e[1], b.left + b.width) - 4 * r, Y(l.y) + (Y(l.y) < b.top + 18 * r ? 14 : -4) * r, LIMIT, "right"); });
    p.masks.forEach((k) => {
      const at = k.points.map(([x, y]) => [X(x), Y(y)]), edge = k.above ? b.top : b.top + b.height, last = at[at.length - 1];
      line(at.concat([[last[0], edge], [at[0][0], edge]])); c.closePath(); fill(LIMIT, 0.1); line(at); stroke(LIMIT, 1.6);
      // The label stands where the curve comes into sight.
      const i = Math.max(0, at.findIndex(([x]) => x > b.left) - 1), a = at[i], e = at[i + 1] || a;
      const x = Math.max(a[0], b.left), y = e[0] > a[0] ? a[1] + ((e[1] - a[1]) * (x - a[0])) / (e[0] - a[0]) : a[1];
      if (last[0] > b.left && at[0][0] < b.left + b.width) name(k.label, x + 6 * r, y + (k.above ? -6 : 15) * r, LIMIT, "left");
    });
    p.notes.forEach((n) => { const x = X(n.at[0]), y = Y(n.at[1]), s = 5 * r; c.beginPath(); c.moveTo(x - s, y); c.lineTo(x + s, y); c.moveTo(x, y - s); c.lineTo(x, y + s); stroke(INK, 1.6); beside(n.label, x, p.rows.length ? y + 4 * r : y - s, INK, 6, p.rows.length && n.at[0] < 0); });
    c.restore();
  }
  return { INK, ticks, text, labels, draw };
})();
