// Turns the figures of a report into ones that zoom: drag to zoom in, double click to see everything again.
// Each figure holds its data as JSON; `#zoom=all` in the address opens all of them. No script, or paper: the SVG.
(function () {
  "use strict";
  const { INK, ticks, text, labels, draw } = FIGURE, NEAR = 24;

  // The point nearest to the cursor, in words.
  function nearest(u, p) {
    let best = NEAR * NEAR, said = "";
    p.series.forEach((s, k) => u.series[p.first[k] + 1].show && s.x.forEach((x, i) => {
      const d = Math.pow(u.valToPos(x, "x") - u.cursor.left, 2) + Math.pow(u.valToPos(s.y[i], "y") - u.cursor.top, 2);
      if (d < best) { best = d; said = s.label + ": " + p.x.label + " " + text(x) + ", " + p.y.label + " " + text(s.y[i]) + (s.u.length ? " \u00b1 " + text(s.u[i]) : ""); }
    }));
    return said;
  }

  // Long lists hold the differences between decimal fractions: places `p`, differences `d`.
  function numbers(list) {
    if (!list || Array.isArray(list)) return list || [];
    const unit = Number("1e" + list.p);
    let sum = 0;
    return list.d.map((d) => (sum += d) / unit);
  }

  function open(figure, data) {
    data.panels.forEach((p) => {
      // Empty lists are left out of the page.
      ["rows", "spans", "limits", "masks", "circles", "marks", "notes"].forEach((k) => { p[k] = p[k] || []; });
      p.series.forEach((s) => ["x", "y", "u"].forEach((k) => { s[k] = numbers(s[k]); }));
      // Pieces of one line stand in the legend once, and are shown and hidden together.
      p.first = p.series.map((s) => p.series.findIndex((o) => o.label === s.label && o.style === s.style));
    });
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
      const rows = p.rows, scale = (s) => ({ dir: rows.length && s === p.y ? -1 : 1, time: false, auto: false, distr: s.log ? 3 : 1, min: s.range[0], max: s.range[1], range: (u, a, b) => [a, b] });
      const axis = (s, side, room) => ({ side, label: s.label, labelSize: 20, size: side === 3 ? Math.max(64, ...rows.map((n) => 7 * n.length + 30)) : 32, font: "12px Helvetica, Arial, sans-serif", labelFont: "12px Helvetica, Arial, sans-serif", stroke: INK, grid: { stroke: "#ddd", width: 1 }, ticks: { show: false }, splits: (u, i, a, b) => ticks(a, b, s.log, s.turn, room), values: (u, v) => labels(u, v, s.log), filter: (u, v) => v });
      const x = Object.assign({}, p.x, { range: data.panels[0].x.range }), lines = p.height * 1.25 / 45, on = index === data.panels.length - 1;
      const bottom = on ? axis(x, 2, 9) : Object.assign(axis(x, 2, 9), { label: undefined, labelSize: 0, size: 6, values: (u, v) => v.map(() => "") });
      const u = new uPlot({
        width: width(), height: p.height * 1.25 + (on ? 62 : 16), scales: { x: scale(x), y: scale(p.y) }, axes: [bottom, rows.length ? Object.assign(axis(p.y, 3, lines), { splits: () => rows.map((n, i) => i + 1), values: () => rows }) : axis(p.y, 3, lines)],
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
      u.root.querySelectorAll(".u-series").forEach((row, i) => { if (p.first[i] !== i) row.style.display = "none"; });
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
