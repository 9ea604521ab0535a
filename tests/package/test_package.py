#!/usr/bin/env python3
"""What is installed works: `cmake --install` into a temporary folder, which is then moved, and used without a writable HOME.

Runs a model by JIT, builds and emits programs, uses the standard library, proves and checks a certificate, and compiles a
program against the installed headers with the shared library. Compares the completion scripts with what `--help` says, and
the C functions of the shared library with those of the last version (abidiff, where it is installed).
"""
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BUILD = pathlib.Path(os.environ.get("BIPC_BUILD_DIR") or ROOT / "build")
BIPC = os.environ.get("BIPC") or str(BUILD / "bipc")
sys.path.insert(0, str(ROOT / "tests/meta"))
import cli_docs  # noqa: E402
PHILOSOPHERS = "share/bipc/models/classic/philosophers.bip"
ABI = ROOT / "tests/package/bip_c.abi"
# Nobody can make a folder there, not even root.
ENVIRONMENT = {"PATH": os.environ["PATH"], "HOME": "/proc/nobody", "LC_ALL": "C.UTF-8"}


def run(*command, cwd=None, code=0, text=None, **variables):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, cwd=cwd, env={**ENVIRONMENT, **variables}, input=text)
    assert done.returncode == code, f"{' '.join(map(str, command))}: exit code {done.returncode}\n{done.stdout[-2000:]}{done.stderr[-2000:]}"
    return done.stdout


class Installation:
    """A moved installation, and what a run in the build tree prints."""

    def __init__(self, work):
        first = work / "first"
        for component in ("bipc", "distributed", "libs", "dev", "compiler", "compiler_dev", "python"):
            run("cmake", "--install", BUILD, "--prefix", first, "--component", component)
        self.prefix = work / "second" / "bip c"
        self.prefix.parent.mkdir()
        first.rename(self.prefix)
        self.bipc = self.prefix / "bin/bipc"
        self.work = work / "user"
        self.work.mkdir()
        self.expected = run(BIPC, "run", "--backend=interp", self.prefix / PHILOSOPHERS, "--seed", "4")


def test_libraries_come_from_known_folders(at):
    """An empty or relative folder in a run path is the current directory: a library that lies there would be loaded."""
    built = [BUILD / name for name in ("bipc", "bipc-runner", "bipc-lsp", "certcheck")] + sorted(BUILD.glob("lib*.so*"))
    installed = [path for path in at.prefix.rglob("*") if path.is_file() and path.open("rb").read(4) == b"\x7fELF"]
    assert at.bipc in installed, installed
    for path in filter(pathlib.Path.is_file, built + installed):
        for folders in re.findall(r"\((?:RPATH|RUNPATH)\).*\[(.*)\]", run("readelf", "-d", path)):
            for folder in folders.split(":"):
                assert folder.startswith(("/", "$ORIGIN")), f"{path}: looks for libraries in {folders!r}"


def test_parts_are_found_in_the_installation(at):
    facts = json.loads(run(at.bipc, "version", "--json"))
    assert facts["format"] == "bipc-version" and re.match(r"\d+\.\d+\.\d+$", facts["version"]), facts
    assert re.search(rf"project\(bipc VERSION {re.escape(facts['version'])}", (ROOT / "CMakeLists.txt").read_text()), facts
    for name, path in facts["paths"].items():
        if name == "jit" and path is None:
            assert "jit" not in facts["back_ends"], facts
            continue
        assert path is not None and pathlib.Path(path).is_relative_to(at.prefix), f"{name}: {path}"


def test_runs_by_jit_and_interpreter(at):
    assert run(at.bipc, "run", at.prefix / PHILOSOPHERS, "--seed", "4") == at.expected
    assert run(at.bipc, "run", "--backend=interp", at.prefix / PHILOSOPHERS, "--seed", "4") == at.expected


def test_standard_library(at):
    model = at.work / "uses.bip"
    model.write_text("package uses\n  use std.arbiters\n  compound type Root()\n    component Mutex mutex()\n  end\nend\n")
    assert "error" not in run(at.bipc, "check", model)


