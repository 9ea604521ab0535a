#!/usr/bin/env python3
"""Executes what the documents show.

    tests/meta/test_snippets.py [--update-pictures] [--every N] [part of a file's name ...]

- ```console and ```sh fences with `$ command` lines: each command runs, what stands below it is the expected output
  (standard output and error); a line `...` stands for any lines. `bipc` is the built program. One directory a document,
  in which the repository's folders appear.
- ```bip fences: `bipc check` must accept them (`bip fail`: must report an error; `bip fragment`: not a whole file,
  skipped). `<!-- file: name.bip -->` in the line before a fence also writes it to that file for later commands,
  whatever its language. `<!-- as models/x.bip -->`: the fence is that file without the comment at its head; later commands find the file as x.bip.
- `<!-- picture: bipc graph x.bip -->` in the line before an image: the command writes that picture, byte for byte; `--update-pictures` writes the image. So does one of
  `tools/node_pictures`.
- explain pages: the wrong example must give the page's code, the right one must not give it and must have no error.
  a plain fence is as a right one. ```genom fences by `bipc genom`, ```rules by `bipc rules --prove`, B codes by `bipc check`, R codes by `bipc run` (`<!-- run: arguments -->` in the line before adds some), V codes only
  have to compile.
Commands that build or install (tools/build, tools/test, apt-get, git, cmake, cd) are not run. Python's library only.
"""
import concurrent.futures
import os
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "tests"))
import certificates  # noqa: E402
from sample import take_every  # noqa: E402
BUILD = pathlib.Path(os.environ.get("BIPC_BUILD_DIR") or ROOT / "build").resolve()
BIPC = os.path.abspath(os.environ.get("BIPC") or BUILD / "bipc")
CERTCHECK = BUILD / "certcheck"  # not built without Z3
VERIFIES = re.compile(r"""^bipc verify ((?:'[^']*'|[^|;&'])*)""")
NOT_RUN = re.compile(r"^(tools/(build|test|setup)|\.ci/|apt|sudo|git|cmake|ninja|cd|export|dot|tests/)\b")
FENCE = re.compile(r"^( *)```(\w+)?[ ]*(.*)$")
NOTE = re.compile(r"^\s*<!-- (file:|run:|as) ?(.*?) ?-->\s*$")
PICTURE = re.compile(r"^<!-- picture: ((?:bipc|tools/node_pictures) .*?) -->\n!\[[^\]]*\]\(([^)]+)\)", re.M)
HEAD = re.compile(r"\A(?://.*\n)+\n?")
TIMEOUT = 120
UPDATES_PICTURES = "--update-pictures" in sys.argv


def documents():
    files = [ROOT / "README.md", *sorted((ROOT / "compiler/docs").rglob("*.md"))]
    for folder in ("grammar", "models", "stdlib", "runtime", "tests"):
        files.append(ROOT / folder / "README.md")
    files.append(ROOT / "models/dala/README.md")
    return [f for f in files if f.exists()]


def fences(path):
    """(line, language, rest of the info line, text, note or None)"""
    found, note, open_at = [], None, None
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        m = FENCE.match(line)
        if open_at is None:
            if m:
                open_at, body = (number, m.group(2) or "", m.group(3).strip(), len(m.group(1))), []
            elif line.strip():
                n = NOTE.match(line)
                note = (n.group(1).rstrip(":"), n.group(2)) if n else None
        elif m and not m.group(2):
            found.append((*open_at[:3], "".join(b + "\n" for b in body), note))
            open_at = note = None
        else:
            body.append(line[open_at[3]:] if line[:open_at[3]].strip() == "" else line)
    return found


def execute(command, work):
    environment = {k: v for k, v in os.environ.items() if k != "NO_COLOR"}
    # What other documents proved would change what is told of a proof.
    if "verify" in command:
        environment["XDG_CACHE_HOME"] = f"{work}/.cache"
    environment.update(PATH=f"{work}/.bin:{environment.get('PATH', '/usr/bin:/bin')}", LC_ALL="C.UTF-8")
    done = subprocess.run(["bash", "-c", command], cwd=work, env=environment, stdin=subprocess.DEVNULL,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=TIMEOUT)
    return done.returncode, done.stdout.decode("utf-8", "replace").replace(str(work), ".")


