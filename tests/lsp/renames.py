"""Every name of every model is renamed by the server; `bipc check` finds the same as before. A use that the index does not
know, or knows wrongly, leaves a name that nobody declares.
"""
import pathlib
import tempfile

import client
import edits

NEW = "renamed_by_the_test"


def apply(text, changes):
    starts = client.lines_of(text)
    spans = []
    for change in changes:
        at = [starts[change["range"][k]["line"]] + change["range"][k]["character"] for k in ("start", "end")]
        spans.append((*at, change["newText"]))
    for begin, end, new in sorted(spans, reverse=True):
        text = text[:begin] + new + text[end:]
    return text


def declarations(tokens):
    """Line and column of each declared name."""
    line = column = 0
    for i in range(0, len(tokens), 5):
        if tokens[i]:
            column = 0
        line, column = line + tokens[i], column + tokens[i + 1]
        if tokens[i + 4] & 1 and tokens[i + 3] != 0:
            yield line, column


def run(models, report):
    passed = failed = 0
    c = client.Client()
    c.start(encodings=("utf-8",))
    with tempfile.TemporaryDirectory() as folder:
        before, renamed = {}, []
        for model in models:
            text = model.read_text(encoding="ascii", errors="replace").replace("\ufffd", "?")
            base = pathlib.Path(folder) / (model.parent.name + "_" + model.stem)
            base.mkdir()
            original = base / "original.bip"
            original.write_text(text)
            before[model] = str(original)
            uri = f"file://{original}"
            c.open(uri, text)
            tokens = c.result("textDocument/semanticTokens/full", {"textDocument": {"uri": uri}})["data"]
            for line, column in declarations(tokens):
                answer = c.call("textDocument/rename", {"textDocument": {"uri": uri}, "position": {"line": line, "character": column}, "newName": NEW})
                where = f"{model.name}:{line + 1}:{column + 1}"
                if "result" not in answer:
                    failed += 1
                    report(f"rename at {where}: {answer['error']}")
                    continue
                path = base / f"renamed{len(renamed)}.bip"
                path.write_text(apply(text, answer["result"]["changes"].get(uri, [])))
                renamed.append((model, where, str(path)))
            c.notify("textDocument/didClose", {"textDocument": {"uri": uri}})
        found = edits.check_all(list(before.values()) + [path for _, _, path in renamed])

        def codes(path):
            return sorted(row["code"] for row in found[path])
        for model, where, path in renamed:
            if codes(path) == codes(before[model]):
                passed += 1
            else:
                failed += 1
                report(f"rename at {where}: {[(r['code'], r['message']) for r in found[path]][:3]}")
    if c.stop() != 0:
        failed += 1
        report("the server did not end in order")
    return passed, failed
