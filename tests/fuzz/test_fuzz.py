#!/usr/bin/env python3
"""tests/fuzz/test_fuzz.py [--edits N] [--seed S]: any bytes at all give a diagnostic or a system.

First the kept crashers, tests/fuzz/regressions/TARGET/*, and what libFuzzer learnt, tests/fuzz/corpus/TARGET.tar.xz, then N random edits (default 20,000, a nightly
run takes a million) of good sources, shared out among the targets. The sources: models/, the files in tests/golden, and the systems
that bipc makes of models/. BIPC_BUILD_DIR names the build (default: build).
`--corpus DIR` only writes the sources there, as seeds for libFuzzer. The last line is "fuzz: N passed, N failed".
"""
import argparse
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

import kept_inputs

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BUILD = pathlib.Path(os.environ.get("BIPC_BUILD_DIR") or ROOT / "build")
HERE = ROOT / "tests" / "fuzz"
LARGEST = 6000


def parts(path, suffix=".bip"):
    """The .bip files that a golden holds, each after its line `--- file NAME.bip`; or those with another suffix."""
    name, lines = None, []
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        if line.startswith("--- "):
            if name:
                yield name, "\n".join(lines) + "\n"
            name, lines = (line.split()[-1] if line.endswith(suffix) else None), []
        else:
            lines.append(line)
    if name:
        yield name, "\n".join(lines) + "\n"


def sources():
    texts = {path.name: path.read_text(encoding="utf-8") for path in sorted(ROOT.glob("models/**/*.bip"))}
    for folder in ("language", "paper", "diagnostics"):
        for path in sorted((ROOT / "tests" / "golden" / folder).glob("*.golden")):
            texts.update({f"{path.stem}_{name}": text for name, text in parts(path)})
    return {name.replace("/", "_"): text for name, text in texts.items() if len(text) <= LARGEST}


def descriptions():
    """.gen: Dala's, and those of the goldens."""
    texts = {path.name: path.read_text(encoding="utf-8") for path in sorted(ROOT.glob("models/**/*.gen"))}
    for path in sorted((ROOT / "tests" / "golden" / "genom").glob("*.golden")):
        texts.update({f"{path.stem}_{name}": text for name, text in parts(path, ".gen")})
    return {name.replace("/", "_"): text for name, text in texts.items() if len(text) <= LARGEST}


def older():
    """BIP1, of the goldens."""
    texts = {}
    for path in sorted((ROOT / "tests" / "golden" / "bip1").glob("*.golden")):
        texts.update({f"{path.stem}_{name}": text for name, text in parts(path) if text.startswith(("model", "//"))})
    return texts


def rules():
    """.rules, of the goldens: those are about the modules that the target has."""
    texts = {}
    for path in sorted((ROOT / "tests" / "golden" / "rules").glob("*.golden")):
        texts.update({f"{path.stem}_{name}": text for name, text in parts(path, ".rules")})
    return texts


# About the system of target_property.cpp.
PROPERTIES = ["never tank.level > 1.5", "always tank.heat <= 2.5e3 && tank@LOW", "never tank@HIGH && other@LOW || can fills", "never !can tank.drain",
              "always tank.level + other.level * 2 - 1 < 10", 'never tank.name == "tank"', "never tank.open == true && (tank.level & 3 | 4 ^ 1) != -2",
              "always ROOT.tank.level >= 0", "never ~tank.level % 3 == 10 / (other.level - 1)", "always tank.level != 0 && 7 / tank.level / -1 > 0 || tank.heat / 2 < 1.0",
              "always possibly tank.open", "possibly (tank@LOW until (possibly always other@LOW))", "tank.level % 2 == 0 leads to tank.level / 2 == 1", "never " + "!" * 150 + "tank.open", "never tank.level > .5", "never " + " || ".join(["tank@LOW"] * 100)]


def number(value):
    """LEB128."""
    made = bytearray()
    while value >= 0x80:
        made.append(value & 0x7f | 0x80)
        value >>= 7
    return bytes(made + bytes([value]))


