// The page of a model that `bipc serve` runs (`bipc view --attach`): it is watched, and steered if its role allows that.
"use strict";

class Attached extends Connection {
  constructor(page) {
    super(page, "The session has ended: the model or bipc is gone. What was seen can still be looked at.");
    this.role = page.data.attached;
    this.mayPost = this.role !== "observer";
    this.maySteer = this.role === "operator";
    this.model = { paused: false, ended: false, time: 0, steps: 0, late: 0 };
    this.panel = this.makePanel();
    this.status = element("output", { id: "model-status", "aria-live": "off" });
    $("scrubber").before(this.status);
    this.buttons = [["pause", "pause", "the model's time stands still (s)", () => this.stop()], ["resume", "resume", "the model goes on (r)", () => this.runOn()],
      ["walk-one", "step", "a step that the model's policy chooses (w)", () => this.walk(1)], ["undo", "undo", "undo the last step (b)", () => this.undo()]]
      .map(([id, name, title, act]) => element("button", { id, title: this.maySteer ? title : "takes the role of an operator", onclick: act }, name));
    for (const button of this.buttons) $("scrubber").before(button);
    this.showModel();
  }

  // -- Messages --

  steer(what, fields) {
    if (!this.maySteer) return this.say("`" + what + "` takes the role of an operator: this page is of a" + (this.role === "observer" ? "n " : " ") + this.role);
    this.say("");
    this.page.go(this.page.run.length);
    this.ask(what, fields || {}, (answer) => this.say(answer.ok ? "" : answer.error));
  }
  hear(message) {
    const run = this.page.run;
    if (message.note === "begin") {
      run.begin(message);
      this.page.plot.found = null;
      this.page.go(0);
    } else if (message.note === "run") {
      // Who looks at an earlier state stays there.
      const follows = !this.greeted || this.page.position === run.length;
      run.replace(message);
      this.page.plot.found = null;
      $("scrubber").max = run.length;
      this.page.go(follows ? run.length : this.page.position);
      this.greeted = true;
    } else if (message.note === "model") {
      this.model = message;
      this.showModel();
      this.page.render();
    } else if (message.note === "said") this.say(message.text.replace(/\bROOT\./g, ""));
    else {
      this.answer(message);
    }
  }
  showModel() {
    const m = this.model, stands = m.paused || m.ended;
    this.status.textContent = this.role + " · " + (m.ended ? "ended" : m.paused ? "paused" : "runs") + " · " + m.steps + " steps" +
      (this.page.run.isTimed ? " · " + timeText(m.time) : "") + (m.late ? " · " + m.late + " late" : "");
    const [pause, resume, step, undo] = this.buttons;
    pause.disabled = !this.maySteer || stands;
    resume.disabled = step.disabled = !this.maySteer || !stands || m.ended;
    undo.disabled = !this.maySteer || !stands;
  }
  /** Is what is shown the model's present state, and does it stand still? */
  get canFire() {
    return this.maySteer && this.page.position === this.page.run.length && this.model.paused && !this.model.ended;
  }
  get whyNot() {
    if (!this.maySteer) return "takes the role of an operator";
    return this.page.position < this.page.run.length ? "this was an earlier state: End goes to the present one" : "the model is not paused";
  }

  // -- What a person does --

  take(candidate) {
    this.steer("fire", { candidate, steps: this.model.steps });
  }
  walk(count) {
    this.steer("step", { count });
  }
  runOn() {
    this.steer("resume");
  }
  stop() {
    this.steer("pause");
  }
  undo() {
    this.steer("back", { count: 1 });
  }
  why(path) {
    this.whyName.value = path;
    this.ask("why", { path }, (answer) => (this.whyText.textContent = answer.ok ? answer.text : answer.error));
  }

  // -- The panel --

  makePanel() {
    const field = (label, attributes) => element("input", { type: "text", size: 24, "aria-label": label, placeholder: label, spellcheck: "false", ...attributes });
    const form = (act, ...children) => element("form", { onsubmit: (event) => (event.preventDefault(), act()) }, ...children);
    const button = (name, may) => element("button", may ? {} : { disabled: "", title: "this page is of a" + (this.role === "observer" ? "n " : " ") + this.role }, name);
    this.count = field("steps", { type: "number", min: 1, max: 100000, value: 10, style: "width:6em" });
    this.breakpointText = field("pause after: table.left[0], table.phil[0].take_left (empty: nowhere)", { id: "breakpoint", size: 56 });
    this.port = field("port for events", { id: "port" });
    this.values = field("values: 3 true", { id: "values" });
    this.whyName = field("connector or component.port", { id: "why", size: 44 });
    this.whyText = element("pre", { id: "why-text" });
    const rows = [
      [form(() => this.walk(Number(this.count.value) || 1), this.count, button("take steps", this.maySteer))],
      [form(() => this.steer("break", { path: this.breakpointText.value.trim() }), this.breakpointText, button("pause there", this.maySteer))],
      [form(() => this.why(this.whyName.value.trim()), this.whyName, button("why not?", true)), this.whyText],
      [form(() => this.ask("post", { port: this.port.value.trim(), values: this.values.value.trim() }, (answer) => this.say(answer.ok ? "" : answer.error)), this.port, this.values, button("deliver event", this.mayPost))],
    ];
    return element("div", { class: "drive" }, ...rows.map((children) => element("div", { class: "drive-row" }, ...children)));
  }
  show(panel) {
    if (!panel.contains(this.panel)) panel.replaceChildren(this.panel);
    if (this.reasonOf !== this.model.steps) this.whyText.textContent = "";
    this.reasonOf = this.model.steps;
  }
  showLater() {}
}