def bipc(work, command, name, text, arguments=()):
    (pathlib.Path(work) / name).write_text(text, encoding="utf-8")
    return execute(" ".join(["bipc", command, *(shlex.quote(a) for a in arguments), shlex.quote(name)]), work)


def agrees(expected, actual):
    """`...` lines of `expected` stand for any lines."""
    if "..." not in [l.strip() for l in expected]:
        return expected == actual
    at = 0
    parts, current = [], []
    for line in expected:
        if line.strip() == "...":
            parts.append(current)
            current = []
        else:
            current.append(line)
    parts.append(current)
    if actual[:len(parts[0])] != parts[0]:
        return False
    at = len(parts[0])
    for part in parts[1:-1]:
        while actual[at:at + len(part)] != part:
            at += 1
            if at > len(actual):
                return False
        at += len(part)
    last = parts[-1]
    return not last or (len(actual) - len(last) >= at and actual[-len(last):] == last)


def without_certificate(command):
    """The arguments, for the test's own certificate; without what the shell does with the output."""
    words = shlex.shlex(command, posix=True, punctuation_chars=True)
    words.whitespace_split = True
    arguments = []
    for word in words:
        if re.match(r"[();<>|&]", word):
            break
        arguments.append(word)
    if arguments and arguments[-1] == "2" and "2>" in command:
        arguments.pop()
    at = arguments.index("--certificate") if "--certificate" in arguments else len(arguments)
    return arguments[:at] + arguments[at + 2:]


def shell_fence(text, work):
    """Problems of one fence with `$ ` lines. Of each `bipc verify` the certificate is checked, too."""
    steps, problems = [], []
    for line in text.splitlines():
        if line.startswith("$ "):
            steps.append([line[2:], []])
        elif steps and steps[-1][0].endswith("\\"):
            steps[-1][0] = steps[-1][0][:-1] + line.strip()
        elif steps:
            steps[-1][1].append(line)
    for command, expected in steps:
        if NOT_RUN.match(command):
            continue
        try:
            code, output = execute(command, work)
        except subprocess.TimeoutExpired:
            problems.append(f"$ {command}: no end within {TIMEOUT} s")
            continue
        actual = [l.rstrip() for l in output.splitlines()]
        expected = [l.rstrip() for l in expected]
        while expected and not expected[-1]:
            expected.pop()
        while actual and not actual[-1]:
            actual.pop()
        if not agrees(expected, actual):
            problems.append(f"$ {command}\nexpected:\n  " + "\n  ".join(expected) + "\nactual:\n  " + "\n  ".join(actual[:60]))
        asked = VERIFIES.match(command)
        # What is no question has no answer.
        if asked and code != 2 and CERTCHECK.exists():
            problem = certificates.problem_of_certificate(BIPC, CERTCHECK, without_certificate(asked.group(1)), work)
            problems += [f"$ {command}: {problem}"] if problem else []
    return problems


def check_document(path):
    """(checked fences, problems)"""
    checked, problems = 0, []
    with tempfile.TemporaryDirectory(prefix="snippets-") as work:
        prepare(work)
        for number, language, info, text, note in fences(path):
            where = f"{path.relative_to(ROOT)}:{number}"
            if language in ("console", "sh") and re.search(r"^\$ ", text, re.M):
                checked += 1
                problems += [f"{where}: {p}" for p in shell_fence(text, work)]
            elif note and note[0] == "as":
                checked += 1
                whole = (ROOT / note[1]).read_text(encoding="utf-8")
                if text not in (whole, HEAD.sub("", whole, count=1)):
                    problems.append(f"{where}: is not {note[1]}")
                (pathlib.Path(work) / pathlib.Path(note[1]).name).write_text(whole, encoding="utf-8")
            elif note and note[0] == "file" and language != "bip":
                (pathlib.Path(work) / note[1]).write_text(text, encoding="utf-8")
            elif language == "bip" and info != "fragment":
                checked += 1
                name = note[1] if note and note[0] == "file" else "snippet.bip"
                code, output = bipc(work, "check", name, text)
                if code not in (0, 1) or (code == 1) != (info == "fail"):
                    problems.append(f"{where}: bipc check ends with {code}\n{output}")
        for command, image in PICTURE.findall(path.read_text(encoding="utf-8")):
            checked += 1
            problems += picture_problems(path, command, image, work)
    return checked, problems


