// The page of a session that runs (`bipc view --port`): what is possible is taken, over a WebSocket.
"use strict";

class Live extends Connection {
  constructor(page) {
    super(page, "The session has ended: bipc is gone. The run can still be looked at.");
    this.watches = [];
    this.breakpoints = [];
    this.isMoving = false;
    this.panel = this.makePanel();
    for (const [id, name, title, act] of [["walk-one", "random step", "a step that the policy chooses, from here (w)", () => this.walk(1)], ["run-on", "run", "run on to a breakpoint or the end (r)", () => this.runOn()], ["stop", "stop", "stop the run (s)", () => this.stop()]]) {
      const button = element("button", { id, title, onclick: act }, name);
      $("scrubber").before(button);
    }
  }

  // -- Messages --

  /** A request that moves the model, from the position that this page shows. */
  move(what, fields) {
    // A key that comes before the answer is not lost; of several the last one counts.
    if (this.isMoving) {
      this.waiting = [what, fields];
      return;
    }
    this.isMoving = true;
    this.say("");
    this.ask(what, { at: this.page.position, ...fields }, (answer) => {
      this.isMoving = false;
      this.say(answer.ok ? answer.halt || "" : answer.error);
      this.page.render();
      const next = this.waiting;
      this.waiting = null;
      if (next && answer.ok && answer.halt !== "stopped") this.move(...next);
    });
  }
  hear(message) {
    if (message.note === "run") {
      this.page.run.replace(message);
      this.page.plot.found = null;
      $("scrubber").max = this.page.run.length;
      // What this page has begun is followed; else it stays where it is.
      this.page.go(!this.greeted ? this.page.run.length : this.isMoving ? message.position : this.page.position);
      if (message.halt && this.isMoving) this.say(message.halt);
      this.greeted = true;
    } else if (message.note === "breakpoints") {
      this.breakpoints = message.texts;
      this.showBreakpoints();
    } else {
      this.answer(message);
    }
  }

  // -- What a person does --

  take(candidate) {
    this.move("take", { candidate });
  }
  walk(count) {
    this.move("walk", { count });
  }
  runOn() {
    this.move("run", { until: this.until.value.trim() });
  }
  stop() {
    this.ask("stop", {});
  }
  why(name) {
    this.whyName.value = name;
    this.ask("why", { at: this.page.position, name }, (answer) => (this.whyText.textContent = answer.ok ? answer.text : answer.error));
  }
  save() {
    this.ask("save", { at: this.page.position }, (answer) => {
      if (!answer.ok) return this.say(answer.error);
      const address = URL.createObjectURL(new Blob([answer.trace], { type: "application/jsonl" }));
      element("a", { href: address, download: "run.jsonl" }).click();
      setTimeout(() => URL.revokeObjectURL(address), 1000);
    });
  }
  setBreakpoints(texts, added) {
    this.ask("breakpoints", { texts }, (answer) => {
      const problem = answer.ok ? answer.problems[texts.indexOf(added)] : answer.error;
      this.say(problem ? added + ": " + problem : "");
      if (!problem) this.breakpointText.value = "";
    });
  }

  // -- The panel --

