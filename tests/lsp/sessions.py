"""Scripted sessions: every request with its expected answer, the protocol's order, positions, several documents."""
import json
import pathlib
import re
import shutil
import subprocess
import tempfile

import client
import fresh

MODEL = """package m
  // What is exchanged.
  port type Value(int v)
  connector type Pass(Value a, Value b)
    define a b
    on a b down { b.v = a.v; }
  end
  // Counts.
  atom type Node(int n)
    data int x = n
    export port Value in(x), out(x)
    place S, T
    initial to S
    @SuppressWarning(modifiedvariabletransition)
    on in from S to T provided (x < n) do { x = x + 1; }
    on out from T to S
  end
  compound type Root()
    component Node a(3), b(4)
    connector Pass c(a.out, b.in)
    connector Pass d(b.out, a.in)
  end
end
"""
URI = "file:///nowhere/m.bip"
NOT_INITIALIZED, INVALID_REQUEST, NO_METHOD, BAD_PARAMS, PARSE_ERROR, FAILED = -32002, -32600, -32601, -32602, -32700, -32803


def equal(got, want):
    if got != want:
        raise AssertionError(f"{got!r}, expected {want!r}")


def at(what, skip=0, text=MODEL):
    """Line and character of the first place of `what`, `skip` further on."""
    return client.position(text, text.index(what) + skip)


def span(what, length, skip=0, text=MODEL):
    index = text.index(what) + skip
    return {"start": client.position(text, index), "end": client.position(text, index + length)}


def started(text=MODEL, uri=URI, **options):
    c = client.Client()
    c.start(**options)
    c.open(uri, text)
    return c


def ask(c, method, position, uri=URI, **more):
    return c.at(method, uri, position["line"], position["character"], **more)


def test_initialize_and_exit():
    c = client.Client()
    equal(c.error("textDocument/hover", {}), NOT_INITIALIZED)
    answer = c.start()
    equal(answer["capabilities"]["positionEncoding"], "utf-16")
    equal(answer["capabilities"]["textDocumentSync"]["change"], 2)
    equal(c.error("initialize", {"capabilities": {}}), INVALID_REQUEST)
    equal(c.error("workspace/nothing", {}), NO_METHOD)
    equal(c.error("textDocument/nothing", {}), NO_METHOD)
    c.notify("$/nothing", {})
    c.notify("nothing", None)
    equal(c.result("shutdown"), None)
    equal(c.error("textDocument/hover", {}), INVALID_REQUEST)
    c.notify("exit", None)
    equal(c.process.wait(client.TIMEOUT), 0)


def test_exit_without_shutdown():
    c = client.Client()
    c.start()
    c.notify("exit", None)
    equal(c.process.wait(client.TIMEOUT), 1)


def test_end_of_input():
    c = client.Client()
    c.start()
    c.process.stdin.close()
    equal(c.process.wait(client.TIMEOUT), 1)


def test_diagnostics_with_versions():
    c = started()
    equal(c.diagnostics(URI, 1), [])
    c.change(URI, 2, [{"range": span("place S", 1, 6), "text": "Z"}])
    found = c.diagnostics(URI, 2)
    equal([d["code"] for d in found if d["severity"] == 1][0], "B1020")
    equal(found[0]["source"], "bipc")
    c.change(URI, 3, [{"text": MODEL}])
    equal(c.diagnostics(URI, 3), [])
    # Two changes at once: the second counts from the result of the first.
    c.change(URI, 4, [{"range": {"start": {"line": 0, "character": 0}, "end": {"line": 0, "character": 0}}, "text": "// é𝄞\n"},
                      {"range": {"start": {"line": 0, "character": 4}, "end": {"line": 0, "character": 6}}, "text": "x"}])
    equal(c.diagnostics(URI, 4), [])
    edits = c.result("textDocument/formatting", {"textDocument": {"uri": URI}, "options": {}})
    assert edits[0]["newText"].startswith("// éx\npackage m"), edits
    c.notify("textDocument/didSave", {"textDocument": {"uri": URI}})
    c.notify("textDocument/didClose", {"textDocument": {"uri": URI}})
    equal(c.error("textDocument/documentSymbol", {"textDocument": {"uri": URI}}), BAD_PARAMS)
    equal(c.stop(), 0)


def test_queued_changes_are_merged():
    c = started()
    equal(c.diagnostics(URI, 1), [])
    # What a fast typist sends while a check runs, in one piece: checked once, after the last one.
    bodies = [json.dumps({"jsonrpc": "2.0", "method": "textDocument/didChange", "params": {
        "textDocument": {"uri": URI, "version": 2 + k}, "contentChanges": [{"text": MODEL + "// " + "x" * k + "\n"}]}}).encode() for k in range(100)]
    c.raw(b"".join(b"Content-Length: %d\r\n\r\n" % len(body) + body for body in bodies))
    equal(c.diagnostics(URI, 101), [])
    assert c.checked < 60, f"{c.checked} checks of 100 changes"
    # An answer counts all changes before it.
    c.raw(b"".join(b"Content-Length: %d\r\n\r\n" % len(body) + body for body in bodies[:3]))
    edits = c.result("textDocument/formatting", {"textDocument": {"uri": URI}, "options": {}})
    assert edits == [] or edits[0]["newText"].rstrip().endswith("// xx"), edits
    equal(c.stop(), 0)


def test_definition():
    c = started()
    for use, skip, declared, length in (("a b\n", 0, "a, Value b", 1), ("b.v =", 2, "v)", 1), ("Node a", 0, "Node(int", 4), ("a.out", 2, "out(x)", 3), ("a.out", 0, "a(3)", 1),
                                        ("S to T", 0, "S, T", 1), ("x < n", 4, "n)", 1), ("Pass d", 1, "Pass(", 4), ("in from", 2, "in(x)", 2), ("x = n", 0, "x = n", 1)):
        equal(ask(c, "definition", at(use, skip)), [{"uri": URI, "range": span(declared, length)}])
    equal(ask(c, "definition", at("define")), None)
    equal(c.stop(), 0)


