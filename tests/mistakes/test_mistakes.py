#!/usr/bin/env python3
"""Deliberate mistakes of newcomers, each with the answer that a person has read.

    tests/mistakes/test_mistakes.py [--update] [part of a table's name or of a title ...]

A table (*.mistakes) begins with `model NAME`, a sound file of models/, and holds one entry per mistake:

    === what a person wrote
    - text of the model, which occurs once         any number of these pairs; lines that follow each other are one text
    + what stands there instead
    $ check                                        a command of bipc (default: check); $FILE is the changed model
    --- file NAME                                  more input files
    --- answer                                     what bipc answers, standard output and error
    --- edit ...                                   what is left when the first edit of each error is applied

The last line says `mends it` (nothing is reported any more), `leaves CODE ...` or `none` (no error has an edit). Edits
are those of `--diagnostics=json`, which editors offer as quick fixes; edits of `--root` and `--property` change the
command. The models themselves are sound. --update writes answers and edits: read the difference as code.
Needs python3 only.
"""
import argparse
import concurrent.futures
import difflib
import json
import os
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
BUILD = pathlib.Path(os.environ.get("BIPC_BUILD_DIR") or ROOT / "build").resolve()
BIPC = os.path.abspath(os.environ.get("BIPC") or BUILD / "bipc")
AT_LEAST = 150  # entries of all tables


class Mistake:
    def __init__(self, table, model, title):
        self.table, self.model, self.title = table, model, title
        self.edits, self.command, self.files = [], "check $FILE", {}
        self.written = []  # the lines up to the answer, as they are in the table
        self.answer, self.edit = "", ""

    def text(self):
        """The model with the mistake."""
        text = (HERE / "models" / self.model).read_text(encoding="utf-8")
        for old, new in self.edits:
            if text.count(old) != 1:
                raise ValueError(f"`{old}` occurs {text.count(old)} times in {self.model}")
            text = text.replace(old, new)
        return text


def read(path):
    """The head of a table, and its mistakes."""
    head, model, mistakes, part, sign = [], None, [], None, ""
    for line in path.read_text(encoding="utf-8").split("\n"):
        if line.startswith("=== "):
            mistakes.append(Mistake(path, model, line[4:]))
            part, sign = "entry", ""
            mistakes[-1].written.append(line)
            continue
        if not mistakes:
            head.append(line)
            if line.startswith("model "):
                model = line[6:]
            continue
        last = mistakes[-1]
        if line == "--- answer":
            part = "answer"
        elif line.startswith("--- edit ") and part == "answer":
            last.edit, part = line[9:], "over"
        elif line.startswith("--- file "):
            part = line[9:]
            last.files[part] = ""
            last.written.append(line)
        elif part == "answer":
            last.answer += line + "\n"
        elif part == "entry":
            last.written.append(line)
            read_entry(last, line, sign)
            sign = line[:1]
        elif part != "over":
            last.files[part] += line + "\n"
            last.written.append(line)
        elif line:
            raise ValueError(f"{path.name}: text after the entry `{last.title}`: {line}")
    return head, mistakes


def read_entry(mistake, line, before):
    if line[:2] in ("- ", "-"):
        if before == "-":
            mistake.edits[-1][0] += "\n" + line[2:]
        else:
            mistake.edits.append([line[2:], ""])
    elif line[:2] in ("+ ", "+"):
        mistake.edits[-1][1] += ("\n" if before == "+" else "") + line[2:]
    elif line.startswith("$ "):
        mistake.command = line[2:]
    elif line:
        raise ValueError(f"{mistake.table.name}: `{mistake.title}`: neither edit nor command: {line}")


def run(folder, mistake, arguments):
    # Where the repository is and where we are does not show in an answer.
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("NO_COLOR", "LC_", "LANG", "BIPC_"))}
    environment.update(LC_ALL="C.UTF-8", XDG_CACHE_HOME=str(pathlib.Path(folder, ".cache")))
    done = subprocess.run([BIPC, *arguments], cwd=folder, env=environment, capture_output=True, timeout=60, stdin=subprocess.DEVNULL)
    if done.returncode not in (0, 1, 2, 3, 4):
        raise ValueError(f"`{mistake.title}`: bipc ended with {done.returncode}")
    return done.returncode, (done.stdout + done.stderr).decode("utf-8", "replace").replace(str(folder), "$DIR")


def apply(edits, texts):
    """The texts with all edits, the last one first; edits that overlap an earlier one are left out."""
    edits = sorted(edits, key=lambda e: (e["range"]["file"], e["range"]["offset"], e["range"]["end_offset"]))
    chosen = []
    for edit in edits:
        if chosen and chosen[-1]["range"]["file"] == edit["range"]["file"] and chosen[-1]["range"]["end_offset"] > edit["range"]["offset"]:
            continue
        chosen.append(edit)
    for edit in reversed(chosen):
        at = edit["range"]
        text = texts[at["file"]].encode()
        texts[at["file"]] = (text[:at["offset"]] + edit["with"].encode() + text[at["end_offset"]:]).decode()
    return texts


