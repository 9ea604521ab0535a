// Activates the VS Code extension (tools/vscode/src/extension.js) without an editor: what it uses of VS Code's interface
// and of the language client of npm is replaced by what writes down what it is given. Arguments: bipc, codes of
// diagnostics. Prints the registered commands, what the server is told, and the page of each code, as JSON.
"use strict";
const Module = require("module");
const path = require("path");

const [bipc, ...codes] = process.argv.slice(2);
const registered = [];
const executed = [];
let provider;
let told;
const nothing = { dispose: () => {} };
const vscode = {
  workspace: {
    isTrusted: true,
    textDocuments: [],
    getConfiguration: () => ({ get: (name, otherwise) => (name === "bipc.path" ? bipc : otherwise) }),
    onDidChangeTextDocument: () => nothing,
    onDidChangeConfiguration: () => nothing,
    registerTextDocumentContentProvider: (scheme, one) => {
      provider = { scheme, one };
      return nothing;
    },
  },
  commands: {
    registerCommand: (name, act) => {
      registered.push({ name, act });
      return nothing;
    },
    executeCommand: (...words) => executed.push(words),
  },
  debug: { registerDebugAdapterDescriptorFactory: () => nothing },
  tasks: { registerTaskProvider: () => nothing, onDidEndTaskProcess: () => nothing },
  tests: { createTestController: () => ({ items: new Map(), createRunProfile: () => {}, dispose: () => {} }) },
  TestRunProfileKind: { Run: 1 },
  Uri: { from: (parts) => parts },
  window: { showErrorMessage: (text) => executed.push(["error", text]) },
};
const languageClient = {
  TransportKind: { stdio: 0 },
  CodeLensRequest: { method: "textDocument/codeLens" },
  LanguageClient: class {
    constructor(_id, _name, _server, options) {
      told = options.initializationOptions;
    }
    async start() {}
    async stop() {}
  },
};
const load = Module._load;
Module._load = (name, ...more) => (name === "vscode" ? vscode : name === "vscode-languageclient/node" ? languageClient : load(name, ...more));
const extension = require(path.join(__dirname, "../../tools/vscode/src/extension.js"));

(async () => {
  await extension.activate({ subscriptions: [] });
  const explain = registered.find(({ name }) => name === "bip.explain").act;
  const pages = [];
  for (const code of codes) {
    explain(code);
    const [command, address] = executed.at(-1);
    pages.push({ command, scheme: address.scheme, text: await provider.one.provideTextDocumentContent(address) });
  }
  await extension.deactivate();
  process.stdout.write(JSON.stringify({ commands: registered.map(({ name }) => name), told, scheme: provider.scheme, pages }));
})();