def test_references():
    c = started()
    found = ask(c, "references", at("T to S"), context={"includeDeclaration": False})
    equal([f["range"]["start"] for f in found], [at("to T provided", 3), at("T to S")])
    equal(len(ask(c, "references", at("T to S"), context={"includeDeclaration": True})), 3)
    equal(len(ask(c, "references", at("v)"), context={"includeDeclaration": True})), 3)
    equal(ask(c, "references", at("package"), context={"includeDeclaration": True}), None)
    equal(c.stop(), 0)


def test_hover():
    c = started()
    text = ask(c, "hover", at("Node a"))["contents"]["value"]
    equal(text, "```bip\natom type Node(int n)\n  export port Value in(x)\n  export port Value out(x)\n```\natom type\n\n---\nCounts.")
    text = ask(c, "hover", at("a.out", 2))["contents"]["value"]
    equal(text, "```bip\nexport port Value out(x)\nport type Value(int v)\n```\nport of atom type `Node`")
    text = ask(c, "hover", at("x + 1"))["contents"]["value"]
    equal(text, "```bip\ndata int x = n\n```\ndata of atom type `Node`")
    text = ask(c, "hover", at("Value a"))["contents"]["value"]
    equal(text, "```bip\nport type Value(int v)\n```\nport type\n\n---\nWhat is exchanged.")
    text = ask(c, "hover", at("b.in"))["contents"]["value"]
    assert text.startswith("```bip\ncomponent Node b\natom type Node(int n)\n  export port"), text
    equal(ask(c, "hover", at("atom type")), None)
    equal(c.stop(), 0)


def test_document_symbols():
    c = started()
    outline = c.result("textDocument/documentSymbol", {"textDocument": {"uri": URI}})

    def names(list_):
        return [(s["name"], names(s["children"])) if "children" in s else s["name"] for s in list_]
    equal(names(outline), [("m", ["Value", "Pass", ("Node", ["x", "in", "out", "S", "T"]), ("Root", ["a", "b", "c", "d"])])])
    equal(outline[0]["children"][2]["selectionRange"], span("Node(int", 4))
    equal(c.stop(), 0)


def test_rename():
    c = started()
    equal(ask(c, "prepareRename", at("x + 1")), {"range": span("x + 1", 1), "placeholder": "x"})
    equal(ask(c, "prepareRename", at("define")), None)
    changes = ask(c, "rename", at("x + 1"), newName="count")["changes"][URI]
    equal(len(changes), 6)
    equal({e["newText"] for e in changes}, {"count"})

    def code(position, name):
        return c.error("textDocument/rename", {"textDocument": {"uri": URI}, "position": position, "newName": name})
    equal(code(at("x + 1"), "in"), BAD_PARAMS)
    equal(code(at("x + 1"), "1x"), BAD_PARAMS)
    equal(code(at("x + 1"), ""), BAD_PARAMS)
    equal(code(at("x + 1"), "n"), FAILED)
    equal(code(at("m\n"), "other"), FAILED)
    equal(code(at("define"), "other"), FAILED)
    equal(c.error("textDocument/rename", {"textDocument": {"uri": URI}, "position": at("x + 1")}), BAD_PARAMS)
    equal(c.stop(), 0)


def labels(c, text, marker="|"):
    index = text.index(marker)
    text = text.replace(marker, "", 1)
    c.open(URI, text)
    answer = ask(c, "completion", client.position(text, index))
    return [i["label"] for i in answer["items"]]


def test_completion():
    c = started()
    equal(labels(c, MODEL.replace("b.in)", "b.|)")), ["in", "out"])
    equal(labels(c, MODEL.replace("= a.v;", "= a.|;")), ["v"])
    equal(labels(c, MODEL.replace("from T to S", "from |T to S")), ["S", "T"])
    equal(labels(c, MODEL.replace("component Node a", "component |Node a")), ["Node", "Root"])
    equal(labels(c, MODEL.replace("connector Pass d", "connector |Pass d")), ["Pass"])
    equal(labels(c, MODEL.replace("data int x", "data |int x")), ["int", "bool", "float", "string"])
    equal(labels(c, MODEL.replace("port Value in", "port |Value in")), ["Value"])
    equal(labels(c, MODEL.replace("on out", "on |out")), ["n", "in", "out"])
    for name in ("x", "n", "in", "if"):
        assert name in labels(c, MODEL.replace("{ x = x + 1; }", "{ | }")), name
    for name in ("component", "connector", "for", "priority"):
        assert name in labels(c, MODEL.replace("connector Pass d", "|\n connector Pass d")), name
    for name in ("place", "initial to", "on", "internal"):
        assert name in labels(c, MODEL.replace("on out", "|\n    on out")), name
    equal(labels(c, MODEL.replace("// Counts.", "// Counts|.")), [])
    assert "package" in labels(c, "|")
    # While the file cannot be read the names of its last state serve.
    c.open(URI, MODEL)
    c.change(URI, 2, [{"text": "from "}])
    ask(c, "completion", {"line": 0, "character": 5})
    equal(c.stop(), 0)


