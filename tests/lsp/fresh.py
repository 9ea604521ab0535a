"""Random edits of every model: a server that has read the text many times answers as one that reads it first.

Both get each text; compared are diagnostics, outline, semantic tokens, folding ranges, inlay hints and formatting. Most edits keep the text
readable, as most of what is kept of a document is used for such texts.
"""
import random

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
