// The recorded run: its states, found by going on from the nearest kept one. A live one is replaced from some step on.
"use strict";

class Run {
  constructor(data) {
    this.atoms = data.atoms; // [path, type]
    this.types = data.types;
    this.connectors = data.connectors; // paths
    const run = data.run;
    this.steps = [];
    this.instants = []; // by step, ns
    this.sets = new Map(); // by step: what clocks were set to
    // By state: rows of names, and the number of all. Equal states and steps are one object.
    this.candidates = run ? run.candidates.map((row) => (run.states ? run.states[row] : row)) : [];
    this.isCut = Boolean(run && run.is_cut);
    this.names = run ? run.names : [];
    this.end = run ? run.end : null;
    this.isTimed = run ? run.timed : false;
    this.beginsAt = (run && run.time) || 0; // that of a served model may be later
    this.exists = Boolean(run);
    const first = { places: run ? run.places : data.atoms.map(() => ""), data: run ? run.data : data.atoms.map(() => []), clocks: (run && run.clocks) || [] };
    this.clockNames = (run && run.clock_names) || []; // by type: [name, unit in ns]
    this.kept = [first];
    // Kept states are bounded to some millions of texts.
    this.stride = 256;
    if (!run) return;
    const texts = first.places.length + first.data.reduce((sum, row) => sum + row.length, 0);
    while ((run.steps.length / this.stride) * texts > 4e6) this.stride *= 2;
    if (!run.rows) return this.append(run.steps);
    for (const [step, sets] of run.sets || []) this.sets.set(step, sets);
    this.instants = run.instants || [];
    const rows = run.rows.map(Run.step), state = this.copy(first);
    for (const row of run.steps) this.add(state, rows[row]);
  }
  static step([connector, text, parts, changes, , line]) {
    return { connector, text, parts, changes, line };
  }
  append(rows) {
    const state = this.at(this.length);
    for (const row of rows) {
      this.instants.push(row[4]);
      if (row[6]) this.sets.set(this.length, row[6]);
      this.add(state, Run.step(row));
    }
  }
  add(state, step) {
    this.apply(state, step, this.sets.get(this.length));
    this.steps.push(step);
    if (this.length % this.stride === 0) this.kept.push(this.copy(state));
  }
  /** The run after the first `from` steps is another one. */
  replace({ from, steps, candidates, names_from, names, end }) {
    this.steps.length = from;
    this.instants.length = from;
    for (const step of this.sets.keys()) if (step >= from) this.sets.delete(step);
    this.kept.length = Math.floor(from / this.stride) + 1;
    this.candidates.length = from + 1;
    this.candidates.push(...candidates);
    names.forEach((name, k) => (this.names[names_from + k] = name));
    this.append(steps);
    this.end = end;
    this.madeStays = null;
    this.version = (this.version || 0) + 1;
  }

  /** The run begins anew, in another state (of a served model). */
  begin({ places, data, clocks, time, candidates, names }) {
    this.beginsAt = time;
    this.kept = [{ places, data, clocks }];
    this.steps.length = this.instants.length = 0;
    this.sets.clear();
    this.candidates = [candidates];
    this.names = names;
    this.end = null;
    this.madeStays = null;
    this.version = (this.version || 0) + 1;
  }