def test_completion_of_packages():
    """`use` and a part of a name: the packages of the folders and of the standard library, but for the file's own."""
    with tempfile.TemporaryDirectory() as folder:
        base = pathlib.Path(folder)
        for name in ("lib/ports", "lib/deep/more", "top"):
            (base / name).parent.mkdir(parents=True, exist_ok=True)
            (base / f"{name}.bip").write_text(f"package {name.replace('/', '.')}\nend\n")
        other = base / "elsewhere"
        (other / "wide").mkdir(parents=True)
        (other / "wide/net.bip").write_text("package wide.net\nend\n")
        uri = f"file://{base}/top.bip"

        def offered(line, begin="package top\n"):
            c = client.Client()
            c.start(initializationOptions={"packageFolders": [str(other)]})
            text = begin + line + "\nend\n"
            c.open(uri, text.replace("|", ""))
            found = c.result("textDocument/completion", {**document(uri), "position": client.position(text, text.index("|"))})["items"]
            equal(c.stop(), 0)
            return [i["label"] for i in found]

        # Below the file's folder `elsewhere` is a part of a name, too.
        equal(offered("  use |"), ["elsewhere.wide.net", "genom.codels", "genom.locks", "genom.ports", "genom.posters", "genom.rules", "genom.services", "genom.tasks", "genom.timers", "lib.deep.more", "lib.ports",
                                   "std.arbiters", "std.buffers", "std.chance", "std.ports", "std.sync", "wide.net"])
        equal(offered("  use std.|"), ["arbiters", "buffers", "chance", "ports", "sync"])
        equal(offered("  use std.po|"), ["arbiters", "buffers", "chance", "ports", "sync"])
        equal(offered("  use lib.|"), ["deep.more", "ports"])
        equal(offered("  use nowhere.|"), [])


PORTS = """package ports
  port type Signal()
  port type Value(int v)
  atom type Node()
    data int x
    export data int y
    export port Signal go()
    export port Value out(x)
    place S
    initial to S
    on go from S to S
    on out from S to S
  end
  atom type Lamp()
    export port Signal on_off()
    place S
    initial to S
    on on_off from S to S
  end
  connector type Mixed(Signal s, Value v)
    define s v
  end
  connector type Up(Value v)
    data int w
    export port Value all(w)
    define v
  end
  compound type Root()
    component Node a()
    component Node many[3]()
    component Lamp lamp()
    connector Up relay(a.out)
    connector Mixed k(a.go, a.out)
  end
end
"""


def test_completion_of_connector_arguments():
    """Only ports whose type the connector takes there; of arrays the name, as an index has to be written."""
    c = started(PORTS)
    text = lambda arguments: PORTS.replace("k(a.go, a.out)", f"k({arguments})")
    equal(labels(c, text("|a.go, a.out")), ["a.go", "many", "lamp.on_off"])
    equal(labels(c, text("a.go, |")), ["a.out", "many", "relay.all"])
    equal(labels(c, text("a.|")), ["go"])
    equal(labels(c, text("many[1 + 1].go, many[2].|")), ["out"])
    # None fits: what there is.
    equal(labels(c, text("a.go, lamp.|")), ["on_off"])
    # A type that is not known takes any.
    equal(labels(c, text("a.|").replace("Mixed k", "Unknown k")), ["go", "out"])
    equal(c.stop(), 0)


def test_explain_pages():
    """A client that shows pages gets the address of each code's page, and an action; others get neither."""
    text = MODEL.replace("a.out", "a.oot")
    line = text[:text.index("a.oot")].count("\n")
    ends = {"start": {"line": line, "character": 0}, "end": {"line": line, "character": 99}}
    for explains in (True, False):
        c = client.Client()
        c.start(initializationOptions={"explain": explains})
        c.open(URI, text)
        found = [d for d in c.diagnostics(URI) if d["severity"] == 1]
        equal(len(found), 1)
        code = found[0]["code"]
        equal(found[0].get("codeDescription"), {"href": f"bip-explain:/{code}.md"} if explains else None)
        actions = c.result("textDocument/codeAction", {**document(), "range": ends, "context": {"diagnostics": []}})
        equal([a["command"] for a in actions if "command" in a], [{"title": f"explain {code}", "command": "bip.explain", "arguments": [code]}] if explains else [])
        equal(c.stop(), 0)


def test_extension_is_activated():
    """The extension with VS Code's interface replaced (activate.js): its commands are those of package.json and of the lenses, and it shows pages of codes."""
    if shutil.which("node") is None:
        print("lsp: no node, so the extension was not activated")
        return
    output = subprocess.run(["node", pathlib.Path(__file__).parent / "activate.js", client.BIPC, "B2004", "nonsense"], capture_output=True, text=True, timeout=client.TIMEOUT, check=True).stdout
    shown = json.loads(output)
    listed = {row["command"] for row in json.loads((client.ROOT / "tools/vscode/package.json").read_text())["contributes"]["commands"]}
    lenses = {lens["command"]["command"] for lens in started(LENSES).result("textDocument/codeLens", document())}
    equal(set(shown["commands"]), listed | lenses | {"bip.explain"})
    equal((shown["told"], shown["scheme"]), ({"packageFolders": [], "explain": True}, "bip-explain"))
    equal([(page["command"], page["scheme"]) for page in shown["pages"]], [("markdown.showPreview", "bip-explain")] * 2)
    page = subprocess.run([client.BIPC, "explain", "B2004"], capture_output=True, text=True, check=True).stdout
    equal([p["text"] for p in shown["pages"]], [page, "`nonsense` is no code of bipc."])


def test_formatting():
    c = started(MODEL.replace("    place S, T", "place S,T"))
    edit, = c.result("textDocument/formatting", {"textDocument": {"uri": URI}, "options": {"tabSize": 2, "insertSpaces": True}})
    assert "    place S, T\n" in edit["newText"]
    c.open(URI, edit["newText"], 2)
    equal(c.result("textDocument/formatting", {"textDocument": {"uri": URI}, "options": {}}), [])
    c.open(URI, "package p atom end", 3)
    equal(c.result("textDocument/formatting", {"textDocument": {"uri": URI}, "options": {}}), [])
    equal(c.stop(), 0)


