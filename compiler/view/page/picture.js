// The picture of the structure: moved, enlarged, searched, collapsed; marked with what the run does.
"use strict";

function element(name, attributes, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes || {})) {
    if (key.startsWith("on")) made.addEventListener(key.slice(2), value);
    else made.setAttribute(key, value);
  }
  made.append(...children);
  return made;
}

class StructurePicture {
  constructor(canvas, run, onChoose, onConnector) {
    this.canvas = canvas;
    this.run = run;
    this.onChoose = onChoose;
    this.onConnector = onConnector;
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.zoom(event.deltaY < 0 ? 1.15 : 1 / 1.15, event.clientX, event.clientY);
    }, { passive: false });
    canvas.addEventListener("pointerdown", (event) => this.grab(event));
    canvas.addEventListener("keydown", (event) => this.key(event));
    canvas.addEventListener("click", (event) => this.click(event));
  }

  show(template) {
    this.canvas.replaceChildren(template.content.cloneNode(true));
    this.svg = this.canvas.querySelector("svg");
    this.whole = this.svg.getAttribute("viewBox").split(" ").map(Number);
    this.svg.removeAttribute("width");
    this.svg.removeAttribute("height");
    this.svg.classList.toggle("running", this.run.exists);
    this.boxOfAtom = new Map();
    const folded = [];
    for (const box of this.svg.querySelectorAll("[data-atom]")) {
      this.boxOfAtom.set(Number(box.dataset.atom), box);
      if (box.dataset.count) folded.push(box);
    }
    // The elements of a folded array share its box; what is in a closed compound, the compound's.
    const closed = [...this.svg.querySelectorAll(".closed"), ...folded];
    this.run.atoms.forEach(([path], atom) => {
      if (this.boxOfAtom.has(atom)) return;
      const around = closed.find((box) => path.startsWith(box.dataset.count ? box.dataset.path.replace(/\[.*$/, "[") : box.dataset.path + "."));
      if (around) this.boxOfAtom.set(atom, around);
    });
    this.members = new Map();
    for (const [atom, box] of this.boxOfAtom) {
      if (!this.members.has(box)) this.members.set(box, []);
      this.members.get(box).push(atom);
    }
    this.nets = [...this.svg.querySelectorAll("[data-connector]")].map((net) => ({ net, first: Number(net.dataset.connector), last: Number(net.dataset.last) }));
    // A bundle is as many nets as it has connectors.
    for (const net of this.svg.querySelectorAll("[data-bundled]"))
      for (const rows of net.dataset.bundled.split(" ")) this.nets.push({ net, first: Number(rows.split("-")[0]), last: Number(rows.split("-")[1]) });
    for (const box of this.members.keys()) box.standing = [...box.querySelectorAll(":scope > text.dim")].pop();
    this.marked = [];
    this.fit();
  }

  fit() {
    // A small picture is not blown up.
    const area = this.canvas.getBoundingClientRect(), least = 1 / 1.6;
    const width = Math.max(this.whole[2], area.width * least), height = Math.max(this.whole[3], area.height * least);
    const grow = Math.min(width / this.whole[2], height / this.whole[3]);
    this.view = [(this.whole[2] - this.whole[2] * grow) / 2, (this.whole[3] - this.whole[3] * grow) / 2, this.whole[2] * grow, this.whole[3] * grow];
    this.apply();
  }
  apply() {
    this.svg.setAttribute("viewBox", this.view.map((v) => v.toFixed(2)).join(" "));
  }
  zoom(factor, clientX, clientY) {
    const area = this.canvas.getBoundingClientRect();
    const scale = Math.max(this.view[2] / area.width, this.view[3] / area.height);
    const x = clientX === undefined ? this.view[0] + this.view[2] / 2 : this.view[0] + this.view[2] / 2 + (clientX - area.left - area.width / 2) * scale;
    const y = clientY === undefined ? this.view[1] + this.view[3] / 2 : this.view[1] + this.view[3] / 2 + (clientY - area.top - area.height / 2) * scale;
    if (this.view[2] / factor < 40 || this.view[2] / factor > this.whole[2] * 4) return;
    this.view = [x - (x - this.view[0]) / factor, y - (y - this.view[1]) / factor, this.view[2] / factor, this.view[3] / factor];
    this.apply();
  }
  grab(event) {
    if (event.button !== 0) return;
    const start = [event.clientX, event.clientY], view = this.view.slice();
    const area = this.canvas.getBoundingClientRect();
    const scale = Math.max(view[2] / area.width, view[3] / area.height);
    this.wasMoved = false;
    const move = (e) => {
      if (Math.hypot(e.clientX - start[0], e.clientY - start[1]) > 4) this.wasMoved = true;
      this.view = [view[0] - (e.clientX - start[0]) * scale, view[1] - (e.clientY - start[1]) * scale, view[2], view[3]];
      this.apply();
    };
    const end = () => {
      removeEventListener("pointermove", move);
      removeEventListener("pointerup", end);
    };
    addEventListener("pointermove", move);
    addEventListener("pointerup", end);
  }
  key(event) {
    const steps = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    if (event.altKey && steps[event.key]) {
      this.view[0] += steps[event.key][0] * this.view[2] * 0.1;
      this.view[1] += steps[event.key][1] * this.view[3] * 0.1;
      this.apply();
      event.preventDefault();
      event.stopPropagation();
    }
  }
  click(event) {
    if (this.wasMoved) return;
    const box = event.target.closest("[data-atom]");
    if (box) return this.onChoose(Number(box.dataset.atom));
    const net = event.target.closest("[data-connector]");
    if (net) return this.onConnector(Number(net.dataset.connector));
    // The title of a compound opens and closes it.
    const title = event.target.closest("text"), compound = event.target.closest(".compound");
    if (title && compound && title.parentNode === compound && title === compound.querySelector(":scope > text")) compound.classList.toggle("collapsed");
  }

  /** Boxes whose path has the text; the first is moved to the middle. */
  find(text) {
    for (const box of this.svg.querySelectorAll(".found")) box.classList.remove("found");
    if (!text) return [];
    const wanted = text.toLowerCase();
    const atoms = this.run.atoms.map(([path], atom) => [path, atom]).filter(([path]) => path.toLowerCase().includes(wanted)).map(([, atom]) => atom);
    const boxes = new Set(atoms.map((atom) => this.boxOfAtom.get(atom)).filter(Boolean));
    for (const box of boxes) box.classList.add("found");
    if (boxes.size > 0) this.reveal([...boxes][0]);
    return atoms;
  }
  centre(box) {
    const frame = box.querySelector(":scope > .frame");
    return [Number(frame.getAttribute("x")) + Number(frame.getAttribute("width")) / 2, Number(frame.getAttribute("y")) + Number(frame.getAttribute("height")) / 2];
  }
  /** Where the line from the box's middle to a point leaves the box. */
  border(box, [x, y]) {
    const frame = box.querySelector(":scope > .frame"), [cx, cy] = this.centre(box);
    const part = Math.min(Number(frame.getAttribute("width")) / 2 / Math.abs(x - cx || 1e-9), Number(frame.getAttribute("height")) / 2 / Math.abs(y - cy || 1e-9), 1);
    return [cx + (x - cx) * part, cy + (y - cy) * part];
  }
  reveal(box) {
    const [x, y] = this.centre(box);
    const isSeen = x > this.view[0] && x < this.view[0] + this.view[2] && y > this.view[1] && y < this.view[1] + this.view[3];
    const isLegible = this.view[2] < this.canvas.clientWidth * 2.2;
    if (isSeen && isLegible) return;
    if (!isLegible) this.view = [0, 0, this.canvas.clientWidth * 1.2, this.canvas.clientHeight * 1.2];
    this.view = [x - this.view[2] / 2, y - this.view[3] / 2, this.view[2], this.view[3]];
    this.apply();
  }

  /** Marks the state, the step that led to it and the chosen atom. */
  mark(state, step, chosen, cycle) {
    for (const element of this.marked) element.classList.remove("acted", "fired", "chosen", "stuck");
    this.marked = [];
    const set = (element, name) => {
      if (!element) return;
      element.classList.add(name);
      this.marked.push(element);
    };
    set(this.boxOfAtom.get(chosen), "chosen");
    if (step) {
      for (const [atom] of step.parts) set(this.boxOfAtom.get(atom), "acted");
      for (const { net, first, last } of this.nets) if (step.connector >= first && step.connector <= last) set(net, "fired");
    }
    if (this.run.exists) for (const [box, atoms] of this.members) this.tellPlace(box, atoms, state);
    this.drawCycle(cycle);
    for (const atom of cycle) set(this.boxOfAtom.get(atom), "stuck");
  }
  tellPlace(box, atoms, state) {
    if (!box.standing || !box.classList.contains("atom")) return;
    const counts = new Map();
    for (const atom of atoms) counts.set(state.places[atom], (counts.get(state.places[atom]) || 0) + 1);
    const [place, count] = [...counts].sort((a, b) => b[1] - a[1])[0];
    const text = atoms.length === 1 ? place : count + " × " + place + (counts.size > 1 ? " …" : "");
    if (box.standing.textContent === text) return;
    box.standing.textContent = text;
    box.standing.setAttribute("class", "standing");
    const room = Number(box.querySelector(":scope > .frame").getAttribute("width")) - 8;
    box.standing.removeAttribute("textLength");
    if (text.length * 7 > room && box.standing.getComputedTextLength() > room) {
      box.standing.setAttribute("textLength", room);
      box.standing.setAttribute("lengthAdjust", "spacingAndGlyphs");
    }
  }
  /** Who waits for whom, as arrows from box to box. */
  drawCycle(cycle) {
    this.svg.querySelector("#waits")?.remove();
    this.svg.classList.toggle("waiting", cycle.length > 0);
    if (cycle.length === 0) return;
    const group = document.createElementNS("http://www.w3.org/2000/svg", "g");
    group.id = "waits";
    group.innerHTML = '<marker id="waits-head" viewBox="0 0 10 10" refX="9" refY="5" markerWidth="5" markerHeight="5" orient="auto"><path d="M0 0L10 5L0 10Z"/></marker>';
    cycle.forEach((atom, k) => {
      const from = this.boxOfAtom.get(atom), to = this.boxOfAtom.get(cycle[(k + 1) % cycle.length]);
      if (!from || !to || from === to) return;
      const [x0, y0] = this.border(from, this.centre(to)), [x1, y1] = this.border(to, this.centre(from));
      const length = Math.hypot(x1 - x0, y1 - y0) || 1, bend = Math.min(24, length / 6);
      const mx = (x0 + x1) / 2 - ((y1 - y0) / length) * bend, my = (y0 + y1) / 2 + ((x1 - x0) / length) * bend;
      const path = document.createElementNS("http://www.w3.org/2000/svg", "path");
      path.setAttribute("class", "waits");
      path.setAttribute("d", `M${x0} ${y0}Q${mx} ${my} ${x1} ${y1}`);
      group.append(path);
    });
    this.svg.append(group);
  }
}

/** The automaton of an atom: its place, and the transition that it took last. */
function showAutomaton(panel, template, run, atom, state, step) {
  if (panel.dataset.type !== String(run.atoms[atom][1])) {
    panel.replaceChildren(template.content.cloneNode(true));
    panel.dataset.type = run.atoms[atom][1];
    // A large one is scrolled rather than made illegible.
    const svg = panel.querySelector("svg"), natural = Number(svg.getAttribute("width"));
    svg.style.width = Math.max(Math.min(natural, panel.clientWidth), natural * 0.75) + "px";
  }
  const type = run.type(atom), here = new Set(run.exists ? state.places[atom].split(", ") : []);
  for (const place of panel.querySelectorAll("[data-place]")) place.classList.toggle("here", here.has(type.places[place.dataset.place]));
  const part = step ? step.parts.find(([other]) => other === atom) : undefined;
  for (const arrow of panel.querySelectorAll("[data-transition]")) arrow.classList.toggle("taken", part !== undefined && arrow.dataset.transition.split(" ").includes(String(part[2])));
  const current = panel.querySelector(".here");
  if (current && current !== panel.shown) current.scrollIntoView({ block: "nearest", inline: "nearest" });
  panel.shown = current;
}
