"use strict";
// One panel: a uPlot in its mode for curves of any kind, each with its own x.

class Chart {
  // `on` has what the figure does: zoomed(chart, x, y), moved(chart), and back(chart).
  constructor(spec, columns, element, on) {
    Object.assign(this, { spec, element, on, cursor: null });
    const logs = [spec.x.log, spec.y.log];
    // The scale on which lengths are equal: of values or of their logarithms.
    this.to = logs.map(log => (log ? Math.log : v => v));
    this.from = logs.map(log => (log ? Math.exp : v => v));
    this.home = [spec.x.range, spec.y.range];
    this.size();
    this.view = this.home.map(range => [...range]);
    this.series = spec.series.map(s => {
      const [x, y] = [columns[s.x], columns[s.y]];
      const sorted = x.every((v, k) => v !== null && (k === 0 || v >= x[k - 1]));
      return { ...s, shown: true, sorted, data: [x, y] };
    });
    this.plot = new uPlot(this.options(), [null, ...this.series.map(s => s.data)], element);
    this.bind();
    this.publish();
  }

  options() {
    const { spec } = this;
    const scale = (k, log) => ({ time: false, auto: false, distr: log ? 3 : 1, range: () => this.view[k] });
    const font = "12px system-ui, Helvetica, Arial, sans-serif";
    const axis = (key, label) => ({
      scale: key,
      ...(spec[key].log ? { splits: logTicks, filter: (_, splits) => splits } : {}),
      stroke: () => theme.color("--ink"),
      grid: { stroke: () => theme.color("--grid"), width: 1 },
      ticks: { stroke: () => theme.color("--frame"), width: 1, size: 4 },
      border: { show: true, stroke: () => theme.color("--frame"), width: 1 },
      values: (_, splits) => splits.map(v => (spec[key].log && !named(v, this.view[key === "x" ? 0 : 1]) ? "" : shown(v))),
      font, labelFont: font, labelSize: 18, gap: 4, label,
    });
    return {
      mode: 2,
      ...this.size(),
      legend: { show: false },
      padding: [8, 14, 0, 0],
      scales: { x: scale(0, spec.x.log), y: scale(1, spec.y.log) },
      axes: [
        { ...axis("x", spec.labelled ? spec.x.label : undefined), size: 26, space: 60 },
        { ...axis("y", spec.y.label), size: 50, space: 26 },
      ],
      series: [null, ...this.series.map((s, k) => this.line(s, k))],
      cursor: {
        drag: { x: true, y: spec.equal, uni: 20, dist: 5, setScale: false },
        dataIdx: (plot, k) => this.at(plot, k - 1),
        points: { size: 8, width: 1.5, stroke: (_, k) => this.paint(k), fill: () => theme.color("--page") },
        bind: {
          dblclick: () => () => this.on.back(this),
          mousedown: (_, __, handle) => e => (e.shiftKey ? this.grab(e) : handle(e)),
        },
      },
      hooks: {
        drawClear: [plot => this.marks(plot, true)],
        drawAxes: [plot => this.marks(plot, false)],
        setSelect: [plot => this.selected(plot)],
        setCursor: [plot => this.pointed(plot)],
      },
    };
  }

  // Width and height with the axes, px. A map keeps its shape, but for a least height, which shows more of
  // y; the others keep their height.
  size() {
    const [w, h] = this.spec.size;
    const width = Math.max(this.element.clientWidth, 120);
    let inner = h;
    if (this.spec.equal) {
      const [[a, b], [c, d]] = [this.spec.x.range, this.spec.y.range];
      inner = Math.max((h * (width - 82)) / w, 110);
      const half = (((b - a) / (width - 82)) * inner) / 2;
      this.home[1] = [(c + d) / 2 - half, (c + d) / 2 + half];
    }
    return { width, height: Math.round(inner + (this.spec.labelled ? 52 : 34)) };
  }

  paint(k) {
    return theme.of(this.series[k - 1].color);
  }

