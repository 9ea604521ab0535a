// The recorded run: its states, found by going on from the nearest kept one. A live one is replaced from some step on.
"use strict";

class Run {
  static stride = 256;

  constructor(data) {
    this.atoms = data.atoms; // [path, type]
    this.types = data.types;
    this.connectors = data.connectors; // paths
    const run = data.run;
    this.steps = [];
    this.candidates = run ? run.candidates : []; // by state: rows of names, or the number of all if there are more
    this.names = run ? run.names : [];
    this.end = run ? run.end : null;
    this.isTimed = run ? run.timed : false;
    this.exists = Boolean(run);
    const first = { places: run ? run.places : data.atoms.map(() => ""), data: run ? run.data : data.atoms.map(() => []), clocks: (run && run.clocks) || [] };
    this.clockNames = (run && run.clock_names) || []; // by type: [name, unit in ns]
    this.kept = [first];
    if (run) this.append(run.steps);
  }
  append(steps) {
    const state = this.at(this.length);
    for (const [connector, text, parts, changes, instant, line, clocks] of steps) {
      const step = { connector, text, parts, changes, instant, line, clocks };
      this.apply(state, step);
      this.steps.push(step);
      if (this.length % Run.stride === 0) this.kept.push(this.copy(state));
    }
  }
  /** The run after the first `from` steps is another one. */
  replace({ from, steps, candidates, names_from, names, end }) {
    this.steps.length = from;
    this.kept.length = Math.floor(from / Run.stride) + 1;
    this.candidates.length = from + 1;
    this.candidates.push(...candidates);
    names.forEach((name, k) => (this.names[names_from + k] = name));
    this.append(steps);
    this.end = end;
    this.madeStays = null;
    this.version = (this.version || 0) + 1;
  }

  get length() {
    return this.steps.length;
  }
  copy(state) {
    return { places: state.places.slice(), data: state.data.map((row) => row.slice()), clocks: state.clocks.map((row) => row.slice()) };
  }
  apply(state, step) {
    for (const [atom, places, values] of step.changes) {
      if (places !== null) state.places[atom] = places;
      for (const [variable, value] of values) state.data[atom][variable] = value;
    }
    for (const [atom, clock, ...set] of step.clocks || []) state.clocks[atom][clock] = set;
  }
  /** The state after so many steps. */
  at(position) {
    const kept = Math.floor(position / Run.stride);
    const state = this.copy(this.kept[kept]);
    for (let k = kept * Run.stride; k < position; ++k) this.apply(state, this.steps[k]);
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
    line.push([0, this.clockAt(now, unit, 0)]);
    for (const step of this.steps)
      for (const [other, row, ...set] of step.clocks || []) {
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
  /** Texts of the state's candidates, and how many there are. */
  choices(position) {
    const entry = this.candidates[position] || { rows: [], count: 0 };
    return { texts: entry.rows.map((row) => this.names[row]), count: entry.count };
  }
  /** The last state before here in which more than one thing could happen; -1: none. */
  lastChoice(position) {
    for (let k = Math.min(position, this.candidates.length) - 1; k >= 0; --k) if (this.candidates[k].count > 1) return k;
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
    const out = [[0, this.kept[0].data[atom][variable]]];
    this.steps.forEach((step, k) => {
      for (const [changed, , values] of step.changes)
        if (changed === atom) for (const [row, value] of values) if (row === variable) out.push([k + 1, value]);
    });
    return out;
  }
  instant(position) {
    return position === 0 ? 0 : this.steps[position - 1].instant;
  }
}

/** "1.5ms" of nanoseconds, with six digits. */
function timeText(ns) {
  for (const [unit, size] of [["s", 1e9], ["ms", 1e6], ["us", 1e3]]) if (ns >= size) return Number((ns / size).toPrecision(6)) + unit;
  return ns + "ns";
}