PROTOCOL = int(re.search(r"kProtocol = (\d+)", (ROOT / "runtime/distributed/message.hpp").read_text())[1])


def frames():
    """Of the peers of target_frame.cpp, from node 2 to node 1 and back, and greetings."""
    cells = [5, 1 << 63]
    offer, net = [0, 1, 3, 1, 1, 0, 17, 2, *cells], [0, 2, 3, 0, 3, 1, 2, 17, 2, *cells]
    release, wake = [5, 0, 3, 1, 0], [6, 0]
    begin, stop = [1, 900, 0, 1, 0, 4, 0, 1, *cells], [2, 12]
    control = [3, 7, 3, 1, 1 << 40, 0, 1, 2, ord("h"), ord("i")]
    lock, taken = [4, 0, 1, 1, 0, 1, 1, 1, 0, 17, 2, *cells], [1, 900, 0, 1, 1, 0, 0, 1, *cells]
    made = {}
    for name, messages in {"offer": [offer], "net": [net], "begin": [begin], "control": [control], "release": [release], "wake": [wake], "all": [offer, net, begin, stop, control], "none": [], "again": [offer, [*offer[:2], 4, *offer[3:]], begin, [*begin[:5], 1, *begin[6:]], net, [*net[:2], 4, *net[3:]], release, release]}.items():
        made[name + ".frame"] = b"".join(map(number, [PROTOCOL, 42, 1, 3 if messages else 0, 2, 99, len(messages), *(value for message in messages for value in message)]))
    for name, messages in {"lock": [lock], "locks": [lock, taken, lock]}.items():
        made[name + ".frame"] = b"".join(map(number, [PROTOCOL, 42, 0, 3, 2, 99, len(messages), *(value for message in messages for value in message)]))
    made["welcome.frame"] = b"\0" + b"".join(map(number, [PROTOCOL, 2, 77, 2])) + b"ab" + b"".join(map(number, [1 << 63, 2, 3, 1, 0, 1, 1]))
    made["answer.frame"] = b"\0" + b"".join(map(number, [PROTOCOL, 1, 5, 1])) + b"m"
    return made


def systems():
    """.bsys of some models, as bipc prints them."""
    made = {}
    for path in sorted(ROOT.glob("models/**/*.bip")):
        done = subprocess.run([(BUILD / "bipc").resolve(), "emit", "--emit=system", path.relative_to(ROOT)], capture_output=True, cwd=ROOT)
        if done.returncode == 0 and len(done.stdout) <= 4 * LARGEST:
            made[path.stem + ".bsys"] = done.stdout.decode("utf-8", "replace")
    return made


