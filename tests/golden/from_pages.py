#!/usr/bin/env python3
"""Writes a golden for each explain page whose code is in no golden yet: the page's wrong example, checked.

    tests/golden/from_pages.py && tests/golden/test_golden.py --update explain/

Errors become explain/fail_<code>_<slug>.golden, warnings explain/<code>_<slug>.golden. Existing files stay.
Read the result as code: the wrong example should give one error, and read well.
"""
import pathlib
import re

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
KIND = re.compile(r'^BIP_DIAG\((B\d+), (\w+), "([^"]+)"', re.M)
WRONG = re.compile(r"(?:<!-- run: ?(.*?) ?-->\n)?```(bip|genom) wrong\n(.*?)```\n", re.S)


def main():
    covered = "\n".join(g.read_text(encoding="utf-8", errors="replace") for g in HERE.rglob("*.golden"))
    folder = HERE / "explain"
    folder.mkdir(exist_ok=True)
    for code, severity, slug in KIND.findall((ROOT / "compiler/diag/kinds.def").read_text(encoding="utf-8")):
        page = ROOT / f"compiler/diag/explain/{code}.md"
        found = WRONG.search(page.read_text(encoding="utf-8")) if page.exists() else None
        if f"[{code}]" in covered or not found:
            continue
        name = f"{'fail_' if severity == 'Error' else ''}{code}_{slug.replace('-', '_')}.golden"
        title = page.read_text(encoding="utf-8").splitlines()[0].removeprefix("# ")
        arguments = f" {found.group(1)}" if found.group(1) else ""
        command, file = ("genom -o wrong.bip", "wrong.gen") if found.group(2) == "genom" else ("check", "wrong.bip")
        (folder / name).write_text(f"# {title}\n$ bipc {command}{arguments} $FILE\n--- file {file}\n{found.group(3)}", encoding="utf-8")
        print(name)


if __name__ == "__main__":
    main()