  line(s, k) {
    const color = () => this.paint(k + 1);
    return {
      show: true,
      auto: false,
      facets: [{ scale: "x", auto: false }, { scale: "y", auto: false }],
      stroke: color,
      fill: color,
      width: s.width || 2,
      dash: s.dashed ? [3.5 * s.width, 2 * s.width] : undefined,
      points: { show: false },
      paths: plot => this.path(plot, s),
    };
  }

  // Lines and symbols of a series. Within a column of pixels the first, least, largest and last point
  // are the line.
  path(plot, s) {
    const [xs, ys] = s.data;
    const [line, dots] = [new Path2D(), new Path2D()];
    const [from, to] = this.within(s, 1);
    const r = s.dot * devicePixelRatio;
    let column = null;
    const flush = () => {
      if (!column) return;
      for (const y of column.keep) line.lineTo(column.x, y);
      line.lineTo(column.x, column.last);
      column = null;
    };
    let open = false;
    for (let k = from; k <= to; k++) {
      if (xs[k] === null || ys[k] === null) {
        flush();
        open = false;
        continue;
      }
      const [x, y] = [plot.valToPos(xs[k], "x", true), plot.valToPos(ys[k], "y", true)];
      if (s.dot > 0) this.symbol(s.symbol === "dot" ? dots : line, s.symbol, x, y, r);
      if (s.width === 0) continue;
      if (!open) {
        line.moveTo(x, y);
        open = true;
      } else if (column && Math.abs(x - column.x) < 0.5) {
        column.last = y;
        column.keep[0] = Math.min(column.keep[0], y);
        column.keep[1] = Math.max(column.keep[1], y);
      } else {
        flush();
        column = { x, keep: [y, y], last: y };
      }
    }
    flush();
    return { stroke: line, fill: dots, clip: null, gaps: null, flags: 0 };
  }

  symbol(path, kind, x, y, r) {
    if (kind === "cross") {
      for (const side of [-1, 1]) {
        path.moveTo(x - r, y - side * r);
        path.lineTo(x + r, y + side * r);
      }
    } else {
      path.moveTo(x + r, y);
      path.arc(x, y, r, 0, 2 * Math.PI);
    }
  }

  // First and last index in view; `more` points at each end lie outside.
  within(s, more) {
    const [xs, last] = [s.data[0], s.data[0].length - 1];
    if (!s.sorted || last < 0) return [0, last];
    const [from, to] = this.view[0].map(x => nearest(xs, x));
    return [Math.max(from - more, 0), Math.min(to + more, last)];
  }

  marks(plot, bands) {
    const { ctx, bbox } = plot;
    const [right, bottom] = [bbox.left + bbox.width, bbox.top + bbox.height];
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    for (const mark of this.spec.marks.filter(m => m.isBand === bands)) {
      const pos = (v, open) => (v === null || (v <= 0 && this.spec[mark.axis].log) ? open : plot.valToPos(v, mark.axis, true));
      ctx.fillStyle = ctx.strokeStyle = theme.of(mark.color);
      if (bands) {
        ctx.globalAlpha = theme.dark() ? 0.24 : 0.14;
        if (mark.axis === "x") {
          const [a, b] = [pos(mark.from, bbox.left), pos(mark.to, right)];
          ctx.fillRect(a, bbox.top, b - a, bbox.height);
        } else {
          const [a, b] = [pos(mark.to, bbox.top), pos(mark.from, bottom)];
          ctx.fillRect(bbox.left, a, bbox.width, b - a);
        }
      } else {
        ctx.lineWidth = 1.2 * devicePixelRatio;
        ctx.setLineDash([4 * devicePixelRatio, 3 * devicePixelRatio]);
        const at = pos(mark.from, NaN);
        ctx.beginPath();
        ctx.moveTo(...(mark.axis === "x" ? [at, bbox.top] : [bbox.left, at]));
        ctx.lineTo(...(mark.axis === "x" ? [at, bottom] : [right, at]));
        ctx.stroke();
      }
    }
    ctx.restore();
  }

