// The page: where in the run it is, which component is chosen, which panel is open.
"use strict";

const $ = (id) => document.getElementById(id);

class Page {
  constructor(data) {
    this.data = data;
    this.run = new Run(data);
    this.position = 0;
    this.atom = 0;
    this.picture = new StructurePicture($("canvas"), this.run, (atom) => this.choose(atom), (connector) => this.chooseConnector(connector));
    this.timeline = new Timeline(this.run, (position) => this.go(position));
    this.plot = new Plot(this.run);
    this.filter = [];
    $("model").textContent = data.title;
    document.title = data.title + " – bipc";
    this.panels = this.run.exists
      ? [["State", (p) => this.showState(p)], ["Choices", (p) => this.showChoices(p)], ["Steps", (p) => this.showSteps(p)],
         ["Sequence", (p) => showSequence(p, this.run, this.position, (k) => this.go(k))], ["Timeline", (p) => this.timeline.show(p, this.position, this.shownAtoms())],
         ["Plot", (p) => this.plot.show(p, this.position)], ["End", (p) => this.showEnd(p)]]
      : [["Components", (p) => this.showState(p)]];
    this.open = 0;
    if (data.proof) {
      this.proof = new Proof(this, data.proof);
      this.open = this.panels.length;
      this.panels.push(["Proof", (p) => this.proof.show(p)]);
    }
    if (data.live || data.attached) {
      this.live = data.attached ? new Attached(this) : new Live(this);
      this.open = this.panels.findIndex(([name]) => name === "Choices");
      this.panels.push(["Drive", (p) => this.live.show(p)]);
      document.querySelector("footer").append(data.attached ? " · w step · b undo · r resume · s pause" : " · w random step · r run · s stop");
    }
    this.makeTabs();
    this.makeLevels();
    this.bind();
    // A run that ends badly is opened where it ends.
    this.go(this.run.end && this.run.end.story ? this.run.length : 0);
  }