  makePanel() {
    const field = (label, attributes) => element("input", { type: "text", size: 24, "aria-label": label, placeholder: label, spellcheck: "false", ...attributes });
    const form = (act, ...children) => element("form", { onsubmit: (event) => (event.preventDefault(), act()) }, ...children);
    const button = (name) => element("button", {}, name);
    this.count = field("steps", { type: "number", min: 1, max: 100000, value: 10, style: "width:6em" });
    this.until = field("run until: phil[0]@EATS, x > 3, @1s (empty: the end)", { id: "until", size: 44 });
    this.time = field("+20us, or an instant: 1s500ms", {});
    this.port = field("port for events", {});
    this.values = field("values: 3 true", {});
    this.breakpointText = field("breakpoint: phil[0]@EATS, a.port, 12, x > 3", { id: "breakpoint", size: 44 });
    this.watchText = field("watch: phil[0].meals + 1", { id: "watch", size: 44 });
    this.whyName = field("connector or component.port (empty: the deadlock)", { id: "why", size: 44 });
    this.breakpointList = element("div", { id: "breakpoints" });
    this.watchList = element("div", { id: "watches" });
    this.whyText = element("pre", { id: "why-text" });
    this.laterList = element("div", {});
    const rows = [
      [form(() => this.walk(Number(this.count.value) || 1), this.count, button("random walk")), form(() => this.runOn(), this.until, button("run"))],
      [form(() => this.setBreakpoints([...this.breakpoints, this.breakpointText.value.trim()], this.breakpointText.value.trim()), this.breakpointText, button("stop there")), this.breakpointList],
      [form(() => this.addWatch(), this.watchText, button("watch")), this.watchList],
      [form(() => this.why(this.whyName.value.trim()), this.whyName, button("why not?")), this.whyText],
      [form(() => this.move("post", { port: this.port.value.trim(), values: this.values.value.trim() }), this.port, this.values, button("deliver event"))],
      [element("button", { id: "save", onclick: () => this.save() }, "save the run up to here as a trace")],
    ];
    if (this.page.run.isTimed) rows.splice(1, 0, [form(() => this.move("delay", { time: this.time.value.trim() }), this.time, button("let time pass"))]);
    return element("div", { class: "drive" }, ...rows.map((children) => element("div", { class: "drive-row" }, ...children)));
  }
  show(panel) {
    if (!panel.contains(this.panel)) panel.replaceChildren(this.panel);
    // A reason is one of a state.
    const state = this.page.position + " " + this.page.run.version;
    if (this.reasonOf !== state) this.whyText.textContent = "";
    this.reasonOf = state;
    this.refresh();
  }
  addWatch() {
    const text = this.watchText.value.trim();
    if (text && !this.watches.includes(text)) this.watches.push(text);
    this.watchText.value = "";
    this.refresh();
  }
  /** Values of the watched expressions here; one question at a time. */
  refresh() {
    if (this.watches.length === 0 || this.isMoving) return this.showWatches([]);
    clearTimeout(this.timer);
    this.timer = setTimeout(() => {
      const texts = this.watches.slice();
      this.ask("watch", { at: this.page.position, texts }, (answer) => this.showWatches(answer.ok ? answer.values : texts.map(() => [answer.error, false])));
    }, 60);
  }
  showWatches(values) {
    if (values.length !== this.watches.length) return;
    this.watchList.replaceChildren(...this.watches.map((text, k) =>
      this.row(text + " = ", element("span", { class: values[k][1] ? "changed" : "soft" }, values[k][0]), () => {
        this.watches.splice(k, 1);
        this.showWatches(values.filter((_, other) => other !== k));
      })));
  }
  showBreakpoints() {
    this.breakpointList.replaceChildren(...this.breakpoints.map((text, k) =>
      this.row(text, "", () => this.setBreakpoints(this.breakpoints.filter((_, other) => other !== k), ""))));
  }
  row(text, value, remove) {
    return element("div", {}, element("button", { class: "row-link soft", title: "remove", "aria-label": "remove " + text, onclick: remove }, "✕ "), text, value);
  }
  /** In models with time: what becomes possible later, under the candidates. */
  showLater(list) {
    if (!this.page.run.isTimed || this.isMoving) return;
    const position = this.page.position;
    this.ask("later", { at: position }, (answer) => {
      if (!answer.ok || position !== this.page.position || !list.isConnected) return;
      for (const [text, instants, first] of answer.later)
        list.append(element("div", {}, element("button", { class: "row-link later", title: "let time pass to the first of these instants", onclick: () => this.move("delay", { time: first + "ns" }) }, "later: " + text.replace(/\bROOT\./g, "") + " " + instants)));
    });
  }
}
