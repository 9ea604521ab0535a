"""Random edits of every model: a server that has read the text many times answers as one that reads it first.

Both get each text; compared are diagnostics, outline, semantic tokens, folding ranges, inlay hints and formatting. Most edits keep the text
readable, as most of what is kept of a document is used for such texts. The controller of Dala is a large document, of which a server reads
no more than an answer needs: its requests come in random order, some edits without any.
"""
import pathlib
import random
import subprocess
import tempfile

import client
import edits

COMMENTS = ["// a comment\n", "/* two\nlines */", " ", "\n", "\n\n"]


def harmless(rng, text):
    """(begin, end, replacement): a change that moves what follows; it seldom breaks anything."""
    starts = client.lines_of(text)
    at = rng.choice(starts)
    return at, at, rng.choice(COMMENTS)


def answers(c, uri, text):
    document = {"textDocument": {"uri": uri}}
    whole = {"range": {"start": {"line": 0, "character": 0}, "end": client.position(text, len(text))}}
    return {
        "diagnostics": c.result("textDocument/diagnostic", document),
        "outline": c.result("textDocument/documentSymbol", document),
        "tokens": c.result("textDocument/semanticTokens/full", document),
        "folds": c.result("textDocument/foldingRange", document),
        "hints": c.result("textDocument/inlayHint", {**document, **whole}),
        "format": c.result("textDocument/formatting", {**document, "options": {}}),
    }


def named(uri, where, name):
    """Requests about the name at a position, and others that need parts of a check, by their name."""
    document = {"textDocument": {"uri": uri}}
    at = {**document, "position": where}
    seen = {"range": {"start": {"line": max(0, where["line"] - 40), "character": 0}, "end": {"line": where["line"] + 40, "character": 0}}}
    methods = {"references": {**at, "context": {"includeDeclaration": True}}, "rename": {**at, "newName": name}, "prepareRename": at, "definition": at,
               "hover": at, "documentHighlight": at, "codeAction": {**document, **seen, "context": {"diagnostics": []}}, "inlayHint": {**document, **seen},
               "semanticTokens/range": {**document, **seen}, "diagnostic": document, "documentSymbol": document, "formatting": {**document, "options": {}}}
    made = {key: ("textDocument/" + key, params) for key, params in methods.items()}
    made["symbol"] = ("workspace/symbol", {"query": "ndd"})
    return made


def ask_together(c, requests):
    """Answers by the requests' names. All are sent before the first is answered, so that the server has no pause between them."""
    ids = {}
    for key, (method, params) in requests:
        c.next_id += 1
        ids[c.next_id] = key
        c.send({"jsonrpc": "2.0", "id": c.next_id, "method": method, "params": params})
    answers = {}
    while len(answers) < len(ids):
        message = c.receive()
        if message.get("id") in ids:
            answers[ids[message["id"]]] = {**message, "id": 0}
    return answers


def send_only(c, requests):
    """The answers are read, and dropped, with the next ones."""
    for _, (method, params) in requests:
        c.next_id += 1
        c.send({"jsonrpc": "2.0", "id": c.next_id, "method": method, "params": params})


def run_large(edits_count, seed, report):
    rng = random.Random(seed)
    passed = failed = 0
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "dala.bip"
        subprocess.run([client.BIPC, "rules", client.ROOT / "models/dala/dala.rules", "-o", path], check=True, stdout=subprocess.DEVNULL)
        uri, original = path.as_uri(), path.read_text(encoding="utf-8")
        kept, other = client.Client(), client.Client()
        kept.start()
        other.start()
        kept.open(uri, original)
        text, version = original, 1
        for count in range(edits_count):
            # One edit, or two between which nothing or one thing is asked.
            for _ in range(rng.randrange(1, 3)):
                version += 1
                if rng.random() < 0.2:
                    text = original
                    kept.change(uri, version, [{"text": text}])
                else:
                    begin, end, what = harmless(rng, text) if rng.random() < 0.6 else edits.edit(rng, text)
                    kept.change(uri, version, [{"range": {"start": client.position(text, begin), "end": client.position(text, end)}, "text": what}])
                    text = text[:begin] + what + text[end:]
                # A word of the text: most are names.
                spans = [m.start() for m in edits.TOKEN.finditer(text, len(text) // 3, len(text) // 3 + 60000) if m.group().isidentifier()]
                where = client.position(text, rng.choice(spans))
                name = rng.choice(("another_name", "S", "r1", "p"))
                asked = named(uri, where, name)
                if rng.random() < 0.5:
                    one = rng.choice(sorted(asked))
                    (ask_together if rng.random() < 0.5 else send_only)(kept, [(one, asked[one])])
            # Few: the first answer that needs names reads them for all others. Before them comes what needs none, in half of the rounds.
            order = rng.sample(sorted(asked), rng.randrange(1, 5))
            if rng.random() < 0.5:
                order = ["diagnostic", *(key for key in order if key != "diagnostic")]
            got = ask_together(kept, [(key, asked[key]) for key in order])
            other.open(uri, text)
            want = ask_together(other, sorted((key, asked[key]) for key in order))
            other.notify("textDocument/didClose", {"textDocument": {"uri": uri}})
            wrong = [key for key in order if got[key] != want[key]]
            passed += not wrong
            if wrong:
                failed += 1
                report(f"edit {count} of a large document (seed {seed}), asked in the order {order}: {wrong}\n  kept: {str(got[wrong[0]])[:500]}\n  fresh: {str(want[wrong[0]])[:500]}")
        if kept.stop() != 0 or other.stop() != 0:
            failed += 1
            report("a server did not end in order")
    return passed, failed


def run(models, edits_each, seed, report):
    rng = random.Random(seed)
    passed = failed = 0
    kept = client.Client()
    kept.start()
    reused = 0
    for model in models:
        uri = model.as_uri()
        text = original = model.read_bytes().decode()
        kept.open(uri, text)
        other = client.Client()
        other.start()
        for version in range(2, edits_each + 2):
            if rng.random() < 0.25:
                text = original
            change = harmless(rng, text) if rng.random() < 0.7 else edits.edit(rng, text)
            text = text[:change[0]] + change[2] + text[change[1]:]
            kept.change(uri, version, [{"text": text}])
            other.open(uri, text)
            got, want = answers(kept, uri, text), answers(other, uri, text)
            other.notify("textDocument/didClose", {"textDocument": {"uri": uri}})
            wrong = [k for k in got if got[k] != want[k]]
            if wrong:
                failed += 1
                report(f"edit {version} of {model.name} (seed {seed}): {change}: {wrong}\n  kept: {got[wrong[0]]}\n  fresh: {want[wrong[0]]}")
            else:
                passed += 1
        other.stop()
        reused += kept.result("bip/checks")["reused"]
        kept.notify("textDocument/didClose", {"textDocument": {"uri": uri}})
    if kept.stop() != 0 or reused < len(models):
        failed += 1
        report(f"the server did not end in order, or read everything again ({reused} pieces were not)")
    return passed, failed
