#!/usr/bin/env python3
"""bipc-runner, the part of bipc that a first build begins with, and the two steps of that build.

    tests/package/test_runner.py [part of a check's name ...]

The program: runs are those of bipc, and what it does not have it names. The build: tools/build and tools/run with a
cmake and a ninja that only write down how they were called. Last line: "N passed, N failed".
"""
import os
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BUILD = pathlib.Path(os.environ.get("BIPC_BUILD_DIR") or ROOT / "build")
BIPC = os.environ.get("BIPC") or str(BUILD / "bipc")
RUNNER = str(BUILD / "bipc-runner")
MODEL = "models/classic/philosophers.bip"
OWN = ("check", "run", "build", "emit", "fmt", "explain", "version", "completion")


def call(program, *words, **options):
    done = subprocess.run([program, *words], capture_output=True, text=True, cwd=ROOT, timeout=300, **options)
    return done.returncode, done.stdout, done.stderr


def expect(what, got, wanted):
    return [] if got == wanted else [f"{what}: {got!r} instead of {wanted!r}"]


def check_runs_are_those_of_bipc():
    problems = []
    for words in (["run", MODEL, "--seed", "4"], ["run", "models/timed/heart_pacer.bip", "--seed", "1", "--limit", "20"],
                  ["check", MODEL], ["fmt", "--check", MODEL], ["explain", "B1020"], ["run", "no_such_file.bip"]):
        problems += expect(" ".join(words), call(RUNNER, *words), call(BIPC, *words))
    return problems


def check_programs_of_build():
    """The runtime and the libraries that programs link are found beside the runner."""
    with tempfile.TemporaryDirectory() as folder:
        code, _, error = call(RUNNER, "build", MODEL, "-o", f"{folder}/program")
        if code != 0:
            return [f"build: {code}: {error}"]
        return expect("the program's run", call(f"{folder}/program", "--seed", "4"), call(BIPC, "run", MODEL, "--seed", "4"))


def check_every_command_is_there_or_named():
    """A command that bipc has is the runner's own, or says that it is missing: none is unknown to it."""
    code, text, _ = call(BIPC, "--help")
    commands = re.findall(r"^  ([a-z0-9]+)  ", text[text.index("Subcommands"):] if "Subcommands" in text else text, re.M)
    problems = [] if code == 0 and set(OWN) <= set(commands) and len(commands) > 20 else [f"commands of bipc --help: {commands}"]
    # Words without which the command line is refused first.
    needed = {"dap": [], "trace": ["stats", MODEL, MODEL], "replay": [MODEL, "--recorded", "x"], "export": [MODEL, "--format", "promela"],
              "deploy": [MODEL, "--placement", "x", "-o", "x"]}
    for command in commands:
        problems += expect(f"{command} --help", call(RUNNER, command, "--help"), call(BIPC, command, "--help"))
        if command in OWN:
            continue
        words = [command, *needed.get(command, [MODEL])]
        code, out, error = call(RUNNER, *words, stdin=subprocess.DEVNULL)
        if (code, out) != (2, "") or f"`bipc {command}` is not part of this build" not in error or "tools/build bipc" not in error:
            problems.append(f"{' '.join(words)}: {code} {out!r} {error!r}")
    return problems


def check_options_that_need_the_rest():
    problems = []
    for words, name in ((["run", MODEL, "--engine", "distributed"], "a run on several nodes"), (["check", MODEL, "--emit", "dot"], "`--emit`")):
        code, out, error = call(RUNNER, *words)
        if (code, out) != (1, "") or f"error[B5001]: {name} is not part of this build of bipc" not in error:
            problems.append(f"{' '.join(words)}: {code} {out!r} {error!r}")
    code, _, error = call(RUNNER, "check", MODEL, "--lesson", "1")
    if code != 2 or "`bipc check --lesson` is not part" not in error:
        problems.append(f"check --lesson: {code} {error!r}")
    return problems


# Stand-ins: `cmake` writes what a configuration leaves, `ninja` makes the program that it is asked for.
CMAKE = """#!/bin/bash
echo "cmake $*" >>"$CALLS"
touch "$BIPC_BUILD_DIR/build.ninja"
[[ $* != *BIPC_RUNNER_ONLY=* ]] || echo "$*" | sed 's/.*BIPC_RUNNER_ONLY=\\([A-Z]*\\).*/BIPC_RUNNER_ONLY:BOOL=\\1/' >"$BIPC_BUILD_DIR/CMakeCache.txt"
"""
NINJA = """#!/bin/bash
target=${@: -1}
echo "ninja $target" >>"$CALLS"
[[ $target != "$FAILING" ]] || exit 1
printf '#!/bin/sh\\necho "%s $*"\\n' "$target" >"$BIPC_BUILD_DIR/${target/_/-}"
chmod +x "$BIPC_BUILD_DIR/${target/_/-}"
"""