def picture_problems(path, command, image, work):
    picture = path.parent / image
    code, output = execute(f"{command} -o picture{picture.suffix}", work)
    made = pathlib.Path(work) / f"picture{picture.suffix}"
    if code != 0 or not made.exists():
        return [f"{path.relative_to(ROOT)}: {command} ends with {code}\n{output}"]
    if UPDATES_PICTURES:
        picture.write_bytes(made.read_bytes())
    if not picture.exists() or picture.read_bytes() != made.read_bytes():
        return [f"{path.relative_to(ROOT)}: {image} is not what {command} draws (--update-pictures writes it)"]
    return []


def prepare(work):
    (pathlib.Path(work) / ".bin").mkdir()
    (pathlib.Path(work) / ".bin/bipc").symlink_to(BIPC)
    for entry in ROOT.iterdir():
        if entry.is_dir() and not entry.name.startswith((".", "build")):
            (pathlib.Path(work) / entry.name).symlink_to(entry)
    (pathlib.Path(work) / "build").symlink_to(BUILD)


def check_page(path):
    code, checked, problems = path.stem, 0, []
    with tempfile.TemporaryDirectory(prefix="explain-") as work:
        prepare(work)
        kinds = set()
        for number, language, info, text, note in fences(path):
            if note and note[0] == "file":
                (pathlib.Path(work) / note[1]).write_text(text, encoding="utf-8")
                continue
            if language not in ("bip", "genom", "rules"):
                continue
            if info not in ("wrong", "right", ""):
                problems.append(f"{path.relative_to(ROOT)}:{number}: a ```{language} fence is `wrong`, `right` or plain")
                continue
            checked += 1
            kinds.update([info] if info else [])
            extra = shlex.split(note[1]) if note and note[0] == "run" else []
            if language == "genom":
                status, output = bipc(work, "genom", "example.gen", text, ["-o", "example.bip", *extra])
            elif language == "rules":
                status, output = bipc(work, "rules", "example.rules", text, ["--prove", "-o", "example.bip", *extra])
            elif code.startswith("R"):
                status, output = bipc(work, "run", "example.bip", text, ["--seed", "1", "--limit", "1000", "--silent", *extra])
            else:
                status, output = bipc(work, "check", "example.bip", text, extra)
            where = f"{path.relative_to(ROOT)}:{number}: {info} example"
            has_code = f"[{code}]" in output
            if info == "wrong" and not code.startswith("V") and not has_code:
                problems.append(f"{where} does not give {code}\n{output}")
            if (info != "wrong" or code.startswith("V")) and (has_code or status != 0):
                problems.append(f"{where} ends with {status}\n{output}")
        if kinds and kinds != {"wrong", "right"}:
            problems.append(f"{path.relative_to(ROOT)}: has a {kinds.pop()} example only")
    return checked, problems


def main():
    if not os.access(BIPC, os.X_OK):
        sys.exit(f"snippets: no program at {BIPC}")
    jobs = [(check_document, p) for p in documents()]
    jobs += [(check_page, p) for p in sorted((ROOT / "compiler/diag/explain").glob("[BRV]*.md"))]
    every, words = take_every(sys.argv[1:])
    wanted = [word for word in words if word != "--update-pictures"]
    if wanted:
        jobs = [j for j in jobs if any(w in str(j[1].relative_to(ROOT)) for w in wanted)]
    jobs = jobs[::every]
    passed = failed = 0
    with concurrent.futures.ThreadPoolExecutor(max_workers=2) as pool:
        for checked, problems in pool.map(lambda j: j[0](j[1]), jobs):
            failed += len(problems)
            passed += max(checked - len(problems), 0)
            for problem in problems:
                print("FAILED " + problem.replace("\n", "\n  "), flush=True)
    certificates.print_passed_over()
    print(f"snippets: {passed} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
