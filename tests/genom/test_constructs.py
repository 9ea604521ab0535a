#!/usr/bin/env python3
"""Constructs of descriptions: what genom3 says of each (constructs.txt), and what bipc says.

    tests/genom/test_constructs.py [--table] [part of a title ...]

An accepted description is translated and its BIP checked, without a warning of ours about our own output. Where bipc
says otherwise than genom3, `--table` marks the row. Python's library only.
The last line is "constructs: N passed, N failed".
"""
import os
import pathlib
import re
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
BUILD = pathlib.Path(os.environ.get("BIPC_BUILD_DIR") or HERE.parent.parent / "build").resolve()
BIPC = os.path.abspath(os.environ.get("BIPC") or BUILD / "bipc")
SOURCES = ("manual", "corpus", "report", "memory")


def read_rows():
    rows = []
    for block in re.split(r"^=== ", (HERE / "constructs.txt").read_text(encoding="utf-8"), flags=re.MULTILINE)[1:]:
        title, genom3, source, ours, text = block.split("\n", 4)
        row = {"title": title, "genom3": genom3.removeprefix("genom3: "), "from": source.removeprefix("known from: "), "ours": ours.removeprefix("bipc: ")}
        parts = re.split(r"^--- (\S+)\n", text, flags=re.MULTILINE)
        row["files"] = {"c.gen": parts[0], **dict(zip(parts[1::2], parts[2::2]))}
        assert row["from"] in SOURCES and re.match(r"accepted$|refused, \S", row["genom3"]), row
        assert re.fullmatch(r"accepted|(refused|warns) B\d{4}", row["ours"]), row
        rows.append(row)
    assert len({r["title"] for r in rows}) == len(rows), "two rows have one title"
    return rows


def run(folder, *arguments):
    return subprocess.run([BIPC, *arguments], cwd=folder, capture_output=True, text=True, timeout=120, check=False)


def verdict(row, folder):
    """What bipc says in the words of the table, and its messages."""
    for name, text in row["files"].items():
        (folder / name).write_text(text, encoding="utf-8")
    done = run(folder, "genom", "c.gen", "-o", "c.bip")
    codes = re.findall(r"^(error|warning)\[(B\d+)\]", done.stderr, flags=re.MULTILINE)
    if done.returncode != 0:
        return f"refused {next((code for kind, code in codes if kind == 'error'), '?')}", done.stderr
    checked = run(folder, "check", "c.bip")
    if checked.returncode != 0 or checked.stderr:
        return "wrong BIP", checked.stdout + checked.stderr
    return (f"warns {codes[0][1]}" if codes else "accepted"), done.stderr


def main():
    shows = "--table" in sys.argv[1:]
    wanted = [a for a in sys.argv[1:] if a != "--table"]
    passed = failed = 0
    for row in read_rows():
        if wanted and not any(w in row["title"] for w in wanted):
            continue
        with tempfile.TemporaryDirectory(prefix="constructs-") as folder:
            said, messages = verdict(row, pathlib.Path(folder))
        passed += said == row["ours"]
        failed += said != row["ours"]
        if said != row["ours"]:
            print(f"{row['title']}: the table has `{row['ours']}`, bipc says `{said}`\n{messages}")
        if shows:
            differs = (said.startswith("refused")) != row["genom3"].startswith("refused")
            print(f"{'!' if differs else ' '} {row['title']:62} {row['genom3'][:44]:44} {row['from']:7} {said}")
    print(f"constructs: {passed} passed, {failed} failed")
    return 1 if failed or not passed else 0


if __name__ == "__main__":
    sys.exit(main())
