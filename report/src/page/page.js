"use strict";
// The figures of the page: panels with linked axes, legends, tools and the keyboard.
(() => {
  const description = JSON.parse(document.getElementById("figures").textContent);
  const columns = description.columns.map(({ e, d, v }) => {
    let sum = 0;
    const value = step => (step === null ? null : ((sum += step), e >= 0 ? sum / 10 ** e : sum * 10 ** -e));
    return v ?? d.map(value);
  });
  const charts = [];

  function make(tag, properties, ...children) {
    const { attributes, ...rest } = properties ?? {};
    const element = Object.assign(document.createElement(tag), rest);
    for (const [name, value] of Object.entries(attributes ?? {})) element.setAttribute(name, value);
    element.append(...children);
    return element;
  }

  const button = (text, label, act, attributes = {}) =>
    make("button", { type: "button", textContent: text, onclick: act, attributes: { "aria-label": label, title: label, ...attributes } });

  // Panels that show the same range of x.
  const linked = chart => charts.filter(other => other.group === chart.group);

  const on = {
    zoomed(chart, x, y) {
      for (const other of linked(chart)) other.show(x, other === chart ? y : undefined);
    },
    moved(chart, x) {
      for (const other of linked(chart)) {
        if (other !== chart) other.point(x);
        other.readout();
      }
    },
    back(chart) {
      for (const other of linked(chart)) other.show(...other.home);
    },
  };

  // The sample of a series or mark in a legend.
  function sample(entry) {
    const color = theme.of(entry.color);
    const line = (width, dash) => `<line x1="0" y1="7" x2="22" y2="7" stroke="${color}" stroke-width="${width}" ${dash ? 'stroke-dasharray="5 3"' : ""}/>`;
    const symbol = {
      dot: `<circle cx="11" cy="7" r="4" fill="${color}"/>`,
      ring: `<circle cx="11" cy="7" r="4" fill="none" stroke="${color}" stroke-width="2"/>`,
      cross: `<path d="M7 3l8 8m0-8l-8 8" stroke="${color}" stroke-width="2"/>`,
    };
    const inner = entry.axis
      ? entry.isBand ? `<rect width="22" height="14" fill="${color}" opacity=".25"/>` : line(1.5, true)
      : (entry.width ? line(clamp(entry.width, 2, 5), entry.dashed) : "") + (entry.dot ? symbol[entry.symbol] : "");
    return `<svg width="22" height="14" aria-hidden="true">${inner}</svg>`;
  }

  // The legend of a panel, with values under the cursor: `chart.readout` fills it.
  function legend(chart, marks, toggle) {
    const list = make("ul", { className: "legend" });
    const values = new Map();
    const samples = [];
    const readouts = [];
    const entry = (of, ...children) => {
      const swatch = make("span");
      samples.push(() => (swatch.innerHTML = sample(of)));
      return [swatch, ...children];
    };
    const x = make("span", { className: "value" });
    const seen = new Set();
    chart.series.forEach((s, k) => {
      const value = make("span", { className: "value" });
      if (s.isData) values.set(k, value);
      if (s.name === "") {
        if (s.isData) readouts.push(make("li", { className: "readout" }, `${chart.spec.y.label}: `, value));
      } else if (!seen.has(s.name)) {
        seen.add(s.name);
        const pressed = make("button", { type: "button", attributes: { "aria-pressed": "true" } });
        pressed.dataset.name = s.name;
        pressed.append(...entry(s, make("span", { className: "name", textContent: s.name + s.note })));
        pressed.onclick = () => toggle(s.name, pressed.getAttribute("aria-pressed") !== "true");
        list.append(make("li", {}, pressed, ...(s.isData ? [value] : [])));
      }
    });
    list.append(...marks.map(m => make("li", {}, ...entry(m, make("span", { textContent: m.name })))));
    list.append(...readouts, make("li", { className: "readout" }, `${chart.spec.x.label.split(",")[0]}: `, x));
    chart.recolor = () => samples.forEach(draw => draw());
    chart.readout = () => {
      const at = chart.values();
      list.classList.toggle("read", at !== null);
      x.textContent = at ? shown(at.x) : "";
      for (const [k, value] of values) {
        const point = at?.points[k];
        value.textContent = !point ? "" : chart.spec.equal ? `(${point.map(shown).join(", ")})` : shown(point[1]);
      }
    };
    chart.recolor();
    return list;
  }

  function spoken(chart) {
    const at = chart.values();
    if (!at) return "";
    const named = chart.series.flatMap((s, k) => {
      if (!at.points[k]) return [];
      return [`${s.name || chart.spec.y.label} ${at.points[k].slice(chart.spec.equal ? 0 : 1).map(shown).join(", ")}`];
    });
    return `${chart.spec.x.label} ${shown(at.x)}: ${named.join("; ")}`;
  }

  // What keys do on a panel that has the focus.
  function keys(chart, status) {
    const step = direction => {
      const s = chart.series.find(s => s.isData && s.shown && s.sorted);
      const [low, high] = chart.view[0];
      let x = chart.cursor ?? low;
      if (s) {
        const [from, to] = chart.within(s, 0);
        const many = Math.max(1, Math.round((to - from) / 200));
        const index = chart.cursor === null ? from : nearest(s.data[0], x) + direction * many;
        x = s.data[0][clamp(index, from, to)];
      } else {
        x = clamp(x + (direction * (high - low)) / 100, low, high);
      }
      put(x);
    };
    const put = x => {
      chart.cursor = x;
      chart.point(x);
      on.moved(chart, x);
      status.textContent = spoken(chart);
    };
    return e => {
      if (e.altKey || e.ctrlKey || e.metaKey || e.target !== chart.element) return;
      const by = { ArrowLeft: -1, ArrowRight: 1 }[e.key];
      if (by && e.shiftKey) chart.zoom(1, [0.5, 0.5], [0.2 * by, 0]);
      else if (by) step(by);
      else if (e.key === "Home" || e.key === "End") put(chart.view[0][e.key === "Home" ? 0 : 1]);
      else if (e.key === "+" || e.key === "=") chart.zoom(0.5);
      else if (e.key === "-" || e.key === "−") chart.zoom(2);
      else if (e.key === "0" || e.key === "Escape") on.back(chart);
      else return;
      e.preventDefault();
    };
  }

  // The samples of a figure: each x once, followed by the series over it.
  function csv(figure) {
    const cell = text => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
    const tables = new Map();
    for (const panel of figure.panels) {
      for (const s of panel.series) {
        if (!tables.has(s.x)) tables.set(s.x, { label: panel.x.label, series: new Map() });
        const name = s.name ? `${panel.y.label}: ${s.name}` : panel.y.label;
        const { series } = tables.get(s.x);
        if (!series.has(s.y)) series.set(s.y, name);
      }
    }
    const all = [...tables].flatMap(([x, { label, series }]) => [[label, x], ...[...series].map(([y, name]) => [name, y])]);
    const rows = [all.map(([name]) => cell(name)).join(",")];
    const length = Math.max(...all.map(([, k]) => columns[k].length));
    for (let row = 0; row < length; row++) rows.push(all.map(([, k]) => columns[k][row] ?? "").join(","));
    return rows.join("\r\n") + "\r\n";
  }

  function save(figure) {
    const url = URL.createObjectURL(new Blob([csv(figure)], { type: "text/csv" }));
    const name = figure.title.toLowerCase().replace(/[^\p{L}\p{N}]+/gu, "-").replace(/^-|-$/g, "");
    make("a", { href: url, download: `${name || "figure"}.csv` }).click();
    setTimeout(() => URL.revokeObjectURL(url), 1000);
  }

  function tools(figure, own) {
    const each = act => () => {
      const groups = new Map(own.map(chart => [chart.group, chart]));
      groups.forEach(act);
    };
    const of = text => `${text}: ${figure.title}`;
    return make("div", { className: "tools", attributes: { role: "group", "aria-label": of("Tools") } },
      button("+", of("Zoom in"), each(c => c.zoom(0.5))),
      button("−", of("Zoom out"), each(c => c.zoom(2))),
      button("←", of("Move left"), each(c => c.zoom(1, [0.5, 0.5], [-0.25, 0]))),
      button("→", of("Move right"), each(c => c.zoom(1, [0.5, 0.5], [0.25, 0]))),
      button("Reset", of("Reset"), each(c => on.back(c))),
      button("CSV", of("CSV"), () => save(figure)));
  }

  function draw(figure, number) {
    const host = document.getElementById(`f${number}`);
    const status = make("p", { className: "hidden", attributes: { role: "status" } });
    const panels = make("div", { className: figure.columns > 1 ? "panels two" : "panels" });
    const own = [];
    const toggle = (name, visible) => {
      own.forEach(chart => chart.toggle(name, visible));
      for (const b of panels.querySelectorAll("button[data-name]")) {
        if (b.dataset.name === name) b.setAttribute("aria-pressed", visible);
      }
    };
    const title = make("p", { className: "title", textContent: figure.title });
    const head = make("div", { className: "head" }, title);
    host.prepend(head, panels, status);
    const listed = new Set([""]);
    for (const [k, panel] of figure.panels.entries()) {
      const names = [...new Set(panel.series.map(s => s.name).filter(name => name))];
      const plot = make("div", {
        className: "plot",
        tabIndex: 0,
        attributes: {
          role: "application",
          "aria-roledescription": "chart",
          "aria-label": `${panel.y.label} over ${panel.x.label}${names.length ? `: ${names.join(", ")}` : ""}`,
          "aria-describedby": `c${number}`,
        },
      });
      const host = make("div", { className: "panel" });
      panels.append(host);
      host.append(plot);
      const chart = new Chart(panel, columns, plot, on);
      chart.group = panel.equal ? `${number} ${k}` : panel.link ? `${panel.link} ${panel.x.label}` : `${number} ${panel.x.label}`;
      charts.push(chart);
      own.push(chart);
      // A mark is listed where it is first.
      const marks = panel.marks.filter(m => !listed.has(m.name) && listed.add(m.name));
      host.prepend(legend(chart, marks, toggle));
      plot.addEventListener("keydown", keys(chart, status));
      plot.addEventListener("blur", () => {
        chart.cursor = null;
        on.moved(chart, null);
        chart.point(null);
      });
    }
    head.append(tools(figure, own));
    host.classList.add("live");
  }

  function head() {
    const recolor = () => charts.forEach(c => (c.recolor(), c.plot.redraw(false)));
    const name = () => (theme.dark() ? "Light colours" : "Dark colours");
    const switcher = make("button", { type: "button", className: "theme", textContent: name() });
    switcher.onclick = () => {
      document.documentElement.dataset.theme = theme.dark() ? "light" : "dark";
      switcher.textContent = name();
      recolor();
    };
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
      switcher.textContent = name();
      recolor();
    });
    const help = make("details", { className: "help" });
    help.innerHTML = `<summary>How to use the figures</summary><ul>
      <li>Drag over a figure to zoom; axes with the same clock follow. Double-click resets.</li>
      <li>Shift and drag, or a horizontal wheel, moves; <kbd>Ctrl</kbd> and the wheel zooms.</li>
      <li>On a touch screen two fingers zoom and one moves sideways.</li>
      <li>Names in a legend show and hide their series; values under the cursor follow the names.</li>
      <li>Keys on a figure: <kbd>←</kbd> <kbd>→</kbd> read values, with <kbd>Shift</kbd> move,
      <kbd>+</kbd> <kbd>−</kbd> zoom, <kbd>0</kbd> resets.</li>
      <li>CSV saves the samples of a figure. Print shows the figures as they were before zooming.</li></ul>`;
    const header = document.querySelector("header");
    header.prepend(switcher);
    header.append(help);
  }

  head();
  description.figures.forEach(draw);
  const resize = () => {
    charts.forEach(chart => chart.resize());
    // The keyboard stops at tables that scroll.
    for (const table of document.querySelectorAll(".wide")) {
      if (table.scrollWidth > table.clientWidth) table.tabIndex = 0;
      else table.removeAttribute("tabindex");
    }
  };
  new ResizeObserver(resize).observe(document.body);
  // Print shows what is folded.
  let folded = [];
  addEventListener("beforeprint", () => {
    folded = [...document.querySelectorAll("section > details:not([open])")];
    folded.forEach(d => (d.open = true));
  });
  addEventListener("afterprint", () => folded.forEach(d => (d.open = false)));
})();
