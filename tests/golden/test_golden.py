#!/usr/bin/env python3
"""Runs golden files: input, command and expected output in one text file each.

    tests/golden/test_golden.py [--update] [--jobs N] [FILE or FOLDER or part of a name ...]

A golden file (*.golden):
    # comment lines: what it shows
    $ bipc check --diagnostics=short $FILE      one or more commands; all run in one empty directory
    --- file name.bip                           input files; $FILE is the first one, $DIR the directory
    ...text...
    --- stdout                                  expected; a missing section means: empty
    --- stderr
    --- exit 1                                  expected exit code of the last command (missing: 0)

$MODELS is the repository's folder of models; copy what is run from there, since stories tell paths.
Several commands: their outputs follow each other; the first that ends with a signal or code 70 fails the golden.
`bipc` is the program of $BIPC or build/bipc; `certcheck` the one beside it: goldens that call it fail where it is not built. --update rewrites the expected sections; review them as code.
A name starts with fail_ exactly if the expected standard error holds an error. Needs python3 only.
"""
import argparse
import concurrent.futures
import difflib
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
SECTION = re.compile(r"^--- (file \S+|stdout|stderr|exit -?\d+)$")
ERROR = re.compile(r'error\[[BR]\d{4}\]|"severity":"error"|^bipc: (?!seed)', re.M)
TIMEOUT = 180  # seconds; a compiler of C++ beside other programs takes its time


class Golden:
    def __init__(self, path):
        self.path = path
        self.comments, self.commands, self.files = [], [], []
        self.expected = {"stdout": "", "stderr": "", "exit": 0}
        self.read(path.read_text(encoding="utf-8", errors="surrogateescape"))

    def read(self, text):
        section = None
        for line in text.splitlines(keepends=True):
            m = SECTION.match(line.rstrip("\n"))
            if m:
                section = m.group(1)
                if section.startswith("file "):
                    self.files.append([section[5:], ""])
                elif section.startswith("exit "):
                    self.expected["exit"] = int(section[5:])
            elif section is None:
                if line.startswith("$ "):
                    self.commands.append(line[2:].rstrip("\n"))
                elif line.startswith("#"):
                    self.comments.append(line.rstrip("\n"))
                elif line.strip():
                    raise ValueError(f"line before the first section is neither `# ` nor `$ `: {line!r}")
            elif section.startswith("file "):
                self.files[-1][1] += line
            elif section in ("stdout", "stderr"):
                self.expected[section] += line
            elif line.strip():
                raise ValueError(f"text after `--- {section}`: {line!r}")
        if not self.commands:
            raise ValueError("no `$ ` command")

    def write(self, actual):
        out = "".join(c + "\n" for c in self.comments) + "".join(f"$ {c}\n" for c in self.commands)
        for name, text in self.files:
            out += f"--- file {name}\n{text}" + ("" if text.endswith("\n") or not text else "\n")
        for key in ("stdout", "stderr"):
            if actual[key]:
                out += f"--- {key}\n{actual[key]}" + ("" if actual[key].endswith("\n") else "\n")
        if actual["exit"]:
            out += f"--- exit {actual['exit']}\n"
        self.path.write_text(out, encoding="utf-8", errors="surrogateescape")

    def run(self, bipc):
        """The actual stdout, stderr and exit code; paths of the temporary directory are taken out."""
        with tempfile.TemporaryDirectory(prefix="golden-") as work:
            for name, text in self.files:
                target = pathlib.Path(work, name)
                target.parent.mkdir(parents=True, exist_ok=True)
                target.write_text(text, encoding="utf-8", errors="surrogateescape")
            bin_dir = pathlib.Path(work, ".bin")
            bin_dir.mkdir()
            (bin_dir / "bipc").symlink_to(bipc)
            (bin_dir / "certcheck").symlink_to(pathlib.Path(bipc).with_name("certcheck"))
            environment = {k: v for k, v in os.environ.items() if not k.startswith(("NO_COLOR", "LC_", "LANG", "BIPC_"))}
            environment.update(PATH=f"{bin_dir}:{environment.get('PATH', '/usr/bin:/bin')}", DIR=".", LC_ALL="C.UTF-8")
            environment.update(FILE=self.files[0][0] if self.files else "", MODELS=str(ROOT / "models"))
            # The user's own cache is none of ours. One for all goldens: compiled C++ is used again.
            environment.update(XDG_CACHE_HOME=str(pathlib.Path(bipc).parent / "tests-cache"))
            # What other goldens proved would change what is told of a proof.
            if any("verify" in command for command in self.commands):
                environment.update(XDG_CACHE_HOME=str(pathlib.Path(work, ".cache")))
            actual = {"stdout": "", "stderr": "", "exit": 0}
            for command in self.commands:
                done = subprocess.run(["bash", "-c", command], cwd=work, env=environment, stdin=subprocess.DEVNULL,
                                      capture_output=True, timeout=TIMEOUT)
                actual["stdout"] += done.stdout.decode("utf-8", "surrogateescape").replace(work, "$DIR")
                actual["stderr"] += done.stderr.decode("utf-8", "surrogateescape").replace(work, "$DIR")
                actual["exit"] = done.returncode
                if done.returncode == 70 or done.returncode < 0 or done.returncode >= 128:
                    break
            return actual