def test_semantic_tokens():
    c = started("package é\nend", encodings=("utf-16",))
    c.open(URI, "package p\n  port type /* é𝄞 */ T()\n  const data int k = 1\nend\n", 2)
    tokens = c.result("textDocument/semanticTokens/full", {"textDocument": {"uri": URI}})["data"]
    equal(tokens, [0, 8, 1, 0, 1, 1, 22, 1, 1, 1, 1, 17, 1, 6, 3])
    equal(c.stop(), 0)


def test_utf8_positions():
    c = started("package p\n  port type /* é𝄞 */ T()\nend\n", encodings=("utf-8", "utf-16"))
    tokens = c.result("textDocument/semanticTokens/full", {"textDocument": {"uri": URI}})["data"]
    equal(tokens, [0, 8, 1, 0, 1, 1, 25, 1, 1, 1])
    equal(c.stop(), 0)


def test_code_action():
    text = MODEL.replace("a.out", "a.oot")
    c = started(text)
    line = text[:text.index("a.oot")].count("\n")
    whole = {"start": {"line": line, "character": 0}, "end": {"line": line, "character": 99}}
    actions = c.result("textDocument/codeAction", {"textDocument": {"uri": URI}, "range": whole, "context": {"diagnostics": []}})
    assert any(a["edit"]["changes"][URI][0]["newText"] == "out" for a in actions), actions
    equal(c.stop(), 0)


def test_bad_parameters():
    c = started()
    for params in (None, [], {}, {"textDocument": 3}, {"textDocument": {"uri": 3}}, {"textDocument": {"uri": "file:///other"}}, {"textDocument": {"uri": URI}},
                   {"textDocument": {"uri": URI}, "position": {"line": -1, "character": 0}}, {"textDocument": {"uri": URI}, "position": {"line": 0, "character": -5}},
                   {"textDocument": {"uri": URI}, "position": {"line": 1 << 40, "character": 0}}, {"textDocument": {"uri": URI}, "position": {"line": 999999, "character": 0}},
                   {"textDocument": {"uri": URI}, "position": {"line": 1.5, "character": 0}}, {"textDocument": {"uri": URI}, "position": "here"}):
        for method in ("hover", "definition", "references", "completion", "rename", "prepareRename"):
            equal(c.error("textDocument/" + method, params), BAD_PARAMS)
    # Past the end of a line is its end.
    equal(ask(c, "hover", {"line": 0, "character": 2000000000}) is not None, True)
    c.change(URI, 2, [{"range": {"start": {"line": -1, "character": 0}, "end": {"line": 0, "character": 0}}, "text": "x"}])
    c.change(URI, 2, [{"range": {"start": {"line": 2, "character": 0}, "end": {"line": 1, "character": 0}}, "text": "x"}])
    c.change(URI, 2, [{"rangeLength": 2}])
    c.change(URI, 2, None)
    c.notify("textDocument/didOpen", {"textDocument": {"uri": URI}})
    c.notify("textDocument/didClose", {})
    equal(len(ask(c, "references", at("T to S"), context={"includeDeclaration": True})), 3)
    equal(c.stop(), 0)


def test_packages_across_documents():
    with tempfile.TemporaryDirectory() as folder:
        base = pathlib.Path(folder)
        (base / "lib").mkdir()
        (base / "lib/ports.bip").write_text("package lib.ports\n  port type P(int v)\nend\n")
        user = "package top\n  use lib.ports\n  atom type A()\n    data int x = 0\n    export port P p(x)\n    place S\n    initial to S\n    on p from S to S\n  end\nend\n"
        (base / "top.bip").write_text(user)
        top, lib = (f"file://{base}/{n}" for n in ("top.bip", "lib/ports.bip"))
        c = started(user, uri=top)
        equal([d for d in c.diagnostics(top) if d["severity"] == 1], [])
        equal(ask(c, "definition", at("P p", 0, user), top), [{"uri": lib, "range": {"start": {"line": 1, "character": 12}, "end": {"line": 1, "character": 13}}}])
        equal(c.error("textDocument/rename", {"textDocument": {"uri": top}, "position": at("P p", 0, user), "newName": "Q"}), FAILED)
        # Open, but not saved: the user sees the new text.
        c.open(lib, "package lib.ports\n  port type Q(int v)\nend\n")
        equal([d["code"] for d in c.diagnostics(top) if d["severity"] == 1][:1], ["B1006"])
        c.change(lib, 2, [{"text": "package lib.ports\n  port type P(int v)\nend\n"}])
        equal([d for d in c.diagnostics(top) if d["severity"] == 1], [])
        changes = ask(c, "rename", at("P p", 0, user), top, newName="Q")["changes"]
        equal(sorted(changes), sorted([top, lib]))
        # An error in a package that is not open is shown there.
        c.notify("textDocument/didClose", {"textDocument": {"uri": lib}})
        (base / "lib/ports.bip").write_text("package lib.ports\n  port type P(int\nend\n")
        c.notify("textDocument/didSave", {"textDocument": {"uri": top}})
        found = []
        while not found:
            found = c.diagnostics(lib)
        equal(found[0]["severity"], 1)
        equal(c.stop(), 0)


# -- What stands beside the text --

LENSES = MODEL.replace("  compound type Root()", "  // verify: never a@T && b@T\n  // an ordinary comment\n  compound type Root()")


def document(uri=URI):
    return {"textDocument": {"uri": uri}}