def test_build_links_the_installed_runtime(at):
    library = json.loads(run(at.bipc, "version", "--json"))["paths"]["runtime_library"]
    assert library == str(at.prefix / "lib/bipc/libbip_runtime.a"), library
    run(at.bipc, "build", "-O0", at.prefix / PHILOSOPHERS, "-o", at.work / "philosophers")
    assert run(at.work / "philosophers", "--seed", "4") == at.expected


def test_build_links_the_installed_server(at):
    run(at.bipc, "build", "--serve", "-O0", at.prefix / PHILOSOPHERS, "-o", at.work / "served")
    answers = run(at.work / "served", "--paused", text='{"do":"hello"}\n{"do":"shutdown"}\n').splitlines()
    assert [json.loads(answer)["ok"] for answer in answers] == [True, True], answers


def test_emitted_code_has_its_licence(at):
    run(at.bipc, "emit", at.prefix / PHILOSOPHERS, "-o", at.work / "emitted")
    assert (at.work / "emitted/runtime/LICENSE").read_text() == (ROOT / "LICENSE").read_text()
    assert (at.work / "emitted/runtime/core/core.hpp").exists()


def test_emitted_code_runs_with_the_shared_library(at):
    libraries = next(at.prefix.glob("lib*/**/libbip_runtime.so")).parent
    (at.work / "model.cpp").write_text(run(at.bipc, "emit", at.prefix / PHILOSOPHERS))
    run("g++", "-std=c++20", "-O0", "-I", at.prefix / "include", at.work / "model.cpp", "-L", libraries, "-lbip_runtime",
        f"-Wl,-rpath,{libraries}", "-o", at.work / "shared")
    assert run(at.work / "shared", "--seed", "4") == at.expected


def test_proof_and_its_check(at):
    model = at.prefix / "share/bipc/models/classic/philosophers_safe.bip"
    run(at.bipc, "verify", "--no-cache", model, "--root", "Table(20)", "--certificate", at.work / "table.cert")
    (at.work / "table.bsys").write_text(run(at.bipc, "check", "--emit=system", model, "--root", "Table(20)"))
    checker = at.prefix / "bin/certcheck"
    if checker.exists():
        assert run(checker, at.work / "table.bsys", at.work / "table.cert").startswith("accepted")


def test_language_server_starts(at):
    body = '{"jsonrpc":"2.0","id":1,"method":"initialize","params":{"capabilities":{}}}'
    said = run(at.prefix / "bin/bipc-lsp", text=f"Content-Length: {len(body)}\r\n\r\n{body}", code=1)
    assert "capabilities" in said, said


def test_models_inside_other_programs(at):
    build = at.work / "embedding"
    run("cmake", "-S", at.prefix / "share/bipc/models/embedding", "-B", build, f"-DCMAKE_PREFIX_PATH={at.prefix}", "-DCMAKE_BUILD_TYPE=Debug",
        "-DCMAKE_CXX_FLAGS=-fsanitize=address", "-DCMAKE_C_FLAGS=-fsanitize=address")
    run("cmake", "--build", build, "--parallel", "2")
    assert "100% tests passed" in run("ctest", "--test-dir", build)
    description = next(at.prefix.glob("lib*/**/bip-runtime.pc"))
    if shutil.which("pkg-config"):
        flags = run("pkg-config", "--cflags", "--libs", "bip-runtime", PKG_CONFIG_PATH=str(description.parent))
        assert "-lbip_runtime" in flags and "second" in flags, flags