  makeTabs() {
    this.panels.forEach(([name], k) => {
      const tab = document.createElement("button");
      tab.role = "tab";
      tab.textContent = name;
      tab.title = "(" + (k + 1) + ")";
      tab.addEventListener("click", () => this.openPanel(k));
      $("tabs").append(tab);
    });
  }
  makeLevels() {
    const levels = [...document.querySelectorAll("template[data-level]")];
    levels.forEach((template, k) => $("levels").append(new Option(template.dataset.level, k)));
    $("levels-label").hidden = levels.length < 2;
    const show = (k) => {
      this.picture.show(levels[k]);
      if (this.state) this.render();
    };
    $("levels").addEventListener("change", () => show($("levels").value));
    $("levels").value = this.data.level;
    show(this.data.level);
  }
  bind() {
    $("scrubber").max = this.run.length;
    $("controls").hidden = !this.run.exists;
    const on = (id, act) => $(id).addEventListener("click", act);
    on("to-begin", () => this.go(0));
    on("back", () => this.go(this.position - 1));
    on("forward", () => this.forward(1));
    on("to-end", () => this.go(this.run.length));
    on("play", () => this.play());
    on("to-choice", () => this.toChoice());
    on("zoom-in", () => this.picture.zoom(1.3));
    on("zoom-out", () => this.picture.zoom(1 / 1.3));
    on("fit", () => this.picture.fit());
    $("scrubber").addEventListener("input", () => this.go(Number($("scrubber").value)));
    $("search").addEventListener("input", () => this.find($("search").value));
    $("search").addEventListener("keydown", (event) => {
      if (event.key === "Enter" && this.filter.length > 0) this.choose(this.filter[0]);
      if (event.key === "Escape") {
        $("search").value = "";
        this.find("");
        $("search").blur();
      }
    });
    addEventListener("keydown", (event) => this.key(event));
    addEventListener("resize", () => this.showPanel());
  }
  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || ["search", "text", "number"].includes(event.target.type) || event.target.tagName === "SELECT") return;
    const far = event.shiftKey ? 10 : 1;
    const keys = {
      ArrowLeft: () => this.go(this.position - far), ArrowRight: () => this.forward(far), Home: () => this.go(0), End: () => this.go(this.run.length),
      c: () => this.toChoice(), "/": () => $("search").focus(), "+": () => this.picture.zoom(1.3), "-": () => this.picture.zoom(1 / 1.3), 0: () => this.picture.fit(),
    };
    if (this.live) Object.assign(keys, { w: () => this.live.walk(1), r: () => this.live.runOn(), s: () => this.live.stop() });
    if (this.live && this.live.undo) keys.b = () => this.live.undo();
    if (event.key === " " && event.target.tagName !== "BUTTON") keys[" "] = () => this.play();
    this.panels.forEach((panel, k) => (keys[k + 1] = () => this.openPanel(k)));
    if (!keys[event.key]) return;
    event.preventDefault();
    keys[event.key]();
  }

  go(position) {
    this.position = Math.max(0, Math.min(this.run.length, position));
    this.state = this.run.at(this.position);
    this.render();
  }
  /** Recorded steps; at the end of a live run a new one. */
  forward(count) {
    if (this.live && this.position === this.run.length) this.live.walk(count);
    else this.go(this.position + count);
  }
  toChoice() {
    const position = this.run.lastChoice(this.position);
    if (position < 0) return;
    this.openPanel(1);
    this.go(position);
  }
  play() {
    if (this.timer) {
      clearInterval(this.timer);
      this.timer = null;
    } else {
      if (this.position === this.run.length && !this.live) this.go(0);
      this.timer = setInterval(() => {
        const before = this.position;
        this.forward(1);
        if (this.live ? this.run.end && before === this.run.length : this.position === this.run.length) this.play();
      }, 400);
    }
    $("play").setAttribute("aria-pressed", String(Boolean(this.timer)));
  }
  choose(atom) {
    this.atom = atom;
    this.render();
    const box = this.picture.boxOfAtom.get(atom);
    if (box) this.picture.reveal(box);
  }
  /** In a live page: why is it not possible? */
  chooseConnector(connector) {
    if (!this.live) return;
    this.openPanel(this.panels.length - 1);
    this.live.why(this.run.connectors[connector].replace(/^ROOT\./, ""));
  }
  find(text) {
    this.filter = this.picture.find(text);
    this.isFiltered = text !== "";
    $("found").textContent = text ? this.filter.length + " found" : "";
    this.showPanel();
  }
  openPanel(k) {
    this.open = k;
    $("panel").replaceChildren();
    $("panel").scrollTop = 0;
    this.showPanel();
  }
  shownAtoms() {
    return this.isFiltered ? this.filter : this.run.atoms.map((_, atom) => atom);
  }

  get step() {
    return this.position > 0 ? this.run.steps[this.position - 1] : null;
  }
  get isAtEnd() {
    return this.run.exists && this.position === this.run.length;
  }
  render() {
    $("scrubber").value = this.position;
    let where = (this.run.isCut ? "cut: " : "") + "step " + this.position + " of " + this.run.length;
    if (this.run.isTimed) where += ", " + timeText(this.run.instant(this.position));
    $("where").textContent = where;
    for (const id of ["to-begin", "back"]) $(id).disabled = this.position === 0;
    $("to-end").disabled = this.isAtEnd;
    $("forward").disabled = this.isAtEnd && (!this.live || this.run.end !== null);
    $("to-choice").disabled = this.run.lastChoice(this.position) < 0;
    const cycle = this.isAtEnd && this.run.end ? this.run.end.cycle : [];
    this.picture.mark(this.state, this.step, this.atom, cycle);
    $("atom-name").textContent = this.run.name(this.atom) + " : " + this.run.type(this.atom).name;
    showAutomaton($("automaton"), document.querySelector(`template[data-type="${this.run.atoms[this.atom][1]}"]`), this.run, this.atom, this.state, this.step);
    if (this.proof) this.proof.mark(this.picture, $("automaton"), this.atom);
    this.showPanel();
  }
  showPanel() {
    [...$("tabs").children].forEach((tab, k) => tab.setAttribute("aria-selected", String(k === this.open)));
    this.panels[this.open][1]($("panel"));
  }

  // -- Panels --

  /** A row for each component; what the last step changed is marked, with what it was. */
  showState(panel) {
    const before = this.position > 0 ? this.run.at(this.position - 1) : this.state;
    const table = document.createElement("table");
    table.innerHTML = "<thead><tr><th>component</th><th>type</th>" + (this.run.exists ? "<th>place</th><th>data</th>" : "") + "</tr></thead>";
    const body = table.createTBody();
    const value = (cell, text, old) => {
      const span = document.createElement("span");
      span.textContent = text;
      cell.append(span);
      if (text === old) return;
      span.className = "changed";
      const was = document.createElement("span");
      was.className = "was";
      was.textContent = " (" + old + ")";
      cell.append(was);
    };
    for (const atom of this.shownAtoms().slice(0, 2000)) {
      const row = body.insertRow(), type = this.run.type(atom);
      row.classList.toggle("chosen", atom === this.atom);
      const link = document.createElement("button");
      link.className = "row-link";
      link.textContent = this.run.name(atom);
      link.addEventListener("click", () => this.choose(atom));
      row.insertCell().append(link);
      row.insertCell().textContent = type.name;
      if (!this.run.exists) continue;
      value(row.insertCell(), this.state.places[atom], before.places[atom]);
      const data = row.insertCell();
      this.state.data[atom].forEach((text, k) => {
        if (k > 0) data.append(", ");
        data.append(type.variables[k] + " = ");
        value(data, text, before.data[atom][k]);
      });
      this.run.clocksOf(atom).forEach(([name], k) => {
        if (data.hasChildNodes()) data.append(", ");
        data.append(name + " = ");
        const wasSet = this.step && (this.run.sets.get(this.position - 1) || []).some(([other, row]) => other === atom && row === k);
        const span = document.createElement("span");
        span.textContent = this.run.clock(this.state, atom, k, this.position);
        if (wasSet) span.className = "changed";
        data.append(span);
      });
    }
    panel.replaceChildren(table);
    panel.querySelector("tr.chosen")?.scrollIntoView({ block: "nearest" });
  }
  /** What is possible here; the one that the run takes leads on. */
  showChoices(panel) {
    const { texts, count, isKnown } = this.run.choices(this.position), next = this.run.steps[this.position];
    const list = document.createElement("div"), canTake = this.live && (!this.data.attached || this.live.canFire);
    if (!isKnown) list.textContent = "The model went on from this state: its candidates are asked for where it stands still.";
    else if (count === 0) list.textContent = "Nothing is possible here" + (next ? ": " + next.text : ".");
    texts.forEach((text, k) => {
      const line = document.createElement("div"), button = document.createElement("button");
      button.className = "row-link";
      button.textContent = "[" + k + "] " + text.replace(/\bROOT\./g, "");
      const isTaken = next && next.text === text;
      if (isTaken) button.classList.add("changed");
      button.disabled = !isTaken && !canTake;
      button.title = isTaken ? "the run takes this one" : this.data.attached ? (canTake ? "take this one" : this.live.whyNot) : this.live ? "take this one; the steps after here are dropped" : "another run: bipc step --trace TRACE --at " + this.position + ", then `c " + k + "`";
      button.addEventListener("click", () => (isTaken ? this.go(this.position + 1) : this.live.take(k)));
      line.append(button);
      list.append(line);
    });
    if (count > texts.length) list.append("… and " + (count - texts.length) + " more");
    panel.replaceChildren(list);
    if (this.live) this.live.showLater(list);
  }
  showSteps(panel) {
    this.stepList ??= new StepList(this.run, (position) => this.go(position));
    this.stepList.show(panel, this.position);
  }
  showEnd(panel) {
    const text = document.createElement("pre");
    text.textContent = (this.run.end && this.run.end.story) || (this.run.isCut ? "The run goes on: more of it would be too large for a page. `bipc trace filter` writes a part, `bipc step` goes anywhere." : "The run was recorded up to here; it can go on.");
    panel.replaceChildren(text);
  }
}

addEventListener("DOMContentLoaded", () => (window.page = new Page(JSON.parse($("data").textContent))));