def test_code_lenses():
    c = started(LENSES)
    lenses = c.result("textDocument/codeLens", document())
    line = client.position(LENSES, LENSES.index("compound type Root"))["line"]
    of_root = [lens for lens in lenses if lens["range"]["start"]["line"] == line]
    equal([lens["command"]["title"] for lens in of_root], ["run", "verify", "explore", "debug", "view"])
    equal({tuple(lens["command"]["arguments"]) for lens in of_root}, {(URI, "Root()")})
    others = [lens for lens in lenses if lens not in of_root]
    equal([(lens["command"]["command"], lens["command"]["arguments"]) for lens in others], [("bip.verifyLine", [URI, "", ["--property", "never a@T && b@T"]])])
    equal(others[0]["range"]["start"]["line"], line - 2)
    # What takes arguments is not run by its name alone.
    c.change(URI, 2, [{"text": LENSES.replace("type Root()", "type Root(int n)")}])
    equal(len(c.result("textDocument/codeLens", document())), 1)
    # A line as models have it: the verdict that is expected, and options as a shell splits them.
    c.change(URI, 3, [{"text": LENSES.replace("verify: never a@T && b@T", """verify: violated --root 'Two(1, 2)' --property "never a@T" --fair=weak""")}])
    last = c.result("textDocument/codeLens", document())[-1]
    equal(last["command"]["arguments"], [URI, "violated", ["--root", "Two(1, 2)", "--property", "never a@T", "--fair=weak"]])
    c.change(URI, 4, [{"text": LENSES.replace("verify: never a@T && b@T", "verify: free")}])
    equal(c.result("textDocument/codeLens", document())[-1]["command"]["arguments"], [URI, "free", []])


def test_extension_shows_verdicts():
    """The extension's own part, with VS Code's interface replaced (extension.js); what npm brings is not needed."""
    if shutil.which("node") is None:
        print("lsp: no node, so the extension's verdicts were not tried")
        return
    with tempfile.TemporaryDirectory() as folder:
        model = pathlib.Path(folder) / "m.bip"
        text = LENSES.replace("// verify: never a@T && b@T", "// verify: deadlock\n  // verify: free\n  // verify: never a@NOWHERE\n  // verify: holds --property 'never a@T && b@S && a.x > 9'")
        model.write_text(text)
        uri = f"file://{model}"
        c = started(text, uri)
        lenses = [lens for lens in c.result("textDocument/codeLens", document(uri)) if lens["command"]["command"].startswith("bip.verify")]
        equal(len(lenses), 5)
        output = subprocess.run(["node", pathlib.Path(__file__).parent / "extension.js", client.BIPC, model, json.dumps(lenses)], capture_output=True, text=True, timeout=client.TIMEOUT, check=True).stdout
        shown = json.loads(output)
        by_label = {row[1]: (row[0], *row[2:]) for row in shown["results"] if len(row) > 1}
        equal(by_label["deadlock"], ("passed",))
        equal(by_label["free"], ("failed", "expected: free; found: deadlock"))
        equal(by_label["Root() is free of deadlocks"][0], "failed")
        equal(by_label["--property never a@NOWHERE"][0], "errored")
        equal(by_label["holds --property never a@T && b@S && a.x > 9"], ("passed",))
        assert ["warning", "BIP: models are verified in trusted workspaces only."] in shown["results"], shown
        equal(sorted(shown["shown"]), ["$(error) deadlock", "$(error) deadlock", "$(pass) deadlock", "$(pass) holds", "$(warning) failed"])
        equal((shown["refreshed"], shown["left"]), (1, 0))


def test_colours():
    """Each expression of the editor's grammars compiles, and words of the rules' language have a colour."""
    folder = client.ROOT / "tools/vscode"
    listed = {row["path"] for row in json.loads((folder / "package.json").read_text())["contributes"]["grammars"]}
    equal(listed, {f"./syntaxes/{path.name}" for path in (folder / "syntaxes").iterdir()})

    def walk(node):
        if isinstance(node, dict):
            for key, value in node.items():
                if key in ("match", "begin", "end"):
                    yield re.compile(value)
                yield from walk(value)
        elif isinstance(node, list):
            for child in node:
                yield from walk(child)

    coloured = {}
    for path in sorted((folder / "syntaxes").iterdir()):
        coloured[path.stem.split(".")[0]] = list(walk(json.loads(path.read_text())))
    words = re.findall(r'is_word\("([a-z]+)"|word\("([a-z]+)"|"([a-z]+)"', "".join(p.read_text() for p in (client.ROOT / "compiler/rules").glob("parse*.cpp")))
    for word in {w for row in words for w in row if w} - {"s"}:
        assert any(e.search(f" {word} ") or e.search(f"{word} name :") or e.search(f"{word} name;") for e in coloured["bip-rules"]), word


def test_folding_ranges():
    c = started(LENSES)
    ranges = c.result("textDocument/foldingRange", document())
    line = lambda what: client.position(LENSES, LENSES.index(what))["line"]
    folded = {(r["startLine"], r["endLine"]) for r in ranges if "kind" not in r}
    assert (line("compound type Root"), line("connector Pass d")) in folded, folded
    assert (line("connector type Pass"), line("on a b down")) in folded, folded
    equal([r for r in ranges if r.get("kind") == "comment"], [{"startLine": line("// verify"), "endLine": line("// an ordinary"), "kind": "comment"}])


def test_document_highlight():
    c = started()
    found = ask(c, "documentHighlight", at("int x", 4))
    equal(sorted((h["range"]["start"]["line"], h["kind"]) for h in found)[0], (at("int x")["line"], 3))
    assert len(found) >= 4 and {h["kind"] for h in found} == {2, 3}, found
    equal(ask(c, "documentHighlight", at("initial to")), None)


