// What the run looks like over its steps: sequence chart, timeline of places, plot of data.
"use strict";

const SVG_NAMESPACE = "http://www.w3.org/2000/svg";

function svgElement(name, attributes, text) {
  const element = document.createElementNS(SVG_NAMESPACE, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  if (text !== undefined) element.textContent = text;
  return element;
}
function clipped(text, most) {
  return text.length > most ? text.slice(0, most - 1) + "…" : text;
}

/** Steps around the position: a column for each component, a line for each step. */
function showSequence(panel, run, position, go) {
  const rows = 40, first = Math.max(0, Math.min(position - rows / 2, run.length - rows)), last = Math.min(run.length, first + rows);
  const atoms = [...new Set(run.steps.slice(first, last).flatMap((step) => step.parts.map(([atom]) => atom)))].sort((a, b) => a - b);
  const left = 150, column = 110, row = 20, top = 26;
  const svg = svgElement("svg", { class: "chart", width: left + column * atoms.length + 20, height: top + row * (last - first) + 10 });
  const x = new Map(atoms.map((atom, k) => [atom, left + column * (k + 0.5)]));
  for (const [atom, at] of x) {
    svg.append(svgElement("text", { x: at, y: 14, "text-anchor": "middle", "font-weight": "bold" }, clipped(run.name(atom), 17)));
    svg.append(svgElement("line", { class: "lifeline", x1: at, x2: at, y1: 20, y2: top + row * (last - first) }));
  }
  for (let k = first; k < last; ++k) {
    const step = run.steps[k], y = top + row * (k - first) + row / 2, isNow = k + 1 === position;
    const group = svgElement("g", { role: "button", "data-position": k + 1 });
    group.append(svgElement("rect", { x: 0, y: y - row / 2, width: left + column * atoms.length + 20, height: row, fill: isNow ? "var(--mark)" : "transparent" }));
    const name = step.connector < 0 ? step.text.split(" ")[0] : run.connectors[step.connector].replace(/^ROOT\./, "");
    group.append(svgElement("text", { x: 4, y: y + 4 }, clipped("#" + k + " " + name, 24)));
    const xs = step.parts.map(([atom]) => x.get(atom));
    if (xs.length > 0) {
      group.append(svgElement("line", { class: isNow ? "step-now" : "step", x1: Math.min(...xs), x2: Math.max(...xs), y1: y, y2: y }));
      step.parts.forEach(([atom, port], part) => {
        group.append(svgElement("circle", { cx: xs[part], cy: y, r: 4 }));
        group.append(svgElement("text", { x: xs[part] + 7, y: y - 3, style: "font-size:9px" }, clipped(run.type(atom).ports[port], 16)));
      });
    }
    group.addEventListener("click", () => go(k + 1));
    svg.append(group);
  }
  panel.replaceChildren(svg);
  svg.querySelector(`[data-position="${position}"]`)?.scrollIntoView({ block: "nearest" });
}

// Hues that differ for most eyes (after Okabe and Ito), lighter on dark screens.
const PLACE_COLOURS = ["#56b4e9", "#e69f00", "#009e73", "#cc79a7", "#f0e442", "#0072b2", "#d55e00", "#999999"];

/** What the place of a service's controller (package genom.services) means; at rest it is in none of these. */
const SERVICE_PHASES = {
  chck: "asked", chkd: "asked", init: "waits", exec: "runs", canc: "cancelled", abrt: "is stopped", fini: "ended", fald: "failed", zomb: "zombie",
};
const PHASE_COLOURS = { asked: "#f0e442", waits: "#e69f00", runs: "#56b4e9", cancelled: "#999999", "is stopped": "#cc79a7", ended: "#009e73", failed: "#d55e00", zombie: "#d55e00" };

/**
 * A bar for each component: where it was when. Or, of modules of robots, for each service that was asked for: from its request to its
 * end. Drawn on a canvas, so that thousands of stays are no burden.
 */
class Timeline {
  constructor(run, go) {
    this.run = run;
    this.go = go;
    this.row = 18;
    this.left = 150;
    this.services = run.services();
    this.isOfServices = false;
  }
  /** Rows with their bars, [from, to, text, colour] each. */
  rows(atoms) {
    const stays = this.run.stays(), end = this.run.length;
    const bars = (atom, look) => stays[atom].map(([from, place], k) => [from, k + 1 < stays[atom].length ? stays[atom][k + 1][0] : end, ...look(place)]).filter((bar) => bar[2]);
    if (!this.isOfServices)
      return atoms.map((atom) => {
        const places = this.run.type(atom).places;
        return { name: this.run.name(atom), bars: bars(atom, (place) => [place, PLACE_COLOURS[Math.max(0, places.indexOf(place)) % PLACE_COLOURS.length]]) };
      });
    const shown = new Set(atoms);
    return [...this.services].filter(([atom]) => shown.has(atom))
      .map(([atom, name]) => ({ name, bars: bars(atom, (place) => [SERVICE_PHASES[place], PHASE_COLOURS[SERVICE_PHASES[place]]]) }))
      .filter((row) => row.bars.length > 0);
  }
  /** Steps, or time where the model has it. */
  x(position) {
    const whole = this.run.isTimed ? this.run.instant(this.run.length) : this.run.length;
    const at = this.run.isTimed ? this.run.instant(position) : position;
    return this.left + (whole === 0 ? 0 : (at / whole) * (this.width - this.left - 10));
  }
  show(panel, position, atoms) {
    this.position = position;
    if (this.panel !== panel || !panel.contains(this.canvas) || this.width !== panel.clientWidth - 20 || this.atoms !== atoms.join() || this.version !== this.run.version || (this.isOfServices && this.drawnLength !== this.run.length)) this.draw(panel, atoms);
    const line = this.cursor;
    line.style.left = this.x(position) + "px";
    line.setAttribute("aria-label", "position " + position);
  }
  draw(panel, atoms) {
    this.panel = panel;
    this.version = this.run.version;
    this.atoms = atoms.join();
    this.drawnLength = this.run.length;
    this.width = Math.max(300, panel.clientWidth - 20);
    const rows = this.rows(atoms), height = this.row * rows.length + 22, ratio = devicePixelRatio || 1;
    this.canvas = document.createElement("canvas");
    this.canvas.width = this.width * ratio;
    this.canvas.height = height * ratio;
    this.canvas.style.cssText = `width:${this.width}px;height:${height}px;display:block;cursor:pointer`;
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", (this.isOfServices ? rows.length + " services" : "places of " + rows.length + " components") + " over the run");
    this.cursor = document.createElement("div");
    this.cursor.style.cssText = `position:absolute;top:0;width:2px;height:${height}px;background:var(--now);pointer-events:none`;
    const g = this.canvas.getContext("2d"), ink = getComputedStyle(document.body).color;
    g.scale(ratio, ratio);
    g.font = "11px Helvetica, Arial, sans-serif";
    rows.forEach(({ name, bars }, k) => {
      const y = this.row * k + 2;
      g.fillStyle = ink;
      g.fillText(clipped(name, 22), 2, y + 12);
      // Of stays narrower than half a pixel only as many are drawn as can be seen.
      let drawn = -1;
      for (const [from, to, text, colour] of bars) {
        const x0 = this.x(from), x1 = this.x(to);
        if (x1 <= x0 || x1 < drawn + 0.5) continue;
        drawn = x1;
        g.fillStyle = colour;
        g.fillRect(x0, y, Math.max(x1 - x0 - 0.5, 0.5), this.row - 4);
        if (x1 - x0 > g.measureText(text).width + 6) {
          g.fillStyle = "#111";
          g.fillText(text, x0 + 3, y + 11);
        }
      }
    });
    g.fillStyle = ink;
    for (let k = 0; k <= 4; ++k) {
      const position = Math.round((this.run.length * k) / 4);
      const text = this.run.isTimed ? timeText(this.run.instant(position)) : "#" + position;
      g.fillText(text, Math.min(this.x(position), this.width - g.measureText(text).width), height - 6);
    }
    this.canvas.addEventListener("click", (event) => {
      const x = event.clientX - this.canvas.getBoundingClientRect().left;
      let low = 0, high = this.run.length;
      while (low < high) {
        const middle = (low + high) >> 1;
        if (this.x(middle) < x) low = middle + 1;
        else high = middle;
      }
      this.go(low);
    });
    const chart = document.createElement("div");
    chart.style.position = "relative";
    chart.append(this.canvas, this.cursor);
    panel.replaceChildren(...(this.services.size > 0 ? [this.choice(panel, atoms)] : []), chart);
  }
  choice(panel, atoms) {
    const label = document.createElement("label"), select = document.createElement("select");
    select.append(new Option("components"), new Option("services"));
    select.selectedIndex = Number(this.isOfServices);
    select.addEventListener("change", () => {
      this.isOfServices = select.selectedIndex === 1;
      this.panel = null;
      this.show(panel, this.position, atoms);
    });
    label.append("bars of ", select);
    return label;
  }
}

/** Points of a line of steps, at most the first, least, greatest and last of each pixel. */
function fewer(points, x) {
  if (points.length < 5000) return points;
  const out = [];
  for (let k = 0; k < points.length; ) {
    const pixel = Math.floor(x(points[k][0]));
    let low = k, high = k, last = k;
    for (; last + 1 < points.length && Math.floor(x(points[last + 1][0])) === pixel; ++last) {
      if (points[last + 1][1] < points[low][1]) low = last + 1;
      if (points[last + 1][1] > points[high][1]) high = last + 1;
    }
    for (const n of [...new Set([k, low, high, last])].sort((a, b) => a - b)) out.push(points[n]);
    k = last + 1;
  }
  return out;
}

/** Numbers of the run as steps of a line; each variable has its own colour, all share the axes. */
class Plot {
  constructor(run) {
    this.run = run;
    this.chosen = null;
  }
  /** Variables with numbers that change: [atom, variable, name]. */
  variables() {
    if (this.found) return this.found;
    const seen = new Set();
    for (const step of new Set(this.run.steps)) for (const [atom, , values] of step.changes) for (const [row, value] of values) if (!Number.isNaN(Number(value))) seen.add(atom + " " + row);
    this.found = [...seen].map((key) => key.split(" ").map(Number)).sort((a, b) => a[0] - b[0] || a[1] - b[1])
      .map(([atom, row]) => [atom, row, this.run.name(atom) + "." + this.run.type(atom).variables[row]]);
    // Clocks are lines, not steps.
    this.run.atoms.forEach((_, atom) => this.run.clocksOf(atom).forEach(([name], clock) => this.found.push([atom, clock, this.run.name(atom) + "." + name, "clock"])));
    return this.found;
  }
  show(panel, position) {
    const variables = this.variables();
    if (variables.length === 0) return panel.replaceChildren("No number changes in this run, and there is no clock.");
    if (!this.chosen) this.chosen = new Set(variables.slice(0, 4).map((v) => v[2]));
    // The lines are drawn once; then the cursor moves.
    const drawn = [...this.chosen, this.run.version, this.run.length, panel.clientWidth, panel.clientHeight].join();
    if (this.drawn === drawn && panel.contains(this.svg)) return this.moveCursor(position);
    this.drawn = drawn;
    const list = document.createElement("div");
    for (const [, , name] of variables.slice(0, 200)) {
      const label = document.createElement("label"), box = document.createElement("input");
      box.type = "checkbox";
      box.checked = this.chosen.has(name);
      box.addEventListener("change", () => {
        if (box.checked) this.chosen.add(name);
        else this.chosen.delete(name);
        this.show(panel, this.position);
      });
      const colour = PLACE_COLOURS[[...this.chosen].indexOf(name) % PLACE_COLOURS.length];
      label.style.cssText = "margin-right:12px;white-space:nowrap;border-bottom:3px solid " + (box.checked ? colour : "transparent");
      label.append(box, " " + name);
      list.append(label);
    }
    list.style.cssText = "max-height:64px;overflow:auto";
    this.position = position;
    this.svg = this.lines(panel, variables.filter((v) => this.chosen.has(v[2])));
    panel.replaceChildren(list, this.svg);
    this.moveCursor(position);
  }
  moveCursor(position) {
    const cursor = this.svg.querySelector(".cursor");
    if (cursor) for (const end of ["x1", "x2"]) cursor.setAttribute(end, this.x(position));
  }
  lines(panel, variables) {
    const width = Math.max(300, panel.clientWidth - 24), height = Math.max(120, panel.clientHeight - 90), left = 60, bottom = 20;
    const svg = svgElement("svg", { class: "chart", width, height, role: "img", "aria-label": "values of " + variables.map((v) => v[2]).join(", ") });
    const series = variables.map(([atom, row, , kind]) => kind ? this.run.clockLine(atom, row) : this.run.values(atom, row).map(([at, value]) => [at, Number(value)]).filter(([, value]) => Number.isFinite(value)));
    let low = Infinity, high = -Infinity;
    for (const points of series) for (const [, value] of points) (low = Math.min(low, value)), (high = Math.max(high, value));
    if (low === Infinity) return svg;
    if (low === high) high = low + 1;
    const whole = this.run.isTimed ? this.run.instant(this.run.length) : this.run.length;
    const xOfInstant = (instant) => left + (instant / (whole || 1)) * (width - left - 10);
    const x = (this.x = (at) => xOfInstant(this.run.isTimed ? this.run.instant(at) : at));
    const y = (value) => height - bottom - ((value - low) / (high - low)) * (height - bottom - 12);
    for (const part of [0, 0.5, 1]) {
      const value = low + (high - low) * part;
      svg.append(svgElement("line", { class: "axis", x1: left, x2: width - 10, y1: y(value), y2: y(value) }));
      svg.append(svgElement("text", { x: left - 6, y: y(value) + 4, "text-anchor": "end" }, String(Number(value.toPrecision(6)))));
      const at = Math.round(this.run.length * part);
      svg.append(svgElement("text", { x: x(at), y: height - 5, "text-anchor": part === 0 ? "start" : part === 1 ? "end" : "middle" }, this.run.isTimed ? timeText(this.run.instant(at)) : "#" + at));
    }
    series.forEach((points, k) => {
      if (points.length === 0) return;
      let path = "";
      if (variables[k][3]) {
        points.forEach(([instant, value], n) => (path += (n === 0 ? "M" : "L") + xOfInstant(instant) + " " + y(value)));
        svg.append(svgElement("path", { class: "clock", d: path, fill: "none", "stroke-width": 1.5, stroke: PLACE_COLOURS[k % PLACE_COLOURS.length] }));
        return;
      }
      fewer(points, x).forEach(([at, value], n) => (path += (n === 0 ? "M" + x(at) + " " + y(value) : "H" + x(at) + "V" + y(value))));
      svg.append(svgElement("path", { d: path + "H" + x(this.run.length), fill: "none", "stroke-width": 2, stroke: PLACE_COLOURS[k % PLACE_COLOURS.length] }));
    });
    svg.append(svgElement("line", { class: "cursor", x1: 0, x2: 0, y1: 0, y2: height - bottom }));
    return svg;
  }
}
