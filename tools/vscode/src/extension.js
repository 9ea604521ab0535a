// Starts bipc-lsp for .bip files and hands the editor's requests to it, and bipc for what lenses and commands ask. All
// knowledge of the language is in these two.
"use strict";
const { execFile, spawn } = require("child_process");
const fs = require("fs");
const path = require("path");
const vscode = require("vscode");
const { CodeLensRequest, LanguageClient, TransportKind } = require("vscode-languageclient/node");
const { Verdicts } = require("./verdicts");

let client;
let verdicts;

/** Lenses are asked for again: a verdict is new. */
function refreshLenses() {
  for (const document of vscode.workspace.textDocuments) {
    if (document.languageId === "bip") client?.getFeature(CodeLensRequest.method)?.getProvider(document)?.onDidChangeCodeLensEmitter.fire();
  }
}

async function start() {
  const settings = vscode.workspace.getConfiguration("bip");
  const packaged = path.join(__dirname, "..", "server", "bipc-lsp");
  const command = settings.get("server.path") || (fs.existsSync(packaged) ? packaged : "bipc-lsp");
  client = new LanguageClient(
    "bip",
    "BIP",
    { command, args: ["--stdio"], transport: TransportKind.stdio },
    {
      documentSelector: [{ language: "bip" }],
      initializationOptions: { packageFolders: settings.get("packageFolders", []), explain: true },
      middleware: {
        provideCodeLenses: async (document, token, next) => {
          const lenses = await next(document, token);
          return lenses && verdicts.decorate(document, lenses);
        },
      },
    },
  );
  try {
    await client.start();
  } catch (error) {
    client = undefined;
    vscode.window.showErrorMessage(`BIP: \`${command}\` did not start (${error.message}). Set "bip.server.path" to the bipc-lsp of your build.`);
  }
}

async function stop() {
  const running = client;
  client = undefined;
  if (running) await running.stop();
}

const bipc = () => vscode.workspace.getConfiguration("bip").get("bipc.path", "bipc");
const folders = () => vscode.workspace.getConfiguration("bip").get("packageFolders", []).flatMap((folder) => ["-I", folder]);

/** The model that a lens or the active editor means; undefined, after a message, if there is none. */
function modelOf(uri) {
  const document = uri ? vscode.Uri.parse(uri) : vscode.window.activeTextEditor?.document.uri;
  if (!vscode.workspace.isTrusted) {
    vscode.window.showWarningMessage("BIP: models are run in trusted workspaces only.");
    return undefined;
  }
  if (document && document.scheme === "file") return document.fsPath;
  vscode.window.showWarningMessage("BIP: there is no saved model.");
  return undefined;
}

/** A task of bipc: its words are passed one by one, not through a shell. */
function taskOf(command, args) {
  const execution = new vscode.ProcessExecution(bipc(), [command, ...folders(), ...args]);
  return new vscode.Task({ type: "bipc", command, args }, vscode.TaskScope.Workspace, command, "bipc", execution, "$bipc");
}

const asked = new Map(); // tasks of `verify` that run: what they were asked

async function runTask(command, uri, args, expected = "") {
  const model = modelOf(uri);
  if (!model) return;
  await vscode.workspace.saveAll(false);
  const execution = await vscode.tasks.executeTask(taskOf(command, ["--diagnostics=short", ...args, model]));
  if (command === "verify" && uri) asked.set(execution, { uri, expected, options: args });
}

/** The end of a task that a lens began. */
function noteEnd({ execution, exitCode }) {
  const question = asked.get(execution);
  if (question && exitCode !== undefined) verdicts.note(question, exitCode);
  asked.delete(execution);
}

const rootOf = (root) => (root ? ["--root", root] : []);
const pages = new Set(); // processes that serve a page

/** A live page, in the browser; its process ends with the editor. */
async function openPage(uri, root) {
  const model = modelOf(uri);
  if (!model) return;
  const page = spawn(bipc(), ["view", "--port", "0", "--diagnostics=short", ...folders(), ...rootOf(root), model]);
  pages.add(page);
  let problems = "";
  page.stderr.on("data", (data) => (problems += data));
  page.on("error", (error) => vscode.window.showErrorMessage(`BIP: \`${bipc()}\` did not start (${error.message}).`));
  page.stdout.once("data", (data) => vscode.env.openExternal(vscode.Uri.parse(String(data).trim())));
  page.on("exit", (code) => {
    pages.delete(page);
    if (code) vscode.window.showErrorMessage("BIP: " + problems.split("\n")[0]);
  });
}