def test_selection_range():
    c = started()
    (here,) = c.result("textDocument/selectionRange", {**document(), "positions": [at("a(3)")]})
    ranges = []
    while here:
        ranges.append(here["range"])
        here = here.get("parent")
    equal(ranges[0], span("a(3)", 1))
    assert len(ranges) >= 3, ranges
    as_pair = lambda r: ((r["start"]["line"], r["start"]["character"]), (r["end"]["line"], r["end"]["character"]))
    for inner, outer in zip(ranges, ranges[1:]):
        assert as_pair(outer)[0] <= as_pair(inner)[0] and as_pair(inner)[1] <= as_pair(outer)[1] and inner != outer, ranges
    equal(ranges[-1]["start"], {"line": 0, "character": 0})
    equal(c.error("textDocument/selectionRange", document()), BAD_PARAMS)
    equal(c.error("textDocument/selectionRange", {**document(), "positions": [3]}), BAD_PARAMS)


def test_workspace_symbols():
    c = started()
    other = "file:///nowhere/other.bip"
    c.open(other, "package other\n  port type Signal()\n  connector type Node2(Signal s) define s end\nend\n")
    found = c.result("workspace/symbol", {"query": "nd"})
    equal(sorted((s["name"], s["location"]["uri"]) for s in found if s["name"].startswith("Node")), [("Node", URI), ("Node2", other)])
    equal(c.result("workspace/symbol", {"query": "nothinglikethis"}), [])
    assert len(c.result("workspace/symbol", {"query": ""})) > 10
    equal(c.error("workspace/symbol", {}), BAD_PARAMS)


def test_document_links():
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        (root / "used.bip").write_text("package used\n  port type Signal()\nend\n")
        text = "package user\n  use used\n  connector type One(Signal s) define s end\nend\n"
        uri = (root / "user.bip").as_uri()
        c = started(text, uri)
        (link,) = c.result("textDocument/documentLink", document(uri))
        equal((link["target"], link["range"]), ((root / "used.bip").as_uri(), span("used", 4, text=text)))


def test_files_that_are_not_open():
    with tempfile.TemporaryDirectory() as folder:
        base = pathlib.Path(folder)
        (base / "lib").mkdir()
        (base / ".hidden").mkdir()
        lib = "package lib.ports\n  port type P(int v)\nend\n"
        user = "package {0}\n  use lib.ports\n  atom type {1}()\n    data int x\n    export port P p(x)\n    place S\n    initial to S\n    on p from S to S\n  end\nend\n"
        (base / "lib/ports.bip").write_text(lib)
        (base / "open.bip").write_text(user.format("open", "A"))
        (base / "other.bip").write_text(user.format("other", "B"))
        (base / "broken.bip").write_text("package broken\n  use lib.ports\n  atom type P(\n")
        (base / ".hidden/hidden.bip").write_text(user.format("hidden", "H"))
        uri = lambda name: (base / name).as_uri()
        c = client.Client()
        c.start(rootUri=base.as_uri())
        c.open(uri("open.bip"), user.format("open", "A"))
        place = at("P p", 0, user)
        places = ask(c, "references", place, uri("open.bip"), context={"includeDeclaration": True})
        equal(sorted(p["uri"] for p in places), sorted(uri(n) for n in ("lib/ports.bip", "open.bip", "other.bip")))
        equal([s["location"]["uri"] for s in c.result("workspace/symbol", {"query": "B"}) if s["name"] == "B"], [uri("other.bip")])
        equal([s for s in c.result("workspace/symbol", {"query": "H"}) if s["name"] == "H"], [])
        changes = ask(c, "rename", place, uri("open.bip"), newName="Value")["changes"]
        equal(sorted(changes), sorted(uri(n) for n in ("lib/ports.bip", "open.bip", "other.bip")))
        line = {"start": {"line": 4, "character": 16}, "end": {"line": 4, "character": 17}}
        equal(changes[uri("other.bip")], [{"range": line, "newText": "Value"}])
        # What the disk says now counts, and a name that is taken in a file that is not open is taken.
        (base / "other.bip").write_text(user.format("other", "C").replace("  atom", "  port type Value()\n  atom"))
        equal([s["name"] for s in c.result("workspace/symbol", {"query": "C"}) if s["name"] == "C"], ["C"])
        equal(c.error("textDocument/rename", {"textDocument": {"uri": uri("open.bip")}, "position": place, "newName": "Value"}), FAILED)
        equal(c.stop(), 0)


HINTS = """package hints
  port type P(int v)
  connector type Cast(P sender, P one, P two)
    define sender' one two
  end
  atom type A(int first, int step)
    data int x, y = 3
    data bool b
    data float f
    data string s
    export port P p(x)
    place S
    initial to S
    on p from S to S
  end
  compound type Root()
    component A a(1, (2 + 3)), sender(4, 5)
    component A many[3](7, 8)
    connector Cast c(sender.p, a.p, many[0].p)
    connector Cast d(sender.p,
                     many[1].p, many[2].p)
  end
end
"""


def test_inlay_hints():
    c = started(HINTS)
    whole = {"start": {"line": 0, "character": 0}, "end": {"line": 99, "character": 0}}
    hints = lambda where=whole: c.result("textDocument/inlayHint", {**document(), "range": where})
    found = [(h["position"]["line"], h["position"]["character"], h["label"]) for h in hints()]
    lines = HINTS.split("\n")
    column = lambda line, text: lines[line].index(text)
    values = [(6, column(6, ","), "= 0"), (7, len(lines[7]), "= false"), (8, len(lines[8]), "= 0.0"), (9, len(lines[9]), '= ""')]
    of_a = [(16, column(16, "1,"), "first:"), (16, column(16, "(2"), "step:"), (16, column(16, "4,"), "first:"), (16, column(16, "5)"), "step:")]
    of_many = [(17, column(17, "7"), "first:"), (17, column(17, "8"), "step:")]
    of_c = [(18, column(18, "sender"), "sender:"), (18, column(18, "a.p"), "one:"), (18, column(18, "many"), "two:"), (18, len(lines[18]), "4 interactions")]
    of_d = [(19, column(19, "sender"), "sender:"), (20, column(20, "many[1]"), "one:"), (20, column(20, "many[2]"), "two:"), (20, len(lines[20]), "4 interactions")]
    equal(sorted(found), sorted(values + of_a + of_many + of_c + of_d))
    equal({h["label"] for h in hints({"start": {"line": 6, "character": 0}, "end": {"line": 7, "character": 0}})}, {"= 0"})
    equal(c.error("textDocument/inlayHint", document()), BAD_PARAMS)
    # An argument that has the parameter's name needs none.
    c.change(URI, 2, [{"text": HINTS.replace("P sender, P one", "P p, P one").replace("define sender'", "define p'")}])
    assert not any(h["label"] in ("p:", "sender:") for h in hints()), hints()


