// Turns the pictures of a report into ones that zoom: drag to zoom in, double click to see everything again.
// Each figure holds its data as JSON; `#zoom=all` in the address opens all of them. No script, or paper: the SVG.
(function () {
  "use strict";
  const INK = "#1a1a1a", LIMIT = "#8b0000", GUIDE = "#4d4d4d", NEAR = 24;

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
    if (turn && high - low >= 90) step = [15, 30, 45, 90, 180, 360].find((s) => s >= raw * 0.85) || step;
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
      bars(s) { c.beginPath(); s.x.forEach((x, i) => { c.moveTo(X(x), base); c.lineTo(X(x), low(s.y[i])); }); stroke(s.colour, 2); errors(s); },
      line(s) { line(s.x.map((x, i) => [X(x), Y(s.y[i])])); stroke(s.colour, 1.4, s.dash ? s.dash.split(" ").map(Number) : []); },
      markers(s) { errors(s); c.beginPath(); s.x.forEach((x, i) => marker(s.shape, X(x), Y(s.y[i]))); fill(s.hollow ? "#fff" : s.colour, 1); stroke(s.colour, 1.1); },
    };
    paint.fit = paint.line; paint.excluded = paint.markers;
    c.save(); c.beginPath(); c.rect(b.left, b.top, b.width, b.height); c.clip();
    p.circles.forEach((o) => { c.beginPath(); circle(o.at[0], o.at[1], o.radius); if (o.forbidden) fill(LIMIT, 0.1); stroke(o.forbidden ? LIMIT : GUIDE, o.forbidden ? 1.6 : 1, o.forbidden ? [] : [3, 3]); });
    ["band", "circles", "bars", "histogram", "line", "fit", "excluded", "markers"].forEach((style) =>
      p.series.forEach((s, i) => { if (s.style === style && u.series[i + 1].show) paint[style](s); }));
    p.marks.forEach((k) => { line([[X(k.at[0]), b.top], [X(k.at[0]), b.top + b.height]]); stroke(GUIDE, 1, [2, 2]); name(k.label, X(k.at[0]) + 4 * r, b.top + 13 * r, GUIDE, "left"); });
    p.limits.forEach((l) => { const e = l.x ? l.x.map(X).map((x, i) => (Number.isFinite(x) ? x : b.left + i * b.width)) : [b.left, b.left + b.width]; line([[e[0], Y(l.y)], [e[1], Y(l.y)]]); stroke(LIMIT, 1.6, [10, 3, 2, 3]); name(l.label, Math.min(e[1], b.left + b.width) - 4 * r, Y(l.y) - 4 * r, LIMIT, "right"); });
    p.masks.forEach((k) => {
      const at = k.points.map(([x, y]) => [X(x), Y(y)]), edge = k.above ? b.top : b.top + b.height, last = at[at.length - 1];
      line(at.concat([[last[0], edge], [at[0][0], edge]])); c.closePath(); fill(LIMIT, 0.1); line(at); stroke(LIMIT, 1.6);
      name(k.label, Math.min(last[0], b.left + b.width) - 4 * r, last[1] + (k.above ? -6 : 14) * r, LIMIT, "right");
    });
    p.notes.forEach((n) => { const x = X(n.at[0]), y = Y(n.at[1]), s = 5 * r; c.beginPath(); c.moveTo(x - s, y); c.lineTo(x + s, y); c.moveTo(x, y - s); c.lineTo(x, y + s); stroke(INK, 1.6); name(n.label, x + s, y - s, INK, "left"); });
    c.restore();
  }
  // The point nearest to the cursor, in words.
  function nearest(u, p) {
    let best = NEAR * NEAR, said = "";
    p.series.forEach((s, k) => u.series[k + 1].show && s.x.forEach((x, i) => {
      const d = Math.pow(u.valToPos(x, "x") - u.cursor.left, 2) + Math.pow(u.valToPos(s.y[i], "y") - u.cursor.top, 2);
      if (d < best) { best = d; said = s.label + ": " + p.x.label + " " + text(x) + ", " + p.y.label + " " + text(s.y[i]) + (s.u.length ? " \u00b1 " + text(s.u[i]) : ""); }
    }));
    return said;
  }

  function open(figure, data) {
    const box = figure.insertBefore(document.createElement("div"), figure.querySelector("figcaption")), all = [];
    box.className = "zoomed";
    const width = () => Math.min(900, figure.clientWidth);
    // Ranges of a panel; the abscissa goes to all panels. Equal units stay equal: the narrower range grows.
    function show(u, p, x, y) {
      const grow = ([a, b], f) => [(a + b) / 2 - ((b - a) / 2) * f, (a + b) / 2 + ((b - a) / 2) * f];
      if (p.equal && !p.x.log && !p.y.log) {
        const f = (y[1] - y[0]) / (x[1] - x[0]) / (u.bbox.height / u.bbox.width);
        if (f > 1) x = grow(x, f); else y = grow(y, 1 / f);
      }
      u.setScale("y", { min: y[0], max: y[1] });
      all.forEach((other) => other.u.setScale("x", { min: x[0], max: x[1] }));
    }
    const whole = () => all.forEach(({ u, p }) => show(u, p, data.panels[0].x.range, p.y.range));
    const said = document.createElement("p");
    data.panels.forEach((p, index) => {
      const scale = (s) => ({ time: false, auto: false, distr: s.log ? 3 : 1, min: s.range[0], max: s.range[1], range: (u, a, b) => [a, b] });
      const axis = (s, side, room) => ({ side, label: s.label, labelSize: 20, size: side === 3 ? 64 : 32, font: "12px Helvetica, Arial, sans-serif", labelFont: "12px Helvetica, Arial, sans-serif", stroke: INK, grid: { stroke: "#ddd", width: 1 }, ticks: { show: false }, splits: (u, i, a, b) => ticks(a, b, s.log, s.turn, room), values: (u, v) => labels(u, v, s.log), filter: (u, v) => v });
      const x = Object.assign({}, p.x, { range: data.panels[0].x.range }), lines = p.height * 1.25 / 45, on = index === data.panels.length - 1;
      const bottom = on ? axis(x, 2, 9) : Object.assign(axis(x, 2, 9), { label: undefined, labelSize: 0, size: 6, values: (u, v) => v.map(() => "") });
      const u = new uPlot({
        width: width(), height: p.height * 1.25 + (on ? 62 : 16), scales: { x: scale(x), y: scale(p.y) }, axes: [bottom, axis(p.y, 3, lines)],
        legend: { live: false, markers: { width: 2, stroke: (v, i) => p.series[i - 1].colour, fill: (v, i) => (/^(line|fit|excluded)$/.test(p.series[i - 1].style) ? "#fff" : p.series[i - 1].colour), dash: (v, i) => (p.series[i - 1].dash ? "dashed" : "solid") } },
        cursor: { points: { show: false }, drag: { x: true, y: true, uni: 20, setScale: false }, bind: { dblclick: () => () => { whole(); return null; } } },
        series: [{}].concat(p.series.map((s) => ({ label: s.label, stroke: s.colour, width: 1, paths: () => null, points: { show: false } }))),
        hooks: {
          draw: [(v) => draw(v, p)],
          setCursor: [(v) => { if (v.cursor.left >= 0) said.textContent = nearest(v, p) || "Drag to zoom, double click to see everything."; }],
          setSelect: [(v) => {
            const s = v.select, X = (px) => v.posToVal(px, "x"), Y = (px) => v.posToVal(px, "y");
            if (s.width < 3 || s.height < 3) return;
            const to = [[X(s.left), X(s.left + s.width)], [Y(s.top + s.height), Y(s.top)]];
            v.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
            show(v, p, to[0], to[1]);
          }],
        },
      }, [x.range].concat(p.series.map(() => [null, null])), box);
      all.push({ u, p });
    });
    said.textContent = "Drag to zoom, double click to see everything.";
    box.appendChild(said);
    whole();
    window.addEventListener("resize", () => all.forEach(({ u }) => u.setSize({ width: width(), height: u.height })));
  }

  document.querySelectorAll("figure").forEach((figure) => {
    const json = figure.querySelector("script[type='application/json']"), picture = figure.querySelector("svg.plot");
    if (!json || !picture) return;
    const button = document.createElement("button");
    button.type = "button"; button.className = "zoom"; button.textContent = "Zoom";
    const toggle = () => {
      const now = figure.classList.toggle("open");
      if (now && !figure.querySelector(".zoomed")) open(figure, JSON.parse(json.textContent));
      button.textContent = now ? "Picture" : "Zoom";
    };
    button.addEventListener("click", toggle); picture.addEventListener("click", toggle);
    figure.querySelector("figcaption").appendChild(button);
    if (/[#?&]zoom=all\b/.test(location.search + location.hash)) toggle();
  });
})();
