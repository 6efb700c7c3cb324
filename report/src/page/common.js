"use strict";
// What all of the page's scripts use: colours, numbers, ticks.

// Colours of the page; the description's colours are made for white paper.
const theme = {
  dark: () => {
    const chosen = document.documentElement.dataset.theme;
    return chosen ? chosen === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
  },
  color: name => getComputedStyle(document.documentElement).getPropertyValue(name),
  of(hex) {
    if (!theme.dark()) return hex;
    const [r, g, b] = [1, 3, 5].map(k => parseInt(hex.slice(k, k + 2), 16));
    const gray = r === g && g === b;
    const lit = v => Math.round(gray ? Math.min(235, 255 - v) : v + 0.3 * (255 - v));
    return `rgb(${lit(r)},${lit(g)},${lit(b)})`;
  },
};

// A number as people read it: five digits, a proper minus sign.
function shown(value) {
  if (value === null || value === undefined || !isFinite(value)) return "–";
  return String(Number(value.toPrecision(5))).replace("-", "−").replace("e-", "e−");
}

// Ticks of a logarithmic axis: all digits of each decade, or steps of one length within a decade. uPlot's
// own do not end where the axis does not begin at such a digit.
function logTicks(_, __, low, high) {
  const ticks = [];
  if (high / low < 6) {
    const rough = (high - low) / 5;
    const unit = 10 ** Math.floor(Math.log10(rough));
    const step = unit * ([1, 2, 5].find(m => m * unit >= rough) ?? 10);
    for (let k = Math.ceil(low / step); k * step <= high; k++) ticks.push(k * step);
    return ticks;
  }
  for (let e = Math.floor(Math.log10(low)); 10 ** e <= high; e++) {
    for (let digit = 1; digit < 10; digit++) {
      const at = digit * 10 ** e;
      if (at >= low && at <= high) ticks.push(at);
    }
  }
  return ticks;
}

// Whether a tick of a logarithmic axis has a number: 1, 2 and 5 of each decade, of many decades 1.
function named(value, [low, high]) {
  const digit = Math.round(value / 10 ** Math.floor(Math.log10(value) + 1e-9));
  return high / low < 6 || digit === 1 || (high / low < 300 && (digit === 2 || digit === 5));
}

const clamp = (v, low, high) => Math.min(Math.max(v, low), high);

// The index of the value nearest to `at` in ascending `xs`.
function nearest(xs, at) {
  let [low, high] = [0, xs.length - 1];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (xs[middle] < at) low = middle;
    else high = middle;
  }
  return xs.length === 0 ? null : Math.abs(xs[low] - at) <= Math.abs(xs[high] - at) ? low : high;
}