def test_signature_help():
    c = started()
    help_at = lambda what, skip: ask(c, "signatureHelp", at(what, skip))
    found = help_at("a(3)", 2)
    equal((found["signatures"][0]["label"], found["activeParameter"]), ("Node(int n)", 0))
    equal(found["signatures"][0]["documentation"], "Counts.")
    second = help_at("b.out, a.in", 7)
    equal((second["signatures"][0]["label"], second["activeParameter"]), ("Pass(Value a, Value b)", 1))
    equal(help_at("initial to", 3), None)
    equal(help_at("// Counts", 5), None)


def test_pull_diagnostics():
    c = started()
    equal(c.result("textDocument/diagnostic", document()), {"kind": "full", "items": []})
    c.change(URI, 2, [{"text": MODEL.replace("x + 1", "y + 1")}])
    pulled = c.result("textDocument/diagnostic", document())["items"]
    equal(pulled, c.diagnostics(URI, 2))
    assert len(pulled) == 1 and pulled[0]["severity"] == 1, pulled


def test_semantic_tokens_of_a_range():
    c = started()
    decoded = lambda data: [tuple(data[k:k + 5]) for k in range(0, len(data), 5)]
    whole, line, column = [], 0, 0
    for down, right, length, kind, modifiers in decoded(c.result("textDocument/semanticTokens/full", document())["data"]):
        line, column = line + down, (0 if down else column) + right
        whole.append((line, column, length, kind, modifiers))
    begin, end = at("atom type Node"), at("compound type Root")
    part, line, column = [], 0, 0
    for down, right, length, kind, modifiers in decoded(c.result("textDocument/semanticTokens/range", {**document(), "range": {"start": begin, "end": end}})["data"]):
        line, column = line + down, (0 if down else column) + right
        part.append((line, column, length, kind, modifiers))
    equal(part, [t for t in whole if begin["line"] <= t[0] < end["line"]])
    assert 5 < len(part) < len(whole)
    equal(c.error("textDocument/semanticTokens/range", document()), BAD_PARAMS)


def test_outline_of_a_large_file_is_linear():
    """Twice the text is not four times the work: what the server does for 8,000 atom types is measured beside 4,000."""
    took = []
    for count in (2000, 8000):
        text = "package m\n  port type Signal()\n" + "".join(f"  atom type A{k}()\n    export port Signal p()\n    place S\n    initial to S\n    on p from S to S\n  end\n" for k in range(count)) + "end\n"
        c = started(text)
        c.diagnostics(URI)
        best = float("inf")
        for _ in range(4):
            begin = c.processor_seconds()
            answer = c.result("textDocument/documentSymbol", document())
            best = min(best, c.processor_seconds() - begin)
        took.append(best)
        equal(len(answer[0]["children"]), count + 1)
    # Quadratic would be 16. The processor's time of the server: other processes are not in it, their caches are.
    assert took[1] < 10 * took[0] + 0.2, took


def test_no_request_reads_the_document_again():
    """The work of a request does not contain a check of the document: it is the number of checks that counts, not time."""
    c = started()
    checks = lambda: c.result("bip/checks")["checks"]
    c.diagnostics(URI)
    equal(checks(), 1)
    where = at("Node")
    ends = {"start": {"line": 0, "character": 0}, "end": {"line": 10, "character": 0}}
    for name in ("documentSymbol", "formatting", "semanticTokens/full", "codeLens", "foldingRange", "documentLink", "diagnostic"):
        c.result("textDocument/" + name, {**document(), "options": {"tabSize": 2, "insertSpaces": True}})
    for name in ("codeAction", "semanticTokens/range", "inlayHint"):
        c.result("textDocument/" + name, {**document(), "range": ends, "context": {"diagnostics": []}})
    for name in ("definition", "references", "hover", "completion", "prepareRename", "documentHighlight", "signatureHelp"):
        ask(c, name, where)
    c.result("textDocument/rename", {**document(), "position": where, "newName": "Other"})
    c.result("workspace/symbol", {"query": ""})
    equal(checks(), 1)
    # One more for an edit, however many answers follow it.
    c.change(URI, 2, [{"range": {"start": {"line": 0, "character": 0}, "end": {"line": 0, "character": 0}}, "text": "\n"}])
    for _ in range(3):
        ask(c, "hover", where)
        c.result("textDocument/formatting", {**document(), "options": {}})
    equal(checks(), 2)


