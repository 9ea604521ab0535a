#!/usr/bin/env python3
"""Walks through the book as its readers do, and makes its site.

    tests/book/test_book.py [part of a test's name ...]

- walks: five ways through the first lesson, as a reader may go it: get the model, run it, see the deadlock in the page, repair it, prove the
  repair. Each takes at most 12 commands, the installation included, and few seconds. The installation itself is one command that is counted
  but not executed here: tools/try_package installs the package in a bare Debian, and walks there ($BIPC_MODELS: the models of the package).
- exercises: `bipc check --lesson N` accepts tests/book/solutions/lessonNN.bip (or lessonNN_K.bip, for one exercise each), refuses each exercise for
  the lesson's own model, and has a hint for every check; each lesson has two exercises. Of rules, the level that they make is judged.
- site: tools/docs makes the site without a warning, each page is known to its search, and nothing is asked of the network. Needs Sphinx
  (`tools/setup --docs`); without it the line `skipped: ...` says so. Where chromium is installed it searches in the files, without a server.
The pages' commands and outputs are executed by tests/meta/test_snippets.py. Needs a built bipc ($BIPC or build/bipc). Python's library only.
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
BUILD = pathlib.Path(os.environ.get("BIPC_BUILD_DIR") or ROOT / "build").resolve()
BIPC = os.path.abspath(os.environ.get("BIPC") or BUILD / "bipc")
BOOK = ROOT / "compiler/docs/book"

INSTALL = "sudo apt install ./bipc_*.deb"
COPY = f"cp -r {os.environ.get('BIPC_MODELS') or ROOT / 'models'}/tutorial models && cd models"
MOST_COMMANDS = 12
MOST_SECONDS = 120 * float(os.environ.get("BIPC_TEST_PATIENCE") or 1)  # of each command, so that one which hangs is reported
DEADLOCK = r"2 components wait for each other"
# An editor's work: Bob begins with the knife.
REPAIR = "sed -i 's/bob.take_first, board/bob.take_first, knife/; s/bob.take_second, knife/bob.take_second, board/' kitchen.bip"
PROOF = r"^deadlock-free: proved"

# (name, (command, what it must print or write)): a pattern of its output, or `FILE: pattern` of a file that it has written.
WALKS = [
    ("as the page goes", [
        (INSTALL, None), (COPY, None), ("bipc run kitchen.bip --seed 2", DEADLOCK), ("bipc view kitchen.bip --seed 2 -o kitchen.html", f"kitchen.html: {DEADLOCK}"),
        ("bipc verify kitchen.bip", DEADLOCK), (REPAIR, None), ("bipc verify kitchen.bip", PROOF), ("bipc check --lesson 1.1 kitchen.bip", ": solved$")]),
    ("the picture first", [
        (INSTALL, None), (COPY, None), ("bipc graph kitchen.bip -o kitchen.svg", "kitchen.svg: ann_first"), ("bipc run kitchen.bip --seed 1", DEADLOCK),
        ("bipc view kitchen.bip --seed 1 -o kitchen.html", f"kitchen.html: {DEADLOCK}"), (REPAIR, None), ("bipc run kitchen.bip --seed 1 --limit 1000 --silent", "^limit: 1000 steps"),
        ("bipc verify kitchen.bip", PROOF)]),
    ("the proof first", [
        (INSTALL, None), (COPY, None), ("bipc verify --trace dead.json kitchen.bip", DEADLOCK), ("bipc view --trace dead.json kitchen.bip -o dead.html", f"dead.html: {DEADLOCK}"),
        (REPAIR, None), ("bipc verify kitchen.bip", PROOF), ("bipc verify --property 'never ann@COOKS && bob@COOKS' kitchen.bip", "^holds")]),
    ("step by step", [
        (INSTALL, None), (COPY, None), ("printf 'l\\nc 0\\nl\\nc 1\\ny\\nb\\nl\\nq\\n' | bipc step kitchen.bip", "ann -> board -> bob -> knife -> ann"),
        ("bipc view kitchen.bip --seed 2 -o kitchen.html", f"kitchen.html: {DEADLOCK}"), (REPAIR, None), ("bipc check kitchen.bip", r"\A\Z"), ("bipc verify kitchen.bip", PROOF)]),
    ("with a mistake", [
        (INSTALL, None), (COPY, None), ("bipc run kitchen.bip --seed 2", DEADLOCK), ("bipc view kitchen.bip --seed 2 -o kitchen.html", f"kitchen.html: {DEADLOCK}"),
        ("sed -i 's/(bob.take_first, board.take)/(bob.take_first, knive.take)/' kitchen.bip", None), ("bipc check kitchen.bip", "= help: `knife` has a similar name"),
        ("sed -i 's/knive/knife/' kitchen.bip", None), ("bipc verify kitchen.bip", "deadlock"),
        ("sed -i 's/bob.take_second, knife/bob.take_second, board/' kitchen.bip", None), ("bipc verify kitchen.bip", PROOF)]),
]


def problem_of_walk(commands):
    """What went wrong, or None."""
    if len(commands) > MOST_COMMANDS:
        return f"{len(commands)} commands are more than {MOST_COMMANDS}"
    with tempfile.TemporaryDirectory(prefix="walk-") as work:
        folder = pathlib.Path(work)
        (folder / ".bin").mkdir()
        (folder / ".bin/bipc").symlink_to(BIPC)
        environment = {**os.environ, "PATH": f"{work}/.bin:{os.environ.get('PATH', '/usr/bin:/bin')}", "XDG_CACHE_HOME": f"{work}/.cache", "LC_ALL": "C.UTF-8"}
        at = folder
        for command, wanted in commands:
            if command == INSTALL:
                continue
            done = subprocess.run(["bash", "-c", command], cwd=at, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=MOST_SECONDS)
            at = folder / "models" if command == COPY else at
            text, pattern = done.stdout, wanted
            if wanted and (named := re.match(r"([\w.]+\.\w+): ", wanted)):
                text, pattern = (at / named.group(1)).read_text(encoding="utf-8"), wanted[named.end():]
            if (wanted is None and done.returncode != 0) or (wanted is not None and not re.search(pattern, text, re.M)):
                return f"$ {command}\n  exit {done.returncode}, and not {wanted!r}:\n{done.stdout[:2000]}"
    return None


def test_walks():
    for name, commands in WALKS:
        start = time.monotonic()
        problem = problem_of_walk(commands)
        seconds = time.monotonic() - start
        print(f"  {name}: {len(commands)} commands, {seconds:.1f} s")
        yield name, problem


def lesson_files():
    """(number, the model or the rules that the page shows first)"""
    for page in sorted(BOOK.glob("lesson*.md")):
        model = re.search(r"^<!-- as (\S+\.(?:bip|rules)) -->$", page.read_text(encoding="utf-8"), re.M)
        yield int(page.stem[6:8]), ROOT / model.group(1)


def judge(selection, model):
    """Of a copy, beside the C++ of the lessons."""
    with tempfile.TemporaryDirectory(prefix="exercise-") as work:
        (pathlib.Path(work) / "ext-cpp").symlink_to(ROOT / "models/tutorial/ext-cpp")
        copy = pathlib.Path(work) / "solution.bip"
        if model.suffix == ".rules":
            subprocess.run([BIPC, "rules", "--prove", str(model), "-o", str(copy)], check=True, timeout=300)
        else:
            copy.write_text(model.read_text(encoding="utf-8"), encoding="utf-8")
        done = subprocess.run([BIPC, "check", "--lesson", selection, str(copy)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=300)
    return done.returncode, done.stdout


def test_exercises():
    for number, model in lesson_files():
        text = BOOK / f"exercises/lesson{number:02}.lesson"
        exercises = re.split(r"^exercise \d+: ", text.read_text(encoding="utf-8"), flags=re.M)[1:] if text.exists() else []
        yield f"{number}: two", None if len(exercises) == 2 else f"{text} has {len(exercises)} exercises"
        for at, exercise in enumerate(exercises, 1):
            checks = re.findall(r"^(?:holds|violated|prints) .*\n(.*)", exercise, re.M)
            yield f"{number}.{at}: hints", None if checks and all(line.startswith("  ") for line in checks) else "a check has no hint"
            code, output = judge(f"{number}.{at}", model)
            yield f"{number}.{at}: not solved by the lesson's model", None if code == 3 and "= hint: " in output else f"exit {code}\n{output}"
        solutions = sorted((HERE / "solutions").glob(f"lesson{number:02}*"))
        solved = 0
        for solution in solutions:
            code, output = judge(f"{number}.{solution.stem[9:]}" if solution.stem[8:] else str(number), solution)
            solved += output.count(": solved\n")
            yield f"{solution.name}: solved", None if code == 0 else f"exit {code}\n{output}"
        yield f"{number}: both solved", None if solved == 2 else f"{solved} are solved"


def has_sphinx():
    try:
        program = subprocess.run(["bash", "-c", "command -v sphinx-build"], capture_output=True, text=True).stdout.strip()
        python = pathlib.Path(program).read_text(encoding="utf-8").splitlines()[0].removeprefix("#!").split() if program else []
        return bool(python) and subprocess.run([*python, "-c", "import myst_parser"], capture_output=True).returncode == 0
    except (OSError, UnicodeDecodeError):
        return False


def problem_of_search(site, word, page):
    """None if the browser, given the site's files, finds the page."""
    with tempfile.TemporaryDirectory(prefix="browser-") as home:
        options = ["--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={home}", "--virtual-time-budget=10000", "--dump-dom"]
        done = subprocess.run(["chromium", *options, f"file://{site}/search.html?q={word}"], capture_output=True, text=True, timeout=120)
    return None if f'<a href="{page}' in done.stdout else f"a search for `{word}` does not find {page}\n{done.stderr[-500:]}"