  // The point of a series under the cursor: by x, on a map the nearest one.
  at(plot, k) {
    const s = this.series[k];
    const { left, top } = plot.cursor;
    if (!s.isData || !s.shown || left < 0) return null;
    const [xs, ys] = s.data;
    if (!this.spec.equal && s.sorted) {
      const index = nearest(xs, plot.posToVal(left, "x"));
      const apart = index === null ? Infinity : Math.abs(plot.valToPos(xs[index], "x") - left);
      // Beyond its ends a series has no value.
      return index === null || ys[index] === null || ((index === 0 || index === xs.length - 1) && apart > 20) ? null : index;
    }
    let [best, least] = [null, this.spec.equal ? 40 : 20];
    for (let i = 0; i < xs.length; i++) {
      if (xs[i] === null || ys[i] === null) continue;
      const dx = plot.valToPos(xs[i], "x") - left;
      const dy = this.spec.equal ? plot.valToPos(ys[i], "y") - top : 0;
      const apart = Math.hypot(dx, dy);
      if (apart < least) [best, least] = [i, apart];
    }
    return best;
  }

  // Values under the cursor: x, and [x, y] of each series or null.
  values() {
    const { plot } = this;
    if (!(plot.cursor.left >= 0)) return null;
    const points = this.series.map((s, k) => {
      const index = this.at(plot, k);
      return index === null ? null : [s.data[0][index], s.data[1][index]];
    });
    return { x: points.find(p => p)?.[0] ?? plot.posToVal(plot.cursor.left, "x"), points };
  }

  pointed(plot) {
    if (!this.quiet) this.on.moved(this, plot.cursor.left >= 0 ? plot.posToVal(plot.cursor.left, "x") : null);
  }

  // Puts the cursor at an x, or takes it away.
  point(x) {
    const left = x === null ? -10 : this.plot.valToPos(x, "x");
    const width = this.plot.over.clientWidth;
    this.quiet = true;
    this.plot.setCursor(left >= 0 && left <= width ? { left, top: -10 } : { left: -10, top: -10 }, true);
    this.quiet = false;
  }

  selected(plot) {
    const { left, top, width, height } = plot.select;
    if (width < 5 && height < 5) return;
    plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
    const [x, y] = [[left, left + width], [top + height, top]];
    if (!this.spec.equal) return this.on.zoomed(this, x.map(v => plot.posToVal(v, "x")));
    // The frame about the selection that has the shape of the panel.
    // A selection along one axis has all of the other.
    const shares = [width / plot.over.clientWidth, height / plot.over.clientHeight];
    const share = Math.max(...shares.filter(v => v < 0.99), 0) || 1;
    const about = ([a, b], k) => {
      const [middle, half] = [(a + b) / 2, ((this.view[k][1] - this.view[k][0]) * share) / 2];
      return [middle - half, middle + half];
    };
    this.on.zoomed(this, about(x.map(v => plot.posToVal(v, "x")), 0), about(y.map(v => plot.posToVal(v, "y")), 1));
  }

  // The view, `factor` times as long about a share of its length, moved by a share of it.
  changed(k, factor, about, by) {
    const [a, b] = this.view[k].map(this.to[k]);
    const [first, last] = this.home[k].map(this.to[k]);
    const length = clamp((b - a) * factor, (last - first) * 1e-4, last - first);
    const start = clamp(a + about * (b - a - length) + by * length, first, last - length);
    return length === last - first ? [...this.home[k]] : [start, start + length].map(this.from[k]);
  }

  zoom(factor, about = [0.5, 0.5], by = [0, 0]) {
    const y = this.spec.equal ? this.changed(1, factor, about[1], by[1]) : undefined;
    this.on.zoomed(this, this.changed(0, factor, about[0], by[0]), y);
  }