def diagnostics(text):
    return [d for d in (json.loads(line) for line in text.splitlines() if line.startswith('{"severity"'))]


def judge(mistake):
    """Answer and edit of one mistake as they are today."""
    with tempfile.TemporaryDirectory(prefix="mistake-") as folder:
        files = {mistake.model: mistake.text(), **mistake.files}
        for name, text in files.items():
            pathlib.Path(folder, name).write_text(text, encoding="utf-8")
        arguments = [a.replace("$FILE", mistake.model) for a in shlex.split(mistake.command)]
        code, answer = run(folder, mistake, arguments)
        answer += f"exit {code}\n"
        if code == 2:
            return answer, judge_usage(folder, mistake, arguments, answer)
        # Also where the edits of the command are: its options become files of the same name.
        texts = dict(files)
        for i, argument in enumerate(arguments):
            if argument in ("--root", "--property"):
                texts[argument] = arguments[i + 1]
        found = diagnostics(run(folder, mistake, [*arguments, "--diagnostics=json"])[1])
        helps = [[h["edit"] for h in d["helps"] if "edit" in h][:1] for d in found if d["severity"] == "error"]
        if not any(helps):
            return answer, "none"
        apply([e for edits in helps for e in edits], texts)
        for name, text in texts.items():
            if name in arguments and name.startswith("--"):
                arguments[arguments.index(name) + 1] = text
            else:
                pathlib.Path(folder, name).write_text(text, encoding="utf-8")
        left = diagnostics(run(folder, mistake, [*arguments, "--diagnostics=json"])[1])
        codes = [d["code"] for d in left]
        return answer, "leaves " + " ".join(codes) if codes else "mends it"


def judge_usage(folder, mistake, arguments, answer):
    """What is left of a wrong command line after its help: another property, option or command line."""
    shown = re.search(r"^  = help: --property '(.*)'$", answer, re.M)
    if shown:
        arguments[arguments.index("--property") + 1] = shown.group(1)
    elif shown := re.search(r"^  = help: there is `(.*)`$", answer, re.M):
        wrong = re.search(r"^bipc: .*`(.*?)`", answer, re.M).group(1)
        arguments[arguments.index(wrong)] = shown.group(1)
    elif shown := re.search(r"^  = help: `bipc (.*)`$", answer, re.M):
        if "--help" in shown.group(1):
            return "none"
        arguments = shlex.split(shown.group(1))
    else:
        return "none"
    return "mends it" if run(folder, mistake, arguments)[0] in (0, 3, 4) else "leaves an error"


def main():
    parser = argparse.ArgumentParser(description="Deliberate mistakes and their answers.")
    parser.add_argument("--update", action="store_true", help="write answers and edits into the tables")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("what", nargs="*", help="parts of names of tables or of titles")
    options = parser.parse_args()
    tables = {path: read(path) for path in sorted(HERE.glob("*.mistakes"))}
    failed = passed = 0
    for path in sorted((HERE / "models").glob("*.bip")):
        done = subprocess.run([BIPC, "check", str(path)], capture_output=True, text=True)
        if done.returncode != 0 or done.stdout or done.stderr:
            failed += 1
            print(f"FAILED models/{path.name} is not sound:\n{done.stdout}{done.stderr}")
    everything = [m for _, mistakes in tables.values() for m in mistakes]
    if len(everything) < AT_LEAST and not options.update:
        failed += 1
        print(f"FAILED {len(everything)} mistakes, at least {AT_LEAST} are needed")
    chosen = [m for m in everything if not options.what or any(w in m.table.name or w in m.title for w in options.what)]
    if not chosen:
        sys.exit(f"mistakes: nothing matches {options.what}")
    with concurrent.futures.ThreadPoolExecutor(max_workers=options.jobs) as pool:
        results = list(pool.map(judge, chosen))
    for mistake, (answer, edit) in zip(chosen, results):
        if options.update:
            mistake.answer, mistake.edit = answer, edit
        elif (answer, edit) == (mistake.answer, mistake.edit):
            passed += 1
        else:
            failed += 1
            print(f"FAILED {mistake.table.name}: {mistake.title}")
            expected = f"{mistake.answer}edit {mistake.edit}\n"
            for line in difflib.unified_diff(expected.splitlines(), f"{answer}edit {edit}\n".splitlines(), "expected", "actual", lineterm="", n=2):
                print("  " + line)
    if options.update:
        for path, (head, mistakes) in tables.items():
            out = "\n".join(head).rstrip("\n") + "\n"
            for m in mistakes:
                written = "\n".join(m.written).rstrip("\n")
                out += f"\n{written}\n--- answer\n{m.answer}--- edit {m.edit}\n"
            path.write_text(out, encoding="utf-8")
        print(f"mistakes: {len(chosen)} written")
        return 1 if failed else 0
    print(f"mistakes: {passed} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