  get length() {
    return this.steps.length;
  }
  copy(state) {
    return { places: state.places.slice(), data: state.data.map((row) => row.slice()), clocks: state.clocks.map((row) => row.slice()) };
  }
  apply(state, step, sets) {
    for (const [atom, places, values] of step.changes) {
      if (places !== null) state.places[atom] = places;
      for (const [variable, value] of values) state.data[atom][variable] = value;
    }
    for (const [atom, clock, ...set] of sets || []) state.clocks[atom][clock] = set;
  }
  /** The state after so many steps. */
  at(position) {
    const kept = Math.floor(position / this.stride);
    const state = this.copy(this.kept[kept]);
    for (let k = kept * this.stride; k < position; ++k) this.apply(state, this.steps[k], this.sets.get(k));
    return state;
  }
  /** Names and units of the atom's clocks. */
  clocksOf(atom) {
    return this.clockNames[this.atoms[atom][1]] || [];
  }
  /** A clock's value in its unit: it was `value` at `since` and has run with `speed`. */
  clock(state, atom, clock, position) {
    return this.clockAt(state.clocks[atom][clock], this.clocksOf(atom)[clock][1], this.instant(position));
  }
  clockAt([value, since, speed], unit, instant) {
    return Number(((value + (instant - since) * speed) / unit).toPrecision(6));
  }
  /** The clock's line over time as [instant, value]: where it is set, both values. */
  clockLine(atom, clock) {
    const unit = this.clocksOf(atom)[clock][1], line = [];
    let now = this.kept[0].clocks[atom][clock];
    line.push([this.instant(0), this.clockAt(now, unit, this.instant(0))]);
    for (const sets of this.sets.values())
      for (const [other, row, ...set] of sets) {
        if (other !== atom || row !== clock) continue;
        line.push([set[1], this.clockAt(now, unit, set[1])], [set[1], this.clockAt(set, unit, set[1])]);
        now = set;
      }
    line.push([this.instant(this.length), this.clockAt(now, unit, this.instant(this.length))]);
    return line;
  }
  type(atom) {
    return this.types[this.atoms[atom][1]];
  }
  name(atom) {
    return this.atoms[atom][0].replace(/^ROOT\./, "");
  }
  /** Controllers of services of robot modules, with the services' names. */
  services() {
    const found = new Map();
    this.atoms.forEach((_, atom) => {
      const type = this.type(atom).name.replace(/^genom\.services\./, "");
      if (type === "ServiceController") found.set(atom, this.name(atom).replace(/\.controller$/, ""));
      if (type === "ControlService") found.set(atom, this.name(atom));
    });
    return found;
  }
  /** Texts of the state's candidates, and how many there are. */
  choices(position) {
    const entry = this.candidates[position] || { rows: [], count: 0 };
    return { texts: entry.rows.map((row) => this.names[row]), count: entry.count, isKnown: this.candidates[position] !== null };
  }
  /** The last state before here in which more than one thing could happen; -1: none. */
  lastChoice(position) {
    for (let k = Math.min(position, this.candidates.length) - 1; k >= 0; --k) if (this.candidates[k] && this.candidates[k].count > 1) return k;
    return -1;
  }
  /** For each atom: [first position, places] of each stay; made once. */
  stays() {
    if (this.madeStays) return this.madeStays;
    const stays = this.kept[0].places.map((places) => [[0, places]]);
    this.steps.forEach((step, k) => {
      for (const [atom, places] of step.changes) if (places !== null) stays[atom].push([k + 1, places]);
    });
    return (this.madeStays = stays);
  }
  /** Values of a variable as [position, value]. */
  values(atom, variable) {
    const key = atom + " " + variable + " " + (this.version || 0);
    if (!this.madeValues || this.madeValues.version !== this.version) this.madeValues = { version: this.version, rows: new Map() };
    if (!this.madeValues.rows.has(key)) this.madeValues.rows.set(key, this.findValues(atom, variable));
    return this.madeValues.rows.get(key);
  }
  findValues(atom, variable) {
    const out = [[0, this.kept[0].data[atom][variable]]];
    this.steps.forEach((step, k) => {
      for (const [changed, , values] of step.changes)
        if (changed === atom) for (const [row, value] of values) if (row === variable) out.push([k + 1, value]);
    });
    return out;
  }
  instant(position) {
    if (!this.isTimed) return 0;
    return position === 0 ? this.beginsAt : this.instants[position - 1];
  }
}

/** "1.5ms" of nanoseconds, with six digits. */
function timeText(ns) {
  for (const [unit, size] of [["s", 1e9], ["ms", 1e6], ["us", 1e3]]) if (ns >= size) return Number((ns / size).toPrecision(6)) + unit;
  return ns + "ns";
}