def session(name, text):
    """One message a line: the text is opened, asked about, edited and asked about again."""
    document = {"uri": f"file:///nowhere/{name}"}
    lines = text.splitlines() or [""]
    places = [{"line": row, "character": len(lines[row]) // part} for row in (0, len(lines) // 3, len(lines) // 2, len(lines) - 1) for part in (3, 2)]
    whole = {"start": {"line": 0, "character": 0}, "end": {"line": len(lines), "character": 0}}
    opened = ("textDocument/didOpen", {"textDocument": {**document, "languageId": "bip", "version": 1, "text": text}})
    edits = [{"range": {"start": place, "end": place}, "text": words} for place, words in zip(places, (" ", "end ", "/* ", "data int x ", "'"))]
    changed = ("textDocument/didChange", {"textDocument": {**document, "version": 2}, "contentChanges": edits})
    asked = [(f"textDocument/{what}", {"textDocument": document}) for what in ("documentSymbol", "formatting", "semanticTokens/full")]
    asked += [(f"textDocument/{what}", {"textDocument": document, "position": place, "newName": "other", "context": {"includeDeclaration": True}})
              for what, place in zip(("definition", "references", "hover", "rename", "prepareRename", "completion", "definition", "hover"), places)]
    asked.append(("textDocument/codeAction", {"textDocument": document, "range": whole, "context": {"diagnostics": []}}))
    messages = [opened, *asked[::2], changed, *asked[1::2]]
    wrapped = [{"jsonrpc": "2.0", "method": method, "params": params, **({} if "did" in method else {"id": number})} for number, (method, params) in enumerate(messages)]
    return "\n".join(json.dumps(message, separators=(",", ":")) for message in wrapped) + "\n"


def sessions(texts):
    made = {f"{name}.lsp": session(name, text) for name, text in texts.items() if len(text) <= LARGEST // 3}
    # Some as a stream with headers.
    for name in sorted(made)[::8]:
        bodies = [line.encode() for line in made[name].splitlines()]
        made[name] = "".join(f"Content-Length: {len(body)}\r\n\r\n{body.decode()}" for body in bodies)
    return made


def write(folder, texts):
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in texts.items():
        (folder / name).write_bytes(text if isinstance(text, bytes) else text.encode("utf-8"))
    return sorted(str(folder / name) for name in texts)


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--edits", type=int, default=20000)
    arguments.add_argument("--seed", type=int, default=1)
    arguments.add_argument("--corpus", help="write the sources there and end")
    options = arguments.parse_args()
    if options.corpus:
        folder = pathlib.Path(options.corpus)
        write(folder / "text", sources())
        write(folder / "bsys", systems())
        write(folder / "lsp", sessions(sources()))
        write(folder / "genom", descriptions())
        write(folder / "rules", rules())
        write(folder / "property", {f"{k}.txt": text for k, text in enumerate(PROPERTIES)})
        write(folder / "frame", frames())
        write(folder / "bip1", older())
        return
    passed = failed = 0
    with tempfile.TemporaryDirectory() as work:
        work = pathlib.Path(work)
        seeds = {"text": write(work / "text", sources()), "bsys": write(work / "bsys", systems()),
                 "lsp": write(work / "lsp", sessions(sources())), "genom": write(work / "genom", descriptions()), "rules": write(work / "rules", rules()),
                 "property": write(work / "property", {f"{k}.txt": text for k, text in enumerate(PROPERTIES)}), "frame": write(work / "frame", frames()),
                 "bip1": write(work / "bip1", older())}
        seeds["format"] = seeds["text"]
        shares = {"text": 0.3, "bip1": 0.05, "bsys": 0.2, "format": 0.2, "lsp": 0.1, "genom": 0.03, "rules": 0.02, "property": 0.05, "frame": 0.05}
        for target, share in shares.items():
            kept = sorted(str(p) for p in (HERE / "regressions" / target).glob("*"))
            kept += [str(p) for p in kept_inputs.unpack(target, work / "corpus" / target)]
            jobs = [kept] if kept else []
            edits = int(options.edits * share)
            if edits and seeds[target]:
                jobs.append(["--edits", str(edits), "--seed", str(options.seed), *seeds[target]])
            for job in jobs:
                done = subprocess.run([BUILD / "bip-fuzz", target, *job], capture_output=True, text=True, cwd=work, errors="replace")
                last = done.stdout.splitlines()[-1:] or [""]
                words = last[0].replace(",", "").split()
                if done.returncode > 1 or len(words) != 6:
                    failed += 1
                    left = work / "fuzz-failed"
                    print(f"{target}: exit {done.returncode}: {done.stderr[-300:]}")
                    if left.exists():
                        print(left.read_bytes()[:2000].decode("utf-8", "replace"))
                    continue
                inputs, accepted, bad = (int(words[k]) for k in (0, 2, 4))
                if "--edits" in job:
                    print(f"{target}: {inputs} edits, {accepted} accepted")
                    if accepted == 0 and inputs >= 1000:
                        print(f"{target}: nothing behind the first check was tried")
                        bad = max(bad, 1)
                passed += inputs - bad
                failed += bad
                if bad:
                    print(f"{target}: " + "\n".join(done.stdout.splitlines()[:20]))
    print(f"fuzz: {passed} passed, {failed} failed")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