def naming_problem(path, stderr):
    has_errors = bool(ERROR.search(stderr))
    is_fail = path.name.startswith("fail_")
    if has_errors and not is_fail:
        return "has errors: its name should start with fail_"
    if is_fail and not has_errors:
        return "has no errors: its name should not start with fail_"
    return None


def run_one(path, bipc, update):
    """None if all is well, else what is wrong."""
    try:
        golden = Golden(path)
        actual = golden.run(bipc)
    except (ValueError, OSError) as problem:
        return f"{problem}"
    except subprocess.TimeoutExpired:
        return f"no end within {TIMEOUT} s"
    if actual["exit"] == 70 or actual["exit"] < 0 or actual["exit"] >= 128:
        return f"crash (exit {actual['exit']})\n{actual['stderr'][-2000:]}"
    expected = golden.expected
    normal = {k: (v + "\n" if k != "exit" and v and not v.endswith("\n") else v) for k, v in actual.items()}
    if update:
        if normal != expected or not path.read_text(errors="surrogateescape").endswith("\n"):
            golden.write(normal)
        return naming_problem(path, normal["stderr"])
    problems = []
    for key in ("stdout", "stderr"):
        if normal[key] != expected[key]:
            problems += difflib.unified_diff(expected[key].splitlines(), normal[key].splitlines(), f"expected {key}",
                                             f"actual {key}", lineterm="", n=2)
    if normal["exit"] != expected["exit"]:
        problems.append(f"exit code {normal['exit']}, expected {expected['exit']}")
    naming = naming_problem(path, expected["stderr"])
    if naming:
        problems.append(naming)
    return "\n".join(problems).encode("utf-8", "replace").decode() or None


def chosen(words):
    everything = sorted(HERE.rglob("*.golden"))
    if not words:
        return everything
    picked = []
    for word in words:
        p = pathlib.Path(word).resolve()
        hits = [p] if p.is_file() else [g for g in everything if p in g.parents] if p.is_dir() else \
            [g for g in everything if word in str(g.relative_to(HERE))]
        if not hits:
            sys.exit(f"golden: nothing matches {word!r}")
        picked += hits
    return sorted(set(picked))


def main():
    parser = argparse.ArgumentParser(description="Runs the golden files.")
    parser.add_argument("--update", action="store_true", help="rewrite the expected sections")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--every", type=int, default=1, metavar="N", help="of N files, in the order of their names, only the first")
    parser.add_argument("--containing", metavar="REGEX", help="only files with a text that the regular expression matches")
    parser.add_argument("what", nargs="*", help="files, folders or parts of names")
    arguments = parser.parse_args()
    if arguments.every < 1:
        parser.error("--every takes a number from 1 on")
    bipc = os.environ.get("BIPC") or str(pathlib.Path(os.environ.get("BIPC_BUILD_DIR") or ROOT / "build") / "bipc")
    if not shutil.which(bipc):
        sys.exit(f"golden: no program at {bipc} (build it with tools/build, or set BIPC)")
    bipc = os.path.abspath(bipc)
    goldens = chosen(arguments.what)
    if arguments.containing:
        goldens = [g for g in goldens if re.search(arguments.containing, g.read_text(encoding="utf-8", errors="replace"))]
    goldens = goldens[::arguments.every]
    if not goldens:
        sys.exit("golden: no file is chosen")
    if not pathlib.Path(bipc).with_name("certcheck").exists() and \
            any("certcheck " in g.read_text(encoding="utf-8", errors="replace") for g in goldens):
        sys.exit(f"golden: no certcheck beside {bipc} (ninja -C BUILD certcheck)")
    failed = 0
    with concurrent.futures.ThreadPoolExecutor(max_workers=arguments.jobs) as pool:
        results = pool.map(lambda g: run_one(g, bipc, arguments.update), goldens)
        for path, problem in zip(goldens, results):
            if problem:
                failed += 1
                print(f"FAILED {path.relative_to(ROOT) if ROOT in path.parents else path}\n  " + problem.replace("\n", "\n  "), flush=True)
    print(f"golden: {len(goldens) - failed} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