def test_site():
    if not has_sphinx():
        print("skipped: the book's site: Sphinx or MyST is not installed (tools/setup --docs)")
        return
    with tempfile.TemporaryDirectory(prefix="site-") as work:
        done = subprocess.run([str(ROOT / "tools/docs"), work], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=300)
        yield "site", None if done.returncode == 0 else done.stdout
        if done.returncode != 0:
            return
        site = pathlib.Path(work)
        index = (site / "searchindex.js").read_text(encoding="utf-8")
        for page in sorted(BOOK.glob("*.md")):
            name = f"compiler/docs/book/{page.stem}"
            html = site / f"{name}.html"
            problem = None if html.exists() and f'"{name}"' in index else "is not in the site, or its search does not know it"
            asks = re.findall(r'(?:src|href)="(?:https?:)?//[^"]*\.(?:js|css|svg|png|woff2?)"', html.read_text(encoding="utf-8")) if html.exists() else []
            yield f"site: {page.name}", problem or (f"asks the network for {asks}" if asks else None)
        if shutil.which("chromium"):
            yield "site: search", problem_of_search(site, "rendezvous", "compiler/docs/book/lesson01_rendezvous.html")
        else:
            print("skipped: a search in the book's site: chromium is not installed")


def main():
    tests = [(name[5:], test) for name, test in globals().items() if name.startswith("test_")]
    passed = failed = 0
    for name, test in tests:
        if sys.argv[1:] and not any(word in name for word in sys.argv[1:]):
            continue
        for case, problem in test():
            passed, failed = passed + (not problem), failed + bool(problem)
            if problem:
                print(f"FAILED {name}: {case}: " + problem.replace("\n", "\n  "))
    print(f"book: {passed} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