  // Shows a range of x, and of y what lies in it.
  show(x, y) {
    const isHome = x.every((v, k) => v === this.home[0][k]);
    this.view = [x, y ?? (isHome ? this.home[1] : this.fitted(x))];
    this.redraw();
    this.publish();
  }

  fitted(x) {
    let [low, high] = [Infinity, -Infinity];
    for (const s of this.series.filter(s => s.shown)) {
      const [xs, ys] = s.data;
      for (let k = 0; k < xs.length; k++) {
        if (ys[k] === null || xs[k] < x[0] || xs[k] > x[1]) continue;
        low = Math.min(low, ys[k]);
        high = Math.max(high, ys[k]);
      }
    }
    if (!(low <= high)) return this.home[1];
    const [to, from] = [this.to[1], this.from[1]];
    const [first, last] = this.home[1].map(to);
    const air = Math.max(0.06 * (to(high) - to(low)), 0.01 * (last - first));
    const range = [Math.max(to(low) - air, first), Math.min(to(high) + air, last)];
    return range[0] < range[1] ? range.map(from) : this.home[1];
  }

  redraw() {
    const [x, y] = this.view.map(([min, max]) => ({ min, max }));
    this.plot.batch(() => {
      this.plot.setScale("x", x);
      this.plot.setScale("y", y);
    });
  }

  toggle(name, visible) {
    this.series.forEach((s, k) => {
      if (s.name !== name) return;
      s.shown = visible;
      this.plot.setSeries(k + 1, { show: visible });
    });
    this.show(this.view[0], this.spec.equal ? this.view[1] : undefined);
  }

  resize() {
    const { width, height } = this.size();
    if (width === this.plot.width && height === this.plot.height) return;
    this.plot.setSize({ width, height });
    if (this.spec.equal) this.show(...this.home);
  }

  // What is in view, for programs that read the page.
  publish() {
    this.element.dataset.x = this.view[0].join(" ");
    this.element.dataset.y = this.view[1].join(" ");
  }

  // Where a pointer is, as shares of the plot from the lower left.
  share(e) {
    const box = this.plot.over.getBoundingClientRect();
    return [(e.clientX - box.left) / box.width, 1 - (e.clientY - box.top) / box.height];
  }

  grab(down) {
    let before = this.share(down);
    const move = e => {
      const now = this.share(e);
      this.zoom(1, [0.5, 0.5], [before[0] - now[0], before[1] - now[1]]);
      before = now;
    };
    const up = () => {
      removeEventListener("mousemove", move);
      removeEventListener("mouseup", up);
    };
    addEventListener("mousemove", move);
    addEventListener("mouseup", up);
  }

  bind() {
    const { over } = this.plot;
    over.addEventListener("wheel", e => {
      const sideways = Math.abs(e.deltaX) > Math.abs(e.deltaY);
      if (!e.ctrlKey && !e.metaKey && !sideways) return;
      e.preventDefault();
      if (sideways) this.zoom(1, [0.5, 0.5], [e.deltaX / over.clientWidth, 0]);
      else this.zoom(Math.exp(clamp(e.deltaY, -60, 60) / 150), this.share(e));
    }, { passive: false });
    // One finger moves sideways, two zoom; up and down is the page's.
    let fingers = [];
    const all = e => [...e.touches].map(t => this.share(t));
    over.addEventListener("touchstart", e => (fingers = all(e)), { passive: true });
    over.addEventListener("touchmove", e => {
      const now = all(e);
      if (now.length !== fingers.length) return;
      if (now.length === 2) {
        e.preventDefault();
        const apart = f => Math.hypot(f[0][0] - f[1][0], f[0][1] - f[1][1]) + 1e-6;
        this.zoom(apart(fingers) / apart(now), [0, 1].map(k => (now[0][k] + now[1][k]) / 2));
      } else {
        this.zoom(1, [0.5, 0.5], [fingers[0][0] - now[0][0], 0]);
      }
      fingers = now;
    }, { passive: false });
  }
}