/** The page of the structure and the automata beside the text; made anew when the model is saved. */
async function showDiagram(context) {
  const model = modelOf();
  if (!model) return;
  const pane = vscode.window.createWebviewPanel("bip.diagram", path.basename(model), vscode.ViewColumn.Beside, { enableScripts: true, retainContextWhenHidden: true });
  const draw = () => {
    const words = ["graph", "--diagnostics=short", ...folders(), "--format", "html", "-o", "-", model];
    execFile(bipc(), words, { maxBuffer: 1 << 28 }, (error, page, problems) => {
      if (error) return vscode.window.showErrorMessage("BIP: " + problems.split("\n")[0]);
      pane.webview.html = page;
    });
  };
  const saved = vscode.workspace.onDidSaveTextDocument((document) => document.uri.fsPath === model && draw());
  pane.onDidDispose(() => saved.dispose(), undefined, context.subscriptions);
  draw();
}

/** The page of a diagnostic's code, `bipc explain CODE`, as the text of `bip-explain:/CODE.md`. */
function explainPage(uri) {
  const code = path.basename(uri.path, ".md");
  return new Promise((done) => {
    if (!/^[A-Z]\d{4}$/.test(code)) return done(`\`${code}\` is no code of bipc.`);
    execFile(bipc(), ["explain", code], (error, text, problems) => done(error ? problems || error.message : text));
  });
}

const explain = (code) => vscode.commands.executeCommand("markdown.showPreview", vscode.Uri.from({ scheme: "bip-explain", path: `/${code}.md` }));

function startDebugging(uri, root) {
  const model = modelOf(uri);
  if (model) return vscode.debug.startDebugging(undefined, { type: "bip", request: "launch", name: path.basename(model), program: model, ...(root ? { root } : {}), folders: vscode.workspace.getConfiguration("bip").get("packageFolders", []) });
}

function addCommands(context) {
  const commands = {
    "bip.run": (uri, root) => runTask("run", uri, ["--limit", "1000", ...rootOf(root)]),
    "bip.verify": (uri, root) => runTask("verify", uri, rootOf(root)),
    "bip.verifyLine": (uri, expected, options) => runTask("verify", uri, options, expected),
    "bip.explore": (uri, root) => runTask("explore", uri, rootOf(root)),
    "bip.debug": startDebugging,
    "bip.view": openPage,
    "bip.diagram": () => showDiagram(context),
    "bip.explain": explain,
  };
  for (const [name, act] of Object.entries(commands)) context.subscriptions.push(vscode.commands.registerCommand(name, act));
  context.subscriptions.push(
    vscode.workspace.registerTextDocumentContentProvider("bip-explain", { provideTextDocumentContent: explainPage }),
    vscode.debug.registerDebugAdapterDescriptorFactory("bip", { createDebugAdapterDescriptor: () => new vscode.DebugAdapterExecutable(bipc(), ["dap"]) }),
    vscode.tasks.registerTaskProvider("bipc", {
      provideTasks: () => [],
      resolveTask: (task) => Object.assign(taskOf(task.definition.command, task.definition.args || []), { definition: task.definition }),
    }),
    { dispose: () => pages.forEach((page) => page.kill()) },
  );
}

async function activate(context) {
  verdicts = new Verdicts(bipc, folders, refreshLenses);
  addCommands(context);
  context.subscriptions.push(
    verdicts,
    vscode.tasks.onDidEndTaskProcess(noteEnd),
    vscode.workspace.onDidChangeTextDocument(({ document, contentChanges }) => contentChanges.length > 0 && verdicts.forget(document.uri.toString())),
  );
  const restart = async () => {
    await stop();
    await start();
  };
  context.subscriptions.push(vscode.commands.registerCommand("bip.restartServer", restart));
  context.subscriptions.push(
    vscode.workspace.onDidChangeConfiguration(async (event) => {
      if (event.affectsConfiguration("bip")) await restart();
    }),
  );
  await start();
}

module.exports = { activate, deactivate: stop };
