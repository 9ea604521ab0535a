#!/usr/bin/env python3
"""compiler/docs/cli.md is what `bipc --help` and each command's --help print. `cli_docs.py --update` rewrites it."""
import difflib
import os
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
DOCS = ROOT / "compiler/docs/cli.md"


PUBLISHED = """
### As the published tools are called

`bipc -p Package -I DIR -d 'Root(1)' [--gencpp-output DIR]`, so that scripts made for the published compiler go on working:

| published | here |
|---|---|
| `-f FILE` | the file itself |
| `-p a.b.C -I DIR …` | the file `a/b/C.bip` in the first folder that has it; its package must be `a.b.C` (B1062) |
| `-d 'Root(1)'` | the root; without it every parameterless compound that nobody instantiates is checked |
| no back end | checks: `bipc check` |
| `--gencpp-output DIR`, `--gencpp-output-dir DIR` | writes C++: `bipc emit -o DIR`. The folder gets its own `CMakeLists.txt` and the runtime, which is compiled if bipc's own library is not there |
| `--gencpp-no-main` | the folder makes a library with `model::image()`, without `main` |
| `--gencpp-cc-I DIR` | like `-I DIR` |
| `--gencpp-cc-extra-src FILE`, `--gencpp-cc-extra-obj FILE`, `--gencpp-ld-extra-obj FILE` | a source or an object that is copied into the folder and linked |
| `--gencpp-ld-L DIR`, `--gencpp-ld-l NAME` | the program is linked with the library NAME, which is looked for in DIR as well |
| beginnings of options | `--gencpp-no-m` is `--gencpp-no-main`: no other option begins so |
| `--Werr`, `--WError`, `-WError` | warnings count as errors: `--Werror` |
| other `--gencpp-…` options | taken, and a note says that they have no effect: headers and sources are named by `@cpp` in the package |

The options of the published engine are options of `bipc run` and of programs that `bipc build` makes: `--limit`, `--seed`, `--silent`,
`--debug`, `--interactive`, `--explore`, `--first-enabled`, `--disable-maximal-progress`, with the short names `-l -s -d -i -f -a` (`--asap`), `-v -V --execute`. With `--trace-format=bip2` the lines are the
published engine's, too. Random choices with the same seed differ from the published engine's: the generator is another one.
"""


GRAPH = "\n[graph.md](graph.md) says what is drawn, and describes DOT and JSON.\n"


def bipc():
    return os.environ.get("BIPC") or str(pathlib.Path(os.environ.get("BIPC_BUILD_DIR") or ROOT / "build") / "bipc")


def help_of(*words):
    return subprocess.run([bipc(), *words, "--help-all" if words else "--help"], capture_output=True, text=True, check=True).stdout.strip("\n")


def commands_of(help_text):
    """The commands that `bipc --help` lists."""
    return re.findall(r"^  (\w+) ", help_text[help_text.index("Subcommands:"):].split("\n\n")[0], re.M)


def page():
    top = help_of()
    commands = commands_of(top)
    text = ("# The command line\n\nGenerated from `--help` and each command's `--help-all` (`tests/meta/cli_docs.py --update`); a test compares them.\n\n"
            "Exit codes: 0 success, 1 errors in the model or at run time, 2 wrong command line, 3 a violated property or a deadlock that `verify` or\n"
            "`explore` found, 4 no verdict or a limit reached, 70 an error of bipc itself, 71 no memory or no thread, 74 not all of standard output, a trace or a record could be\n"
            "written (emitted programs: alike), or of the diagnostics of `check` or in JSON or SARIF. SIGINT (Ctrl-C), SIGTERM and SIGHUP end a run as a limit does, with exit code 128 + the signal's number. [SECURITY.md](../../SECURITY.md) says what is trusted.\n"
            "Errors and warnings are written to standard error, everything else to standard output.\n\n"
            "A model that calls C++ (`extern function`) needs a C++20 compiler: $CXX, else c++, g++ or clang++. `run` compiles the model's C++ code once.\n"
            "It is cached below `$XDG_CACHE_HOME/bipc` (else `~/.cache/bipc`; without a home nothing is cached) together with a hash of what the compiler's preprocessor makes of it, as are the JIT's machine code and the proofs of `verify`.\n"
            "A file under another name or with other contents counts as none. `verify` and `explore` execute nothing from the cache: they compile anew, and prove again what a kept proof says;\n"
            "`--cache DIR` selects another folder, `--no-cache` none. The folder is made with mode 0700, and not used if it is another user's or writable by others. It may be removed at any time; when it exceeds 256 MB (`--cache-size`), the least\n"
            "recently used entries are removed.\n\n"
            f"## bipc\n\n```text\n{top}\n```\n")
    text += PUBLISHED
    for command in commands:
        text += f"\n## bipc {command}\n\n```text\n{help_of(command)}\n```\n"
        text += GRAPH if command == "graph" else ""
    return text


def differences():
    if not pathlib.Path(bipc()).exists():
        return [f"no program at {bipc()}"]
    written = DOCS.read_text(encoding="utf-8") if DOCS.exists() else ""
    found = list(difflib.unified_diff(written.splitlines(), page().splitlines(), "cli.md", "--help", lineterm="", n=1))
    missing = [f"bipc {c} --help has no example" for c, body in re.findall(r"^## bipc ?(\w*)\n(.*?)(?=^## |\Z)", page(), re.M | re.S)
               if "Example:" not in body]
    return found + missing


if __name__ == "__main__":
    if "--update" in sys.argv:
        DOCS.write_text(page(), encoding="utf-8")
    else:
        print("\n".join(differences()))
