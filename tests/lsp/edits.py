"""Random edits of models: after each the server's diagnostics are those of a fresh `bipc check`.

The edits are made first and written to files, which one `bipc check --diagnostics=json` process a batch reads; the server
gets the same edits one by one, as ranges or whole texts. Compared are code, severity, message and range of each.
"""
import json
import pathlib
import random
import re
import subprocess
import tempfile

import client

TOKEN = re.compile(r"\w+|\s+|.", re.S)
BATCH = 50


def edit(rng, text):
    """(begin, end, replacement) in characters."""
    kind = rng.randrange(8)
    if not text:
        return 0, 0, "package p end"
    if kind == 0:
        at = rng.randrange(len(text) + 1)
        return at, at, rng.choice(["x", " ", "\n", "(", ")", "{", "}", ";", "'", "\"", "é", "𝄞", "/*", "//", "\r\n", "end", "@", "0", "*", "[", "<"])
    if kind == 1:
        at = rng.randrange(len(text))
        return at, min(len(text), at + rng.randrange(1, 4)), ""
    if kind == 2:
        at = rng.randrange(len(text))
        return at, at + 1, rng.choice("abxyz(){}[];,.<>=+-'\" \n")
    if kind in (3, 4):
        starts = client.lines_of(text) + [len(text)]
        line = rng.randrange(len(starts) - 1)
        begin, end = starts[line], starts[line + 1]
        if kind == 3:
            return begin, end, ""
        return begin, begin, text[begin:end]
    tokens = [m.span() for m in TOKEN.finditer(text) if not m.group().isspace()] or [(0, 0)]
    begin, end = rng.choice(tokens)
    if kind == 5:
        return begin, end, ""
    other = rng.choice(tokens)
    return begin, end, text[slice(*other)]


def expected(rows, name, path, text):
    """The rows of `bipc check` for one file, in the protocol's form."""
    data = text.encode()
    out = []
    for row in rows:
        at = row["range"]
        places = [{"line": 0, "character": 0}] * 2
        if at is not None and at["file"] == path:
            places = [client.position(text, len(data[:at[k]].decode("utf-8", "ignore"))) for k in ("offset", "end_offset")]
        elif at is not None:
            continue
        out.append((row["code"], 1 if row["severity"] == "error" else 2, row["message"].replace(name, "NAME"), json.dumps(places, sort_keys=True)))
    return out


def shown(diagnostics, name):
    return [(d["code"], d["severity"], d["message"].replace(name, "NAME"), json.dumps([d["range"]["start"], d["range"]["end"]], sort_keys=True)) for d in diagnostics]


def check_all(paths):
    """Rows of `bipc check` by path."""
    rows = {p: [] for p in paths}
    for i in range(0, len(paths), BATCH):
        part = paths[i:i + BATCH]
        done = subprocess.run([str(client.BIPC), "check", "--diagnostics=json", *part], stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, timeout=600)
        if done.returncode not in (0, 1):
            raise AssertionError(f"bipc check ended with {done.returncode}")
        for line in done.stderr.decode().splitlines():
            row = json.loads(line)
            # What has no place belongs to the file whose path the message names.
            where = row["range"]["file"] if row["range"] else next((p for p in part if p in row["message"]), None)
            if where in rows:
                rows[where].append(row)
    return rows


def run(models, edits_each, seed, report):
    rng = random.Random(seed)
    passed = failed = 0
    c = client.Client()
    c.start()
    with tempfile.TemporaryDirectory() as folder:
        for model in models:
            original = model.read_bytes().decode()
            text, steps = original, []
            for i in range(edits_each):
                # From time to time a new beginning: what is broken for good says little.
                if rng.random() < 0.3:
                    steps.append((None, original))
                    text = original
                else:
                    change = edit(rng, text)
                    text = text[:change[0]] + change[2] + text[change[1]:]
                    steps.append((change, text))
            base = pathlib.Path(folder) / (model.parent.name + "_" + model.stem)
            base.mkdir()
            paths = []
            for i, (_, after) in enumerate(steps):
                path = base / f"edit{i:04}.bip"
                path.write_bytes(after.encode())
                paths.append(str(path))
            fresh = check_all(paths)
            live = str(base / "live0000.bip")
            uri = "file://" + live
            c.open(uri, original)
            c.diagnostics(uri)
            before = original
            for i, (change, after) in enumerate(steps):
                if change is None:
                    changes = [{"text": after}]
                else:
                    begin, end = (client.position(before, k) for k in change[:2])
                    # Inside \r\n there is no position: such an edit is sent as a whole text.
                    split = any(before[k - 1:k + 1] == "\r\n" for k in change[:2] if k > 0)
                    changes = [{"text": after}] if split else [{"range": {"start": begin, "end": end}, "text": change[2]}]
                c.change(uri, i + 2, changes)
                got = shown(c.diagnostics(uri, i + 2), live)
                want = expected(fresh[paths[i]], paths[i], paths[i], after)
                before = after
                if got == want:
                    passed += 1
                else:
                    failed += 1
                    report(f"edit {i} of {model.name} (seed {seed}): {change}\n  server: {got}\n  check:  {want}")
            c.notify("textDocument/didClose", {"textDocument": {"uri": uri}})
    if c.stop() != 0:
        failed += 1
        report("the server did not end in order")
    return passed, failed