def test_an_edit_parses_one_declaration():
    """It is the number of pieces that counts, not time: of 40 types only the one that is edited is parsed again."""
    text = "package m\n  port type Signal()\n" + "".join(f"  atom type A{k}()\n    export port Signal p()\n    place S\n    initial to S\n    on p from S to S\n  end\n" for k in range(40)) + "end\n"
    c = started(text)
    work = lambda: c.result("bip/checks")
    c.diagnostics(URI)
    equal(work(), {"checks": 1, "parsed": 42, "reused": 0, "partly": 0, "whole": 0})
    line = 2 + 6 * 30 + 1
    where = {"line": line, "character": len("    export port Signal p")}
    c.change(URI, 2, [{"range": {"start": where, "end": where}, "text": "q"}])
    # `on p` has no port any more; the places below it are those of the new text.
    found = c.diagnostics(URI, 2)
    equal({d["range"]["start"]["line"] for d in found}, {line + 3})
    equal(work(), {"checks": 2, "parsed": 43, "reused": 41, "partly": 0, "whole": 0})
    # Formatting takes the tree of the last text.
    c.result("textDocument/formatting", {**document(), "options": {}})
    equal(work(), {"checks": 2, "parsed": 43, "reused": 83, "partly": 0, "whole": 0})
    # What cannot be read is read as a whole, and afterwards the rest is still known.
    c.change(URI, 3, [{"range": {"start": where, "end": where}, "text": "("}])
    equal(len(c.diagnostics(URI, 3)), 1)
    c.change(URI, 4, [{"text": text}])
    equal(c.diagnostics(URI, 4), [])
    equal(work(), {"checks": 4, "parsed": 45, "reused": 124, "partly": 1, "whole": 0})


def test_names_behind_pulled_diagnostics_of_a_large_file():
    """A check of a large document leaves its names unread; the first answer that needs them is of the new text all the same."""
    text = "package m\n  port type Signal()\n" + "".join(f"  atom type A{k}()\n    data int x\n    export port Signal p()\n    place S\n    initial to S\n    on p from S to S\n  end\n" for k in range(4000)) + "end\n"
    c = started(text)
    c.diagnostics(URI)
    begin = {"line": 0, "character": 0}
    line = 2 + 7 * 3000 + 5
    for version, name in enumerate(("references", "rename", "prepareRename", "definition", "hover", "documentHighlight", "documentSymbol", "semanticTokens/full", "foldingRange", "selectionRange", "inlayHint", "formatting", "symbol"), 2):
        # Each edit moves everything down by a line.
        line += 1
        where = {"line": line, "character": len("    on p from ")}
        near = {"range": {"start": {"line": line - 9, "character": 0}, "end": {"line": line, "character": 0}}}
        asked = {**document(), "position": where, "positions": [where], "newName": "Other", "context": {"includeDeclaration": True}, **near, "options": {}, "query": "A3000"}
        method = ("workspace/" if name == "symbol" else "textDocument/") + name
        c.change(URI, version, [{"range": {"start": begin, "end": begin}, "text": "\n"}])
        answers = fresh.ask_together(c, [("pulled", ("textDocument/diagnostic", document())), ("behind", (method, asked))])
        equal(answers["pulled"]["result"], {"kind": "full", "items": []})
        alone = c.call(method, asked)
        equal(answers["behind"]["result"], alone["result"])
        assert alone["result"], name
    equal(c.stop(), 0)


def test_completion_of_a_large_file_does_not_wait_for_its_check():
    """A key and the completion after it: the answer comes before the diagnostics of the new text, with its words; so do answers about names, and every other request waits for them."""
    text = "package m\n  port type Signal()\n" + "".join(f"  atom type A{k}()\n    export port Signal p()\n    place S\n    initial to S\n    on p from S to S\n  end\n" for k in range(4000)) + "end\n"
    c = started(text)
    c.diagnostics(URI)
    line = 2 + 6 * 3000 + 3
    begin = {"line": line, "character": len("    initial to ")}

    def frame(message):
        body = json.dumps({"jsonrpc": "2.0", **message}).encode()
        return b"Content-Length: %d\r\n\r\n" % len(body) + body

    def edit(version, then):
        """Both in one write, so that the server has the request when it has read the change."""
        c.next_id += 1
        c.raw(frame({"method": "textDocument/didChange", "params": {"textDocument": {"uri": URI, "version": version}, "contentChanges": [{"range": {"start": begin, "end": begin}, "text": "x"}]}})
              + frame({"id": c.next_id, "method": "textDocument/" + then, "params": {**document(), "position": {"line": line, "character": begin["character"] + 1}}}))
        order = []
        while len(order) < 2:
            message = c.receive()
            if message.get("id") == c.next_id:
                order.append("answer")
                answer = message["result"]
            elif message.get("method") == "textDocument/publishDiagnostics" and message["params"].get("version") == version:
                order.append("diagnostics")
        return order, answer

    order, answer = edit(2, "completion")
    equal(order, ["answer", "diagnostics"])
    equal([i["label"] for i in answer["items"]], ["S"])
    # Names of the new text need no check.
    order, answer = edit(3, "documentHighlight")
    equal(order, ["answer", "diagnostics"])
    equal(answer, None)
    order, _ = edit(4, "prepareRename")
    equal(order, ["answer", "diagnostics"])
    order, _ = edit(4, "diagnostic")
    equal(order[0], "diagnostics")
    # So it is of a text with an error of syntax; where the whole is read the check comes first.
    c.change(URI, 5, [{"range": {"start": begin, "end": begin}, "text": "("}])
    order, answer = edit(6, "hover")
    equal(order, ["answer", "diagnostics"])
    c.change(URI, 7, [{"range": {"start": begin, "end": begin}, "text": "/*"}])
    order, answer = edit(8, "hover")
    equal(order, ["diagnostics", "answer"])
    # Back to the first text: the names are read, then its check finds nothing, and nothing is left of the one before.
    c.change(URI, 9, [{"text": text}])
    where = {"line": line, "character": len("    initial to ")}
    equal([h["range"]["start"]["line"] for h in ask(c, "documentHighlight", where)], [line - 1, line, line + 1, line + 1])
    equal(c.diagnostics(URI, 9), [])
    checks = c.result("bip/checks")["checks"]
    c.result("textDocument/documentSymbol", document())
    equal(c.result("textDocument/diagnostic", document())["items"], [])
    equal(c.result("bip/checks")["checks"], checks)
    equal(c.stop(), 0)
