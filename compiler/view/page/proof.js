// The invariants of a proof: each with whether its places hold in the state that is shown, and marked in the pictures.
"use strict";

class Proof {
  static words = { trap: "always at least one of", "one-token": "always exactly one of", lemma: "always one of", domain: "always one of" };

  constructor(page, proof) {
    this.page = page;
    this.proof = proof;
    this.chosen = -1;
    this.rows = proof.rows.map(([kind, total, terms], number) => ({ kind, total, terms, number, atoms: new Set(terms.flatMap(([, literals]) => literals.map(([atom]) => atom))) }));
  }
  /** The value of a variable in this state, a bool as 0 or 1; NaN: it is no number. */
  number(atom, variable) {
    const now = this.page.state.data[atom][variable];
    return now === "true" ? 1 : now === "false" ? 0 : Number(now);
  }
  /** Does the literal hold? null: it cannot be said from what the page has. */
  holds([atom, places, values, isNegated]) {
    const { run, state } = this.page;
    if (!run.exists) return null;
    const here = state.places[atom].split(", ");
    let is = !places || places.every((place) => here.includes(place));
    for (const [variable, value] of values) {
      const as = this.number(atom, variable);
      if (value === null || Number.isNaN(as)) return null;
      const range = value.split("..").map(Number);
      if (value.startsWith(":")) is = is && ((as >> Number(value.slice(1))) & 1) === 1;
      else is = is && as >= range[0] && as <= range[range.length - 1];
    }
    return is !== isNegated;
  }
  termHolds([, literals]) {
    const all = literals.map((literal) => this.holds(literal));
    return all.includes(null) ? null : all.every(Boolean);
  }
  /** The left side in this state, as a text; empty if a part of it is not known. */
  sum(row) {
    let sum = 0;
    for (const [weight, literals] of row.terms) {
      const [atom, places, values] = literals[0];
      const isVariable = literals.length === 1 && places === null && values[0][1] === null;
      const value = isVariable ? Number(this.page.state.data[atom][values[0][0]]) : this.termHolds([weight, literals]);
      if (value === null || Number.isNaN(value)) return "";
      sum += Number(weight) * Number(value);
    }
    return String(sum | 0);
  }
  literalText([atom, places, values, isNegated]) {
    const { run } = this.page, type = run.type(atom);
    const data = values.map(([variable, value]) => type.variables[variable] + (value === null ? "" : value.startsWith(":") ? " bit " + value.slice(1) : " = " + value));
    const where = places ? "@" + places.join("@") + (data.length > 0 ? " (" + data.join(", ") + ")" : "") : "." + data.join(", ");
    return (isNegated ? "not " : "") + run.name(atom) + where;
  }
  // ---- with time: states with zones
  /** Locations with the places and data of this state; several differ in who waits for its `resume`. */
  locations() {
    const { run, state } = this.page;
    return run.exists
      ? this.proof.locations.map((location, number) => ({ ...location, number })).filter(
          ({ places, values }) => places.every((text, atom) => text === null || text === state.places[atom]) && values.every(([atom, variable, value]) => this.number(atom, variable) === value))
      : [];
  }
  /** ns that the clock shows in this state. */
  clock(atom, clock) {
    const { run, state, position } = this.page, [value, since, speed] = state.clocks[atom][clock];
    return value + (run.instant(position) - since) * speed;
  }
  bound(bound) {
    const [low, high] = bound.slice(-2), name = (atom, clock) => this.page.run.name(atom) + "." + this.page.run.clocksOf(atom)[clock][0];
    const isDifference = bound.length === 6, value = this.clock(bound[0], bound[1]) - (isDifference ? this.clock(bound[2], bound[3]) : 0);
    const time = (ns) => (ns < 0 ? "−" : "") + timeText(Math.abs(ns));
    const text = name(bound[0], bound[1]) + (isDifference ? " − " + name(bound[2], bound[3]) : "") + (low === null ? " ≤ " + time(high) : " ≥ " + time(low));
    return { text, holds: (low === null || value >= low) && (high === null || value <= high) };
  }
  /** Without what says nothing; two clocks with a constant difference are one equation. */
  zoneText(zone) {
    const name = (atom, clock) => this.page.run.name(atom) + "." + this.page.run.clocksOf(atom)[clock][0];
    const most = new Map(zone.filter((bound) => bound.length === 6).map((bound) => [bound.slice(0, 4).join(), bound[5]]));
    return zone.map((bound) => {
      const [atom, clock, other, otherClock, , high] = bound;
      if (bound.length === 4) return bound[2] === 0 ? "" : this.bound(bound).text;
      if (most.get([other, otherClock, atom, clock].join()) !== -high) return this.bound(bound).text;
      if (high < 0 || (high === 0 && [other, otherClock] < [atom, clock])) return "";
      return name(atom, clock) + " = " + name(other, otherClock) + (high === 0 ? "" : " + " + timeText(high));
    }).filter(Boolean).join(", ") || "any time";
  }
  zones() {
    return this.locations().flatMap((location) => location.zones.map((zone) => ({ location, zone, bounds: zone.map((bound) => this.bound(bound)) })))
      .map((row) => ({ ...row, holds: row.bounds.every((bound) => bound.holds) }));
  }
  showZones(panel) {
    const { locations, claim, left_out } = this.proof, count = locations.reduce((sum, location) => sum + location.zones.length, 0);
    const head = element("div", { class: "soft" }, "claim: " + claim + " · " + count + " zones of " + locations.length + " locations" + (left_out ? " (" + left_out + " zones are not shown)" : "") +
      ". Below: the zones with the places and data of this state. Marked: those that hold now.");
    const zones = this.zones().sort((a, b) => b.holds - a.holds).slice(0, 500);
    const table = element("table", {}, ...zones.map(({ location, zone, holds }) => element("tr", holds ? { class: "now" } : {}, element("td", {}, "#" + location.number),
      element("td", { style: "white-space:normal" }, this.zoneText(zone)),
      element("td", { class: "soft" }, location.waits.length > 0 ? "while " + location.waits.map((atom) => this.page.run.name(atom)).join(", ") + " waits" : ""))));
    panel.replaceChildren(head, table);
  }
  show(panel) {
    if (this.proof.locations) return this.showZones(panel);
    const head = element("div", { class: "soft" }, "claim: " + this.proof.claim + " · method: " + this.proof.method + " · " + this.rows.length + " invariants" +
      (this.proof.left_out ? " (" + this.proof.left_out + " rows are not shown)" : "") + ". Marked: what holds in this state.");
    const rows = this.rows.filter((row) => !this.page.isFiltered || this.page.filter.some((atom) => row.atoms.has(atom)));
    const isMine = (row) => row.atoms.has(this.page.atom);
    const sorted = [...rows.filter(isMine), ...rows.filter((row) => !isMine(row))].slice(0, 500);
    const table = element("table", {}, ...sorted.map((row) => this.line(row)));
    panel.replaceChildren(head, table);
    if (rows.length > sorted.length) panel.append("… and " + (rows.length - sorted.length) + " more: the search field shows those of a component");
  }
  line(row) {
    const weighted = row.kind === "sum" || row.kind === "equation";
    const cell = element("td", { style: "white-space:normal" });
    cell.append(weighted ? "always " + row.total + " = " : Proof.words[row.kind] + " ");
    row.terms.forEach((term, k) => {
      const [weight, literals] = term;
      if (k > 0) cell.append(weighted ? " + " : ", ");
      if (weighted && weight !== "1") cell.append(weight + " × ");
      const text = literals.map((literal) => this.literalText(literal)).join(" and ");
      cell.append(element("button", { class: "row-link" + (this.termHolds(term) ? " changed" : ""), onclick: () => this.choose(row.number, literals[0][0]) }, text));
    });
    const now = weighted && this.page.run.exists ? this.sum(row) : "";
    const line = element("tr", row.number === this.chosen ? { class: "now" } : {}, element("td", {}, element("button", { class: "row-link soft", title: "mark its components", onclick: () => this.choose(row.number, -1) }, "#" + row.number)), cell);
    if (now !== "") line.append(element("td", { class: "soft" }, "now " + now));
    return line;
  }
  choose(number, atom) {
    this.chosen = number === this.chosen && atom < 0 ? -1 : number;
    if (atom >= 0) this.page.choose(atom);
    else this.page.render();
  }
  /** Marks the chosen invariant's components, and its places in the shown automaton. */
  mark(picture, automaton, atom) {
    for (const box of picture.svg.querySelectorAll(".invariant")) box.classList.remove("invariant");
    for (const place of automaton.querySelectorAll(".invariant")) place.classList.remove("invariant");
    const row = this.rows[this.chosen];
    if (!row) return;
    for (const other of row.atoms) picture.boxOfAtom.get(other)?.classList.add("invariant");
    const names = new Set(row.terms.flatMap(([, literals]) => literals.filter(([other, places]) => other === atom && places).flatMap(([, places]) => places)));
    const type = this.page.run.type(atom);
    for (const place of automaton.querySelectorAll("[data-place]")) place.classList.toggle("invariant", names.has(type.places[place.dataset.place]));
  }
}
