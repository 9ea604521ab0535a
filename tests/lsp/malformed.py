"""Thousands of broken messages: the server answers each with an error or nothing, and goes on.

Every hundred messages it is asked something sensible, in a new session if the last one was ended by the message itself.
"""
import json
import random

import client
from sessions import MODEL, URI

METHODS = ["initialize", "shutdown", "textDocument/didOpen", "textDocument/didChange", "textDocument/didClose", "textDocument/hover", "textDocument/definition", "textDocument/references",
           "textDocument/rename", "textDocument/prepareRename", "textDocument/completion", "textDocument/formatting", "textDocument/documentSymbol", "textDocument/semanticTokens/full",
           "textDocument/codeAction", "textDocument/didSave", "$/cancelRequest", "", "x", "textDocument/"]


def value(rng, depth=0):
    kind = rng.randrange(11 if depth < 4 else 8)
    if kind == 0:
        return rng.choice([-1, 0, 1, 2, 7, 2 ** 31 - 1, 2 ** 31, -2 ** 63, 2 ** 64 - 1, 1.5, 1e300])
    if kind == 1:
        return rng.choice(["", URI, "file://", "file:///%", "\u0000", "é𝄞", "a" * 500, MODEL, "package p end"])
    if kind in (2, 3, 4):
        return rng.choice([None, True, False, [], {}])
    if kind == 5:
        return {"uri": URI, "version": rng.randrange(9), "text": MODEL[:rng.randrange(len(MODEL))]}
    if kind in (6, 7):
        return {"line": rng.randrange(-1, 24), "character": rng.randrange(-1, 40)}
    if kind == 8:
        return [value(rng, depth + 1) for _ in range(rng.randrange(4))]
    keys = ["textDocument", "position", "range", "start", "end", "text", "contentChanges", "newName", "context", "includeDeclaration", "uri", "version", "line", "character"]
    return {rng.choice(keys): value(rng, depth + 1) for _ in range(rng.randrange(5))}


def message(rng):
    kind = rng.randrange(6)
    made = {"jsonrpc": "2.0", "method": rng.choice(METHODS), "params": {"textDocument": {"uri": URI}, "position": value(rng), "range": value(rng), "contentChanges": value(rng)}}
    if rng.random() < 0.6:
        made["id"] = rng.choice([1, "a", None, 1.5, [], {}, 2 ** 70])
    if kind == 0:
        made = value(rng)
    elif kind == 1:
        made["params"] = value(rng)
    elif kind == 2:
        made[rng.choice(["jsonrpc", "method", "id", "params"])] = value(rng)
    if isinstance(made, dict) and made.get("method") in ("shutdown", "exit"):
        made["method"] = "x"
    body = json.dumps(made, ensure_ascii=rng.random() < 0.5).encode("utf-8", "surrogatepass")
    if kind == 3:
        body = body[:rng.randrange(len(body) + 1)]
    elif kind == 4:
        body = bytes(rng.choice(b"\x00\xff{}[]\"\\,:0") if rng.random() < 0.05 else b for b in body)
    header = b"Content-Length: %d\r\n\r\n" % len(body)
    if kind == 5 and rng.random() < 0.5:
        header = rng.choice([b"Content-Length: x\r\n\r\n", b"Content-Length: -4\r\n\r\n", b"\r\n\r\n", b"Content-Type: a\r\n\r\n", b"Content-Length: 99999999999999999999999\r\n\r\n",
                             b"Content-Length: 1\r\nContent-Length: 2\r\n\r\n", b"\x00\xff\r\n\r\n"])
    return header + body


def run(count, seed, report):
    rng = random.Random(seed)
    passed = failed = 0
    c = client.Client()
    c.start()
    for batch in range(0, count, 100):
        c.open(URI, MODEL)
        for _ in range(100):
            c.raw(message(rng))
        # Nested a hundred thousand deep, once: recursion must not follow it.
        if batch == 0:
            body = b"[" * 100000
            c.raw(b"Content-Length: %d\r\n\r\n" % len(body) + body)
            body += b"]" * 100000
            c.raw(b"Content-Length: %d\r\n\r\n" % len(body) + body)
        # A cut-off header may take a part of what follows for its own: the line feeds end it.
        c.raw(b"\r\n\r\n")
        try:
            c.next_id = 1000 + batch
            c.open(URI, MODEL)
            got = c.at("references", URI, 14, 20, context={"includeDeclaration": True})
            if got is None or len(got) < 2:
                raise AssertionError(f"after batch {batch} (seed {seed}): {got}")
            passed += 1
        except (client.Gone, AssertionError, OSError) as e:
            failed += 1
            report(f"malformed messages, batch {batch}, seed {seed}: {e}")
            c = client.Client()
            c.start()
        c.pending.clear()
    if c.stop() != 0:
        failed += 1
        report("the server did not end in order")
    return passed, failed
