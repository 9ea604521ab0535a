// The verdicts of the VS Code extension (tools/vscode/src/verdicts.js) without an editor: the few parts of VS Code's
// interface that they use, in memory. Arguments: bipc, a model, the lenses of the language server as JSON. Prints what
// the test explorer and the lenses then show, as JSON.
"use strict";
const Module = require("module");
const path = require("path");

class Items extends Map {
  replace(items) {
    this.clear();
    items.forEach((item) => this.add(item));
  }
  add(item) {
    this.set(item.id, item);
  }
}
const results = [];
const token = { isCancellationRequested: false, onCancellationRequested: () => {} };
let profile;
const vscode = {
  TestRunProfileKind: { Run: 1 },
  TestMessage: class {
    constructor(message) {
      this.message = message;
    }
  },
  CodeLens: class {
    constructor(range, command) {
      Object.assign(this, { range, command });
    }
  },
  workspace: { isTrusted: true, saveAll: async () => true, asRelativePath: (uri) => path.basename(uri.fsPath) },
  window: { showWarningMessage: (text) => results.push(["warning", text]) },
  tests: {
    createTestController: () => ({
      items: new Items(),
      createRunProfile: (_name, _kind, run) => (profile = run),
      createTestItem: (id, label, uri) => ({ id, label, uri, children: new Items() }),
      createTestRun: () => ({
        enqueued: () => {},
        started: () => {},
        end: () => results.push(["end"]),
        skipped: (item) => results.push(["skipped", item.label]),
        appendOutput: () => {},
        passed: (item) => results.push(["passed", item.label]),
        failed: (item, { message }) => results.push(["failed", item.label, message.split("\n")[0]]),
        errored: (item, { message }) => results.push(["errored", item.label, message.split("\n")[0]]),
      }),
      dispose: () => {},
    }),
  },
};
const load = Module._load;
Module._load = (name, ...more) => (name === "vscode" ? vscode : load(name, ...more));
const { Verdicts } = require("../../tools/vscode/src/verdicts.js");

(async () => {
  const [bipc, model, lenses] = process.argv.slice(2);
  let refreshed = 0;
  const verdicts = new Verdicts(
    () => bipc,
    () => [],
    () => refreshed++,
  );
  const document = { uri: { fsPath: model, toString: () => "file://" + model } };
  const asked = JSON.parse(lenses);
  verdicts.decorate(document, asked);
  await profile({}, token);
  const shown = verdicts.decorate(document, asked).filter((lens) => lens.command.command === "");
  verdicts.forget("file://" + model);
  const left = verdicts.decorate(document, asked).length - asked.length;
  vscode.workspace.isTrusted = false;
  await profile({}, token);
  process.stdout.write(JSON.stringify({ results, shown: shown.map((lens) => lens.command.title), refreshed, left }));
})();