def test_sources_inside_another_project(at):
    """FetchContent: with all of bipc, and with a bipc that is there already, where only the runtime is built."""
    project = at.work / "fetches"
    project.mkdir()
    (project / "CMakeLists.txt").write_text(f"""cmake_minimum_required(VERSION 3.25)
project(fetches LANGUAGES C CXX)
include(FetchContent)
FetchContent_Declare(bipc SOURCE_DIR {ROOT})
FetchContent_MakeAvailable(bipc)
add_library(dinner SHARED {ROOT}/models/embedding/dinner.cpp)
bip_add_model(dinner {ROOT}/models/classic/philosophers.bip)
""")

    def commands(build, *options):
        run("cmake", "-G", "Ninja", "-S", project, "-B", build, *options)
        return run("ninja", "-C", build, "-t", "commands", "dinner")

    planned = commands(project / "all")
    assert "BipParser.g4" in planned and "bipc emit --namespace" in planned, planned
    runtime = project / "runtime"
    planned = commands(runtime, f"-DBIPC_EXECUTABLE={BIPC}")
    assert f"{BIPC} emit --namespace" in planned and "BipParser.g4" not in planned and "compiler/" not in planned, planned
    # The runtime itself is built by every other test.
    run("ninja", "-C", runtime, "CMakeFiles/dinner.dir/bip_models/dinner/philosophers.cpp.o")


def test_compiler_inside_another_program(at):
    """bip::compiler of the installation finds the JIT, the standard library and its own runtime; the Python package finds all of these."""
    if not list(at.prefix.glob("lib*/**/libbip_compiler.so.0")):
        print("skipped: libbip_compiler.so was not built: there is no shared ANTLR library")
        return
    build = at.work / "compiler"
    run("cmake", "-S", at.prefix / "share/bipc/models/embedding", "-B", build, f"-DCMAKE_PREFIX_PATH={at.prefix}", "-DCMAKE_BUILD_TYPE=Debug")
    run("cmake", "--build", build, "--target", "compile_here", "compile_from_c")
    said = run(build / "compile_from_c")
    assert "model.bip:3:13: B" in said and "lamp.shine" in said and "violated" in said, said
    said = run(build / "compile_here", at.prefix / PHILOSOPHERS)
    assert "deadlock" in said, said
    module = list(at.prefix.glob("lib/python3/dist-packages/bipc/_bipc*.so"))
    if not module:
        print("skipped: the Python package is not installed: it was not built (pybind11-dev, python3-dev)")
        return
    libraries = next(at.prefix.glob("lib*/**/libbip_compiler.so.0")).parent
    program = "import bipc, sys; m = bipc.load(sys.argv[1], 'Table(4)', backend=sys.argv[2]); print(m.start(seed=4).trace(3)[0].interaction)"
    jit = "jit" in json.loads(run(at.bipc, "version", "--json"))["back_ends"]
    for backend in ("interp", *(["jit"] if jit else [])):
        said = run("/usr/bin/python3", "-c", program, at.prefix / PHILOSOPHERS, backend, PYTHONPATH=str(module[0].parent.parent), LD_LIBRARY_PATH=str(libraries))
        assert said.startswith("ROOT."), said
    uses = "import bipc; bipc.check('package uses\\n  use std.arbiters\\n  compound type Root()\\n    component Mutex mutex()\\n  end\\nend\\n')"
    run("/usr/bin/python3", "-c", uses, PYTHONPATH=str(module[0].parent.parent), LD_LIBRARY_PATH=str(libraries))


def commands_and_options():
    """Command -> the long options of its --help-all."""
    top = run(BIPC, "--help")
    commands = cli_docs.commands_of(top)
    options = {c: set(re.findall(r"^  (?:-\w,? *)?(?:--\w[\w-]*,)*(--\w[\w-]*)", run(BIPC, c, "--help-all"), re.M)) for c in commands}
    assert "run" in options and "--seed" in options["run"] and len(options) > 12, options
    return options


def proposed_by_bash(script, *words):
    """What bash proposes for the last word."""
    listed = " ".join(f"'{word}'" for word in words)
    text = run("bash", "-c", f"source '{script}'; COMP_WORDS=({listed}); COMP_CWORD={len(words) - 1}; _bipc; printf '%s\\n' \"${{COMPREPLY[@]}}\"")
    return set(text.split())