class Build:
    """A build folder of its own, and stand-ins for what takes minutes."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.calls = self.folder / "calls"
        (self.folder / "bin").mkdir()
        # dpkg-query: every package is installed.
        for name, text in (("cmake", CMAKE), ("ninja", NINJA), ("dpkg-query", "#!/bin/sh\necho 'install ok installed'\n")):
            (self.folder / "bin" / name).write_text(text)
            (self.folder / "bin" / name).chmod(0o755)
        self.bipc = self.folder / "build" / "bipc"
        self.runner = self.folder / "build" / "bipc-runner"

    def call(self, tool, *words, failing=""):
        """The exit code, what was printed, and how cmake and ninja were called."""
        self.calls.write_text("")
        code, out, error = call(str(ROOT / "tools" / tool), *words, env={
            **os.environ, "PATH": f"{self.folder}/bin:{os.environ['PATH']}", "CALLS": str(self.calls), "FAILING": failing,
            "BIPC_BUILD_DIR": str(self.folder / "build")})
        calls = [re.sub(r"^cmake .*(BIPC_RUNNER_ONLY=[A-Z]+).*", r"\1", line) for line in self.calls.read_text().splitlines()]
        return code, out, error, calls


def check_build_in_two_steps():
    with tempfile.TemporaryDirectory() as folder:
        build = Build(folder)
        code, out, error, calls = build.call("build", "bipc")
        problems = expect("the first build", (code, out, calls), (0, "", ["BIPC_RUNNER_ONLY=ON", "ninja bipc_runner", "BIPC_RUNNER_ONLY=OFF", "ninja bipc"]))
        if "can run models now" not in error:
            problems.append(f"the first build says {error!r}")
        problems += expect("build/bipc", call(str(build.bipc))[1], "bipc \n")
        problems += expect("the next build", build.call("build", "bipc"), (0, "", "", ["ninja bipc"]))
        # Not for good something else in the place of bipc.
        build.bipc.unlink()
        problems += expect("bipc is gone", build.call("build", "bipc")[3], ["ninja bipc_runner", "ninja bipc"])
        return problems + expect("build/bipc is back", call(str(build.bipc))[1], "bipc \n")


def check_run_needs_the_runner_only():
    with tempfile.TemporaryDirectory() as folder:
        build = Build(folder)
        code, out, error, calls = build.call("run", MODEL, "--seed", "4")
        problems = expect("the first run", (code, out, calls), (0, f"bipc_runner run {MODEL} --seed 4\n", ["BIPC_RUNNER_ONLY=ON", "ninja bipc_runner"]))
        if "`tools/build bipc` builds the rest" not in error:
            problems.append(f"the first run says {error!r}")
        problems += expect("the next run", build.call("run", MODEL), (0, f"bipc_runner run {MODEL}\n", "", ["ninja bipc_runner"]))
        # A folder's program may need any command.
        problems += expect("the run of a folder", build.call("run", "models/dala")[1::2], ("bipc run models/dala\n", ["BIPC_RUNNER_ONLY=OFF", "ninja bipc"]))
        return problems + expect("a run after it", build.call("run", MODEL), (0, f"bipc run {MODEL}\n", "", ["ninja bipc"]))


def check_a_failure_leaves_what_was():
    with tempfile.TemporaryDirectory() as folder:
        build = Build(folder)
        code, _, _, calls = build.call("build", "bipc", failing="bipc_runner")
        problems = expect("a runner that does not compile", (code != 0, calls[-1], build.bipc.exists()), (True, "ninja bipc_runner", False))
        code, _, _, calls = build.call("build", "bipc", failing="bipc")
        problems += expect("a rest that does not compile", (code != 0, calls[-1], call(str(build.runner))[1]), (True, "ninja bipc", "bipc_runner \n"))
        problems += expect("a run then", build.call("run", MODEL), (0, f"bipc_runner run {MODEL}\n", "", ["ninja bipc_runner"]))
        return problems + expect("once more", build.call("build", "bipc")[3], ["ninja bipc_runner", "ninja bipc"])


def main():
    checks = [(name[6:], function) for name, function in globals().items() if name.startswith("check_")]
    wanted = sys.argv[1:]
    passed = failed = 0
    for name, function in checks:
        if wanted and not any(word in name for word in wanted):
            continue
        problems = function()
        passed, failed = passed + (not problems), failed + bool(problems)
        for problem in problems:
            print(f"{name}: {problem}")
    print(f"{passed} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
