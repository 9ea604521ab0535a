// Verdicts of `bipc verify`: beside the lenses that asked for them, and in the test explorer.
//
// A question is a lens of the language server: a compound without parameters, or a line `// verify:`. Its key is the
// document and the options of the command line; the text may have changed since, so an edit removes the verdicts.
"use strict";
const { execFile } = require("child_process");
const vscode = require("vscode");

/** The exit codes of `bipc verify` and the verdicts that lines `// verify:` name. */
const CODES = { free: 0, holds: 0, deadlock: 3, violated: 3, unknown: 4 };

/** What `bipc verify` found, in a word, and whether it is what was expected: without a word that there is nothing wrong. */
function verdictOf({ expected, options }, code) {
  const found = { 0: "holds", 3: "violated", 4: "unknown" }[code];
  if (!found) return { word: "failed", icon: "$(warning)", isGood: false };
  const isProperty = options.some((option) => option.startsWith("--property"));
  const word = isProperty || code === 4 ? found : code === 0 ? "free of deadlocks" : "deadlock";
  const isGood = code === (expected ? CODES[expected] : 0);
  return { word, icon: isGood ? "$(pass)" : code === 4 ? "$(question)" : "$(error)", isGood };
}

const keyOf = ({ uri, expected, options }) => JSON.stringify([uri, expected, options]);

/** What a lens asks; undefined: nothing. */
function questionOf(lens) {
  const [uri, second, options] = lens.command?.arguments || [];
  if (lens.command?.command === "bip.verify") return { uri, expected: "", options: ["--root", second], label: `${second} is free of deadlocks` };
  if (lens.command?.command === "bip.verifyLine") return { uri, expected: second, options, label: [second, ...options].filter(Boolean).join(" ") };
  return undefined;
}

class Verdicts {
  constructor(bipc, folders, refresh) {
    this.bipc = bipc;
    this.folders = folders;
    this.refresh = refresh;
    this.known = new Map();
    this.controller = vscode.tests.createTestController("bipc", "BIP");
    this.controller.createRunProfile("Verify", vscode.TestRunProfileKind.Run, (request, token) => this.run(request, token), true);
  }

  dispose() {
    this.controller.dispose();
  }

  /** Lenses with the verdicts that are known in front of them. Tells the test explorer which questions there are. */
  decorate(document, lenses) {
    this.list(document, lenses);
    return lenses.flatMap((lens) => {
      const question = questionOf(lens);
      const verdict = question && this.known.get(keyOf(question));
      return verdict ? [new vscode.CodeLens(lens.range, { title: `${verdict.icon} ${verdict.word}`, command: "" }), lens] : [lens];
    });
  }

  list(document, lenses) {
    const uri = document.uri.toString();
    const questions = lenses.map((lens) => ({ lens, question: questionOf(lens) })).filter(({ question }) => question);
    if (questions.length === 0) return this.controller.items.delete(uri);
    const file = this.controller.items.get(uri) || this.controller.createTestItem(uri, vscode.workspace.asRelativePath(document.uri), document.uri);
    file.children.replace(
      questions.map(({ lens, question }) => {
        const item = this.controller.createTestItem(keyOf(question), question.label, document.uri);
        item.range = lens.range;
        this.questions = (this.questions || new WeakMap()).set(item, question);
        return item;
      }),
    );
    this.controller.items.add(file);
  }

  /** The exit code of a task that asked. */
  note(question, code) {
    this.known.set(keyOf(question), verdictOf(question, code));
    this.refresh();
  }

  forget(uri) {
    for (const key of this.known.keys()) if (JSON.parse(key)[0] === uri) this.known.delete(key);
  }

  async run(request, token) {
    const run = this.controller.createTestRun(request);
    if (!vscode.workspace.isTrusted) {
      vscode.window.showWarningMessage("BIP: models are verified in trusted workspaces only.");
      return run.end();
    }
    await vscode.workspace.saveAll(false);
    const excluded = new Set(request.exclude || []);
    const asked = [];
    const add = (item) => {
      if (excluded.has(item)) return;
      if (item.children.size === 0) asked.push(item);
      item.children.forEach(add);
    };
    if (request.include) request.include.forEach(add);
    else this.controller.items.forEach(add);
    asked.forEach((item) => run.enqueued(item));
    for (const item of asked) {
      if (token.isCancellationRequested) run.skipped(item);
      else await this.verify(run, item, token);
    }
    run.end();
    this.refresh();
  }

  verify(run, item, token) {
    const question = this.questions.get(item);
    const { expected, options } = question;
    run.started(item);
    const begun = Date.now();
    return new Promise((resolve) => {
      const args = ["verify", "--json", "--diagnostics=short", ...this.folders(), ...options, item.uri.fsPath];
      const process = execFile(this.bipc(), args, { maxBuffer: 1 << 26 }, (error, output, problems) => {
        const took = Date.now() - begun;
        const verdict = verdictOf(question, error ? error.code : 0);
        this.known.set(keyOf(question), verdict);
        let answer;
        try {
          answer = JSON.parse(output);
        } catch {
          run.errored(item, new vscode.TestMessage(problems || (error ? error.message : "bipc verify gave no answer")), took);
          return resolve();
        }
        run.appendOutput(answer.text.replace(/\n/g, "\r\n"), undefined, item);
        if (verdict.isGood) run.passed(item, took);
        else run.failed(item, new vscode.TestMessage(expected ? `expected: ${expected}; found: ${verdict.word}\n${answer.text}` : answer.text), took);
        resolve();
      });
      token.onCancellationRequested(() => process.kill());
    });
  }
}

module.exports = { Verdicts };
