// The list of steps. Only the rows that fit are in the page; they are made once and filled again, so that a position
// costs the same in a run of any length.
"use strict";

const STEP_ROW = 20; // px, as in page.css

class StepList {
  constructor(run, go) {
    this.run = run;
    this.go = go;
    this.top = 0; // the position in the first row
    this.rows = [];
    this.root = element("div", { class: "steps", role: "list", "aria-label": "steps of the run: the wheel moves them" });
    this.root.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.turned = (this.turned || 0) + (event.deltaMode === 0 ? event.deltaY / STEP_ROW : event.deltaY);
      const whole = Math.trunc(this.turned);
      this.turned -= whole;
      this.move(this.top + whole);
    }, { passive: false });
    // The height is asked for when it changes, not for each position.
    new ResizeObserver(() => this.measure()).observe($("panel"));
  }
  measure() {
    this.height = $("panel").clientHeight - 12;
    if (this.root.isConnected) this.fill();
  }
  show(panel, position) {
    if (this.height === undefined) this.height = panel.clientHeight - 12;
    const fit = this.fit;
    if (position !== this.position && (position < this.top || position >= this.top + fit)) this.top = position - (fit >> 1);
    this.position = position;
    this.fill();
    if (!panel.contains(this.root)) panel.replaceChildren(this.root);
  }
  get fit() {
    return Math.max(3, Math.floor(this.height / STEP_ROW));
  }
  move(top) {
    this.top = top;
    this.fill();
  }
  /** The rows that fit, from `top` on. */
  fill() {
    const fit = this.fit, run = this.run;
    this.top = Math.max(0, Math.min(this.top, run.length + 1 - fit));
    while (this.rows.length < fit) this.rows.push(this.makeRow());
    this.rows.forEach((row, k) => {
      const position = this.top + k, isShown = k < fit && position <= run.length, step = isShown && position > 0 ? run.steps[position - 1] : null;
      row.root.hidden = !isShown;
      if (!isShown) return;
      row.position = position;
      row.root.classList.toggle("now", position === this.position);
      row.number.data = step ? "#" + (position - 1) : "";
      row.text.data = step ? step.text.replace(/\bROOT\./g, "") : "initial state";
      row.instant.data = step && run.isTimed ? timeText(run.instant(position)) : "";
      row.line.data = step ? step.line : "";
    });
  }
  makeRow() {
    const row = { position: 0 }, cells = ["number", "text", "instant", "line"].map((name) => (row[name] = document.createTextNode("")));
    const link = element("button", { class: "row-link", onclick: () => this.go(row.position) }, cells[1]);
    row.root = element("div", { role: "listitem" }, element("span", {}, cells[0]), link, element("span", {}, cells[2]), element("span", { class: "soft" }, cells[3]));
    this.root.append(row.root);
    return row;
  }
}
