// Starts bipc-lsp for .bip files and hands the editor's requests to it. All knowledge of the language is in the server.
"use strict";
const vscode = require("vscode");
const { LanguageClient, TransportKind } = require("vscode-languageclient/node");

let client;

async function start() {
  const settings = vscode.workspace.getConfiguration("bip");
  const command = settings.get("server.path", "bipc-lsp");
  client = new LanguageClient(
    "bip",
    "BIP",
    { command, args: ["--stdio"], transport: TransportKind.stdio },
    {
      documentSelector: [{ language: "bip" }],
      initializationOptions: { packageFolders: settings.get("packageFolders", []) },
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

async function activate(context) {
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