def test_completions_know_what_help_says(at):
    folder = at.prefix / "share"
    scripts = {"bash": folder / "bash-completion/completions/bipc", "zsh": folder / "zsh/vendor-completions/_bipc",
               "fish": folder / "fish/vendor_completions.d/bipc.fish"}
    options = commands_and_options()
    for shell, path in scripts.items():
        assert path.read_text() == run(BIPC, "completion", shell), f"{shell}: the installed script is of another build"
    assert proposed_by_bash(scripts["bash"], "bipc", "") >= set(options)
    fish, zsh = scripts["fish"].read_text(), scripts["zsh"].read_text()
    for command, wanted in options.items():
        missing = wanted - proposed_by_bash(scripts["bash"], "bipc", command, "-")
        assert not missing, f"bash: {command} lacks {missing}"
        of_fish = "\n".join(re.findall(rf"^complete -c bipc -n '__fish_seen_subcommand_from {command}'.*$", fish, re.M)) + " "
        of_zsh = re.search(rf"^    {command}\)\n(.*?) ;;$", zsh, re.M | re.S).group(1)
        for option in wanted:
            assert f" -l {option[2:]} " in of_fish, f"fish: {command} lacks {option}"
            assert re.search(rf"{option}[=\[]", of_zsh), f"zsh: {command} lacks {option}"
    assert proposed_by_bash(scripts["bash"], "bipc", "run", "--backend", "") == {"jit", "interp"}
    assert proposed_by_bash(scripts["bash"], "bipc", "run", "--backend", "=", "j") == {"jit"}
    for shell in ("zsh", "fish"):
        if shutil.which(shell):
            run(shell, "-n", scripts[shell])


def c_abi(work):
    """The functions of bip.h with their types and the enumerations, as libabigail describes them: of a library that has the header's functions
    without their work, so that no C++ library and no version of the compiler comes into it."""
    header = re.sub(r"/\*.*?\*/", "", (ROOT / "runtime/include/bip/bip.h").read_text(), flags=re.S)
    functions = re.sub(r"(\bbip_\w+\([^;]*\));", r"\1 { __builtin_trap(); }", header)
    enumerations = "".join(f"enum {name} enumerators_of_{name};\n" for name in re.findall(r"enum (bip_\w+) \{", header))
    source, library, described = work / "c_abi.c", work / "c_abi.so", work / "c.abi"
    source.write_text(functions + enumerations)
    run("gcc", "-g", "-O0", "-fPIC", "-shared", "-w", source.name, "-o", library, cwd=work)
    run("abidw", "--no-corpus-path", "--no-elf-needed", "--no-comp-dir-path", "--no-show-locs", "--type-id-style", "hash", "--out-file", described, library)
    return described


def test_c_functions_stay_compatible(at):
    if not shutil.which("abidw"):
        print("skipped: the C functions are not compared with the last version's: abidw is missing (Debian's package abigail-tools)")
        return
    now = c_abi(at.work)
    declared = set(re.findall(r"\b(bip_\w+)\(", re.sub(r"/\*.*?\*/", "", (ROOT / "runtime/include/bip/bip.h").read_text(), flags=re.S)))
    assert declared == set(re.findall(r"<function-decl name='(bip_\w+)'", now.read_text())), "abidw did not see the functions of bip.h"
    exported = set(re.findall(r" T (bip_\w+)$", run("nm", "-D", next(at.prefix.glob("lib*/**/libbip_runtime.so"))), re.M))
    assert exported >= declared, f"libbip_runtime.so lacks {declared - exported}"
    done = subprocess.run(["abidiff", "--no-added-syms", ABI, now], capture_output=True, text=True)
    assert done.returncode == 0, ("libbip_runtime.so.0 would no longer serve programs of the last version; a change that is meant needs a new SOVERSION "
                                  f"and `tests/package/test_package.py --update`\n{done.stdout}")


def main():
    with tempfile.TemporaryDirectory() as folder:
        work = pathlib.Path(folder)
        if "--update" in sys.argv:
            shutil.copyfile(c_abi(work), ABI)
            return 0
        at = Installation(work)
        passed = failed = 0
        for name, test in sorted((n, f) for n, f in globals().items() if n.startswith("test_")):
            try:
                test(at)
                passed += 1
            except Exception as problem:  # a missing file counts as a failure like any other
                failed += 1
                print(f"FAILED {name[5:]}: {problem}")
        print(f"package: {passed} passed, {failed} failed")
        return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
