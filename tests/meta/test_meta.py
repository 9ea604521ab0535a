#!/usr/bin/env python3
"""Guards of the house: each check_* function below looks at the tree and returns what it found wrong.

    tests/meta/test_meta.py [part of a check's name ...]

Needs python3; check_cli_docs needs a built bipc ($BIPC or build/bipc).
"""
import contextlib
import importlib.machinery
import importlib.util
import io
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import time

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
sys.path.insert(0, str(HERE))
import cli_docs  # noqa: E402

SOURCES = sorted(p for folder in ("compiler", "runtime", "tools") for p in (ROOT / folder).rglob("*")
                 if p.suffix in (".cpp", ".hpp", ".def"))
CPP = [p for folder in ("compiler", "runtime", "tools", "tests", "models") for p in (ROOT / folder).rglob("*") if p.suffix in (".cpp", ".hpp", ".h")]
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', re.M)

# The arrow: what each folder may include beside itself. Everything not listed here is upstream or a neighbour.
BASE = {"base"}
SOURCE = BASE | {"source"}
DIAG = SOURCE | {"diag"}
SYNTAX = SOURCE | {"syntax"}
MODEL = DIAG | SYNTAX | {"model"}
SYSTEM = MODEL | {"system"}
ANALYSIS = SYSTEM | {"analysis"}
LOWER = SYSTEM | {"lower", "runtime"}
MAY_INCLUDE = {
    "base": BASE, "source": SOURCE, "diag": DIAG, "syntax": SYNTAX, "parse": DIAG | SYNTAX | {"parse"}, "migrate": DIAG | SYNTAX | {"parse", "migrate"},
    "model": MODEL, "system": SYSTEM, "analysis": ANALYSIS, "lower": LOWER, "interp": LOWER | {"interp"}, "jit": LOWER | {"jit"},
    "emit_cpp": LOWER | {"emit_cpp"}, "steps": LOWER | {"analysis", "steps"}, "graph": ANALYSIS | {"graph"}, "verify": LOWER | {"analysis", "verify"},
    "genom": DIAG | SYNTAX | {"parse", "genom"}, "ros2": DIAG | {"genom", "live", "runtime", "ros2"}, "dds": {"base", "ros2", "dds"},
    "ros1": DIAG | {"genom", "ros2", "runtime", "ros1"}, "roscpp": {"base", "ros2", "ros1", "roscpp"}, "rules": DIAG | SYNTAX | {"genom", "rules"},
    "exchange": ANALYSIS | {"exchange", "verify"},
    "library": LOWER | {"graph", "interp", "verify", "pipeline", "library"},
    "pipeline": LOWER | {"parse", "steps", "interp", "jit", "zmq", "emit_cpp", "verify", "pipeline"}, "zmq": {"runtime", "zmq"},
    "debug": LOWER | {"analysis", "verify", "debug"}, "view": LOWER | {"graph", "view"},
    "traces": LOWER | {"graph", "traces"},
    "live": LOWER | {"analysis", "verify", "debug", "graph", "view", "serve", "live"}, "index": SYNTAX | {"index"}, "serve": {"runtime", "serve"},
    "runtime": {"runtime"},
}
VENDORS = {
    "ANTLR": (re.compile(r"^antlr4|^Bip1?(Lexer|Parser)\.h|^antlr4-runtime"), ("compiler/parse/",)),
    "LLVM": (re.compile(r"^llvm(-c)?/"), ("compiler/jit/",)),
    "solvers": (re.compile(r"^(cadical|z3)"), ("compiler/verify/solver/", "tools/certcheck/")),
    "asio": (re.compile(r"^asio"), ("compiler/serve/",)),
    "Boost": (re.compile(r"^boost/"), ("compiler/live/", "compiler/ros1/types.cpp")),
    "zstd": (re.compile(r"^zstd"), ("compiler/traces/",)),
    "libedit": (re.compile(r"^(editline/|histedit)"), ("compiler/debug/",)),
    "Cyclone DDS": (re.compile(r"^dds/"), ("compiler/dds/",)),
    "roscpp": (re.compile(r"^ros/"), ("compiler/roscpp/",)),
    "Fast DDS": (re.compile(r"^fast(dds|rtps|cdr)/"), ("tests/ros2/",)),
    "CLI11": (re.compile(r"^CLI/"), ("compiler/driver/", "tools/")),
}
BANNED = ("no viable alternative", "mismatched input", "extraneous input", "missing '", "token recognition error",
          "terminate called", "std::bad", "internal error", "illegal", "invalid ", "please")
GOLDEN_STDERR = re.compile(r"^--- stderr$(.*?)(?=^--- |\Z)", re.M | re.S)


def relative(path):
    return path.relative_to(ROOT).as_posix()


def folder_of(include):
    """compiler/model/x.hpp -> model; runtime/…, bip/… -> runtime; else None."""
    parts = include.split("/")
    if parts[-1] in ("assert.hpp", "ids.hpp", "result.hpp", "distributions.hpp") and "bip" in parts:
        return None  # these need nothing, all may include them
    if include == "runtime/core/graph_algorithms.hpp":
        return None  # needs bip/assert.hpp only: one implementation for the compiler and the runtime
    if parts[0] == "compiler" and len(parts) > 2:
        return parts[1]
    if parts[0] in ("runtime", "bip"):
        return "runtime"
    return None


def check_layering():
    problems = []
    for path in SOURCES:
        name = relative(path)
        own = folder_of(name)
        allowed = MAY_INCLUDE.get(own)
        for _, include in INCLUDE.findall(path.read_text(encoding="utf-8")):
            target = folder_of(include)
            if target and allowed is not None and target not in allowed:
                problems.append(f"{name}: includes {include}, which is not downstream of {own}")
    return problems


def check_runtime_layering():
    """core <- distributed, trace <- explore <- engine <- debug; engine's headers may be seen by the compiler only."""
    allowed = {"core": {"core", "include"}, "distributed": {"core", "distributed"}, "trace": {"core", "trace"}, "explore": {"core", "trace", "explore"},
               "engine": {"core", "distributed", "trace", "explore", "engine"}, "debug": {"core", "trace", "explore", "engine", "debug"}, "include": {"include"}}
    problems = []
    for path in SOURCES:
        name = relative(path)
        parts = name.split("/")
        if parts[0] != "runtime" or len(parts) < 3:
            continue
        for _, include in INCLUDE.findall(path.read_text(encoding="utf-8")):
            target = include.split("/")
            if target[0] == "runtime" and len(target) > 2 and target[1] not in allowed.get(parts[1], set()):
                problems.append(f"{name}: includes {include}, which is not downstream of runtime/{parts[1]}")
    return problems


def check_vendors_are_caged():
    problems = []
    for path in SOURCES:
        name = relative(path)
        for _, include in INCLUDE.findall(path.read_text(encoding="utf-8")):
            for vendor, (pattern, cages) in VENDORS.items():
                if pattern.search(include) and not name.startswith(cages):
                    problems.append(f"{name}: includes {include}: {vendor} belongs in {' '.join(cages)}")
            if name.startswith("runtime/") and (include.startswith(("fmt/", "nlohmann/")) or include == "iostream"):
                problems.append(f"{name}: includes {include}: the runtime is lean")
    return problems


def check_throw_only_in_parse():
    # emitted.hpp, ffi_calls.hpp, event_source.hpp: a fault leaves an emitted function by an exception that the same function catches.
    # genom3*.hpp: inputs of codels and what these give more than fits, in a model's own C++; what bip/codels.hpp puts around each codel catches it.
    # json_value.hpp: the same, and what asks whether an input agrees (bip/service_requests.hpp) catches it.
    # out_of_memory.hpp: main() catches it, as what `new` throws.
    allowed = ("compiler/parse/", "tools/", "compiler/base/out_of_memory.hpp", "runtime/include/bip/emitted.hpp", "runtime/include/bip/ffi_calls.hpp",
               "runtime/include/bip/event_source.hpp", "runtime/include/bip/draws.hpp", "runtime/include/bip/genom3", "runtime/include/bip/json_value.hpp")
    return [f"{relative(p)}:{n}: throw" for p in SOURCES if not relative(p).startswith(allowed)
            for n, line in enumerate(p.read_text(encoding="utf-8").splitlines(), 1)
            if re.search(r"\bthrow\b(?!s)", re.sub(r'"[^"]*"', '""', line.split("//")[0]))]


# Enums of vendors, which are large and not ours: a switch over one of them may have a `default:`.
VENDOR_LABELS = re.compile(r"(?:::)?(?:Bip1?Parser|Bip1?Lexer|antlr4|llvm|Catch)\b")


def blanked(text):
    """Comments, strings and characters as blanks of the same length, so that braces can be counted."""
    return re.sub(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|(?<![0-9a-fA-F])\'(?:\\.|[^\'\\\n])+\'',
                  lambda m: re.sub(r"[^\n]", " ", m[0]), text, flags=re.S)


def switches(text):
    """(position, text at the switch's own level) of each switch: what nested switches contain is blank."""
    begins = [m.start() for m in re.finditer(r"\bswitch\s*\(", text)]
    spans = []
    for begin in begins:
        at = text.find("{", begin)
        depth = 0
        for end in range(at, len(text)):
            depth += {"{": 1, "}": -1}.get(text[end], 0)
            if depth == 0:
                break
        spans.append((begin, at, end))
    for begin, at, end in spans:
        body = text[at:end]
        for other, _, other_end in spans:
            if at < other < end:
                body = body[:other - at] + " " * (other_end - other) + body[other_end - at:]
        yield begin, body


def check_switches_list_all_kinds():
    """No `default:` in a switch over our enums: -Wswitch-enum then names the switches that a new enumerator misses."""
    problems = []
    for path in CPP:
        text = path.read_text(encoding="utf-8")
        if "default:" not in text:
            continue
        code = blanked(text)
        for begin, body in switches(code):
            if not re.search(r"\bdefault\s*:", body):
                continue
            labels = re.findall(r"\bcase\s+([\w:]+::\w+)\s*:(?!:)", body) + re.findall(r"\b(BIP_\w*OPS)\(", body)
            ours = [label for label in labels if not VENDOR_LABELS.match(label)]
            # A list of operators stands for labels of the vendor if the others are (compiler/parse).
            if ours and not (all(o.startswith("BIP_") for o in ours) and len(ours) < len(labels)):
                problems.append(f"{relative(path)}:{code.count(chr(10), 0, begin) + 1}: `default:` beside {ours[0]}")
    return problems


# Here one kind of statement is told from all others, or from those that a switch before has left over.
STATEMENT_FILTERS = {"compiler/syntax/validate_syntax.cpp", "compiler/syntax/print_action.cpp", "compiler/migrate/translate_code.cpp",
                     "compiler/emit_cpp/functions.cpp", "compiler/system/validate_code.cpp", "compiler/verify/net/live_variables.cpp",
                     "compiler/verify/net/abstract_code.cpp", "compiler/verify/symbolic/symbolic_code.cpp",
                     "compiler/verify/invariants/affine_code.cpp", "compiler/verify/invariants/interval_domain.hpp"}


def check_statements_are_switched_over():
    """Kinds of statements are told apart by `switch`, assigned_variable or assigned_path: the last `else` would treat a new kind as an old one."""
    return [f"{relative(path)}:{number}: {line.strip()}" for path in SOURCES if relative(path) not in STATEMENT_FILTERS
            for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1)
            if re.search(r"[=!<>]=\s*(?:\w+::)*Stmt(?:Op|Kind)::", line)]


def check_ctest_knows_all_groups():
    """Each group of run_all.py can be run by `ctest -R GROUP`; those of `unit` are programs of their own there."""
    groups = re.findall(r'^ +(?:\*\(\[)?\("(\w+)", (?:\[|needs|list)', (ROOT / "tests/run_all.py").read_text(encoding="utf-8"), re.M)
    known = re.search(r"^foreach\(group ([\w ]+)\)$", (ROOT / "tests/CMakeLists.txt").read_text(encoding="utf-8"), re.M)[1].split()
    return [f"tests/CMakeLists.txt: {name}: not in both lists of groups" for name in sorted((set(groups) - {"unit"}) ^ set(known))]


def loaded_run_all():
    spec = importlib.util.spec_from_file_location("run_all", ROOT / "tests/run_all.py")
    run_all = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(run_all)
    return run_all


def check_programs_of_tests_end():
    """A program that does not end in time is a failure, and what one leaves behind is not waited for."""
    run_all = loaded_run_all()
    run_all.TIME_LIMIT = 3 / float(os.environ.get("BIPC_TEST_PATIENCE") or 1)
    problems = []
    with tempfile.TemporaryDirectory() as folder:
        run_all.LOGS = pathlib.Path(folder)
        for name, words, wanted in (("endless", "import time; print('1 passed, 0 failed', flush=True); time.sleep(600)", (1, 1)),
                                    ("orphan", "import subprocess; subprocess.Popen(['sleep', '300']); print('1 passed, 0 failed')", (1, 0))):
            begin = time.monotonic()
            with contextlib.redirect_stdout(io.StringIO()):
                found = run_all.run_script(name, [sys.executable, "-c", words])
            # Where interrupts are ignored the endless one is killed after 20 s; they would take 600 and 300 s.
            if found != wanted or time.monotonic() - begin > 200:
                problems.append(f"tests/run_all.py: {name}: {found} after {time.monotonic() - begin:.1f} s")
    return problems


def check_samples():
    """A sampled run says what it leaves out and runs the rest smaller; options that are none end tools/test before it builds."""
    run_all = loaded_run_all()
    problems = []
    whole = [("a", [run_all.script("same", "x.py"), run_all.script("less", "x.py", sample=["1"]), run_all.script("long", "x.py", sample=run_all.LEFT_OUT)]),
             ("b", [run_all.script("longer", "y.py", sample=run_all.LEFT_OUT)])]
    kept, left_out, fewer = run_all.sampled(whole)
    found = [(name, [job.name for job in jobs]) for name, jobs in kept], left_out, fewer
    if found != ([("a", ["same", "less"])], ["a:long", "b:longer"], ["a:less"]):
        problems.append(f"tests/run_all.py: the sample is {found}")
    with tempfile.TemporaryDirectory() as folder:
        build = pathlib.Path(folder)
        (build / "CMakeCache.txt").write_text("BIPC_JIT:BOOL=OFF\n")
        environment = {**os.environ, "BIPC_BUILD_DIR": folder}
        for arguments, code, wanted in ((["--sample", "view:view", "dap"], None, "left out: view:view (tools/test --all"),
                                        (["--samples"], 2, "unrecognized arguments: --samples"), (["no-group"], 1, "no group no-group")):
            done = subprocess.run([sys.executable, str(ROOT / "tests/run_all.py"), *arguments], capture_output=True, text=True, env={**environment, "BIPC": "/bin/false"})
            if wanted not in done.stdout + done.stderr or code not in (None, done.returncode):
                problems.append(f"tests/run_all.py {' '.join(arguments)}: exit code {done.returncode}\n{(done.stdout + done.stderr)[-600:]}")
    for arguments in (["--every"], ["--all", "golden"]):
        done = subprocess.run([str(ROOT / "tools/test"), *arguments], capture_output=True, text=True)
        if done.returncode != 2 or "tools/test" not in done.stderr:
            problems.append(f"tools/test {' '.join(arguments)}: exit code {done.returncode}, {done.stderr!r}")
    return problems


def kinds():
    text = (ROOT / "compiler/diag/kinds.def").read_text(encoding="utf-8")
    return re.findall(r'^BIP_DIAG\((B\d+), (\w+), "([^"]+)"', text, re.M)


def goldens():
    return sorted((ROOT / "tests/golden").rglob("*.golden"))


def check_codes_have_pages():
    pages = {p.stem for p in (ROOT / "compiler/diag/explain").glob("*.md")}
    return [f"{code}: no page compiler/diag/explain/{code}.md" for code, _, _ in kinds() if code not in pages]


def check_pages_have_codes():
    codes = {code for code, _, _ in kinds()}
    problems = []
    for page in sorted((ROOT / "compiler/diag/explain").glob("*.md")):
        if page.stem == "README":
            continue
        if page.stem.startswith("B") and page.stem not in codes:
            problems.append(f"{relative(page)}: no such code in kinds.def")
        if not page.read_text(encoding="utf-8").startswith(f"# {page.stem}: "):
            problems.append(f"{relative(page)}: first line is not `# {page.stem}: title`")
    return problems


def check_codes_have_goldens():
    """Every code, those of runs and verdicts included, is shown by what some golden expects; there are at least 120."""
    expected = re.compile(r"^--- std(?:out|err)$(.*?)(?=^--- |\Z)", re.M | re.S)
    seen = set()
    for golden in goldens():
        for part in expected.findall(golden.read_text(encoding="utf-8", errors="replace")):
            seen.update(re.findall(r"\[([BRV]\d{4})\]", part))
    pages = {p.stem for p in (ROOT / "compiler/diag/explain").glob("*.md") if p.stem[0] in "RV"}
    codes = sorted({code for code, _, _ in kinds()} | pages)
    problems = [f"{code}: no golden shows it" for code in codes if code not in seen]
    shown = len(seen & set(codes))
    return problems if shown >= 120 else [*problems, f"only {shown} codes are shown"]


def check_pages_match_runtime():
    """R codes that the runtime can print have pages."""
    text = "\n".join(p.read_text(encoding="utf-8") for p in SOURCES if relative(p).startswith("runtime/"))
    codes = sorted(set(re.findall(r'"(R\d{4})"', text)))
    return [f"{c}: no page" for c in codes if not (ROOT / f"compiler/diag/explain/{c}.md").exists()]


def check_goldens_speak_plainly():
    problems = []
    for golden in goldens():
        for part in GOLDEN_STDERR.findall(golden.read_text(encoding="utf-8", errors="replace")):
            # Lines of the frame that quote the model are not our words.
            ours = "\n".join(l for l in part.splitlines() if not re.match(r"^\s*\d+ \|", l)).lower()
            problems += [f"{relative(golden)}: {phrase!r}" for phrase in BANNED if phrase.lower() in ours]
    return problems


def check_a_third_of_the_goldens_fail():
    everything = goldens()
    fails = [g for g in everything if g.name.startswith("fail_")]
    if everything and len(fails) * 3 < len(everything):
        return [f"{len(fails)} of {len(everything)} goldens are fail_"]
    return []


def check_file_sizes():
    """A file is an idea, whole: no limit. Long ones are named, so that somebody asks what the second idea in them is."""
    for path in SOURCES:
        lines = path.read_text(encoding="utf-8").count("\n")
        if lines > 800:
            print(f"warning: {relative(path)}: {lines} lines: what is the second idea in it?")
    return []


def check_format():
    """All C++ is as .clang-format says (clang-format 14, Debian 12's)."""
    if shutil.which("clang-format") is None:
        return ["clang-format is missing: tools/setup --test installs it"]
    version = subprocess.run(["clang-format", "--version"], capture_output=True, text=True).stdout
    if "version 14." not in version:
        print(f"skipped: the formatting is that of clang-format 14, and this is {version.strip()}")
        return []
    done = subprocess.run(["clang-format", "--dry-run", "-Werror", *(str(p) for p in sorted(CPP))], capture_output=True, text=True)
    return sorted({line.split(":")[0].replace(str(ROOT) + "/", "") + ": not formatted (clang-format -i)" for line in done.stderr.splitlines() if ": error:" in line})


def check_certcheck_can_be_read():
    """A user who trusts no other program can read certcheck: at most 4,347 lines of code (neither blank nor only comment) and 4,956 in all. A limit is raised for a new kind of certificate only."""
    most_code, most = 4347, 4956
    lines = [line.strip() for p in SOURCES if relative(p).startswith("tools/certcheck/") for line in p.read_text(encoding="utf-8").splitlines()]
    code = sum(line != "" and not line.startswith("//") for line in lines)
    problems = [f"tools/certcheck: {code} lines of code are more than {most_code}"] if code > most_code else []
    return problems + ([f"tools/certcheck: {len(lines)} lines are more than {most}"] if len(lines) > most else [])


def check_files_begin_with_prose():
    return [f"{relative(p)}: does not begin with a comment" for p in SOURCES
            if not p.read_text(encoding="utf-8").lstrip().startswith("//")]


DOCUMENTS = sorted(p for p in ROOT.rglob("*.md") if not any(part.startswith(("build", ".git")) for part in p.relative_to(ROOT).parts))
TOP_FOLDERS = ("compiler", "grammar", "models", "runtime", "stdlib", "tests", "tools")
CODE_FILE = re.compile(r"[\w.-]+\.(?:cpp|hpp|h|def|py|md|g4|txt|json)$")


def file_names():
    return {p.name for folder in TOP_FOLDERS for p in (ROOT / folder).rglob("*")} | {p.name for p in ROOT.iterdir()}


def check_paths_in_documents_exist():
    """In *.md: `path/of/a.file` in backticks (from the root, the document's folder, compiler or runtime), `file.hpp`, and [links](to.md)."""
    names = file_names()
    problems = []
    for document in DOCUMENTS:
        text = re.sub(r"^```.*?^```", "", document.read_text(encoding="utf-8"), flags=re.M | re.S)
        bases = (ROOT, document.parent, ROOT / "compiler", ROOT / "runtime", ROOT / "runtime/include", ROOT / "compiler/library/include", ROOT / "tests")
        for word in re.findall(r"`([\w.*-]+(?:/[\w.*-]+)*)/?`", text):
            parts = word.split("/")
            is_ours = CODE_FILE.match(parts[-1]) or (len(parts) > 1 and parts[0] in TOP_FOLDERS)
            is_placeholder = "explain" in document.parts or "NAME" in word or re.match(r"[A-Z]{2,}_", parts[-1]) or (len(parts) == 1 and "*" in word)
            if not is_ours or is_placeholder:
                continue
            found = parts[0] in names if len(parts) == 1 else any(next(base.glob(word), None) for base in bases)
            if not found:
                problems.append(f"{relative(document)}: `{word}` does not exist")
        for link in re.findall(r"\]\(([^)#\s]+)[^)]*\)", text):
            if "://" not in link and not (document.parent / link).exists():
                problems.append(f"{relative(document)}: the link to {link} leads nowhere")
    return problems


def check_documents_in_comments_exist():
    """A document that a source names (x.md) is in the repository, at that path if it has one."""
    names = file_names()
    problems = []
    for path in [*SOURCES, *(p for folder in ("tests", "tools") for p in (ROOT / folder).rglob("*.py"))]:
        if path == pathlib.Path(__file__).resolve():
            continue
        for word in re.findall(r"(?<![\w/.%}<>*-])((?:[\w-]+/)*[\w-]+\.md)\b", path.read_text(encoding="utf-8")):
            bases = (ROOT, path.parent, ROOT / "compiler/docs")
            if not (any((base / word).exists() for base in bases) or ("/" not in word and word in names)):
                problems.append(f"{relative(path)}: {word} does not exist")
    return problems


def check_license():
    text = (ROOT / "LICENSE").read_text(encoding="utf-8") if (ROOT / "LICENSE").exists() else ""
    wanted = ("Apache License", "Version 2.0, January 2004", "LLVM Exceptions to the Apache 2.0 License")
    return [f"LICENSE: lacks {w!r}" for w in wanted if w not in text]


def check_no_paths_of_a_machine():
    pattern = re.compile(r"/(home|Users|work)/[A-Za-z]")
    tracked = [p for folder in ("compiler", "runtime", "tools", "tests", "grammar", "models", "stdlib") for p in (ROOT / folder).rglob("*")
               if p.is_file() and p.suffix not in (".svg", ".png", ".pyc") and p != pathlib.Path(__file__).resolve()]
    return [f"{relative(p)}:{n}: {line.strip()[:80]}" for p in tracked
            for n, line in enumerate(p.read_text(encoding="utf-8", errors="replace").splitlines(), 1) if pattern.search(line)]


def check_editor_starts_only_programs_of_the_user():
    """A workspace that one opens chooses no program: settings that name one are of the machine, what runs a model asks for trust."""
    package = json.loads((ROOT / "tools/vscode/package.json").read_text(encoding="utf-8"))
    settings = package["contributes"]["configuration"]["properties"]
    bad = [f"{name}: its scope is not `machine`" for name, setting in settings.items()
           if name.endswith(".path") and setting.get("scope") != "machine"]
    if not any(name.endswith(".path") for name in settings):
        bad.append("no setting names a program: this check looks at nothing")
    if package["capabilities"]["untrustedWorkspaces"]["supported"] is not True:
        bad.append("workspaces that are not trusted are not supported")
    # Only `explain`, the language server and functions that begin with modelOf, which asks for trust, start a program.
    source = (ROOT / "tools/vscode/src/extension.js").read_text(encoding="utf-8")
    starts = re.compile(r"\b(?:spawn|execFile|executeTask|startDebugging)\(")
    head, *functions = re.split(r"^(?=(?:async )?function )", source, flags=re.M)
    if starts.search(head):
        bad.append("extension.js: a program is started outside of functions")
    for function in functions:
        name = re.match(r"(?:async )?function (\w+)", function)[1]
        body = function.split("{", 1)[1]
        start = starts.search(body)
        if start and "modelOf(" not in body[:start.start()] and name != "explainPage":
            bad.append(f"extension.js: {name} starts a program without asking for trust")
    return bad


def check_builds_show_progress():
    """The first lines of a build are shown before its last step is done, and a failing step's words are whole."""
    script = (f"source '{ROOT}/tools/lib.sh'; {{ for step in 1 2 3 4 5 6 7 8 9 10; do echo \"[$step/20] Building $step\"; done; "
              "read -r answer; echo '  error: two  blanks'; echo '[20/20] Linking bipc'; echo 'ninja: no work to do.'; } | show_progress 0")
    with subprocess.Popen(["bash", "-c", script], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as build:
        # A build that shows nothing before its end is ended: then the first line is missing.
        limit = threading.Timer(20, build.kill)
        limit.start()
        first = build.stdout.readline()
        if first:
            build.stdin.write("go on\n")
            build.stdin.flush()
        rest = build.stdout.read().splitlines()
        limit.cancel()
    problems = [] if first.startswith("[10/20] Building 10  (") else [f"tools/lib.sh: shown before the last step: {first!r}"]
    if not (len(rest) == 2 and rest[0] == "  error: two  blanks" and rest[1].startswith("[20/20] Linking bipc  (")):
        problems.append(f"tools/lib.sh: shown then: {rest!r}")
    return problems


def check_nightly():
    """tools/test_nightly has all the long runs that pages name, its parts are there, and a part that decides nothing fails."""
    loader = importlib.machinery.SourceFileLoader("test_nightly", str(ROOT / "tools/test_nightly"))
    nightly = importlib.util.module_from_spec(importlib.util.spec_from_loader("test_nightly", loader))
    without_cache, sys.dont_write_bytecode = sys.dont_write_bytecode, True
    loader.exec_module(nightly)
    sys.dont_write_bytecode = without_cache
    rows = nightly.parts(1)
    problems = [f"tools/test_nightly: part {name}: no {nightly.missing_script(command)}" for name, command, _ in rows if nightly.missing_script(command)]
    listed = [nightly.text_of(command, variables) for _, command, variables in rows]
    for page in [ROOT / "CONTRIBUTING.md", ROOT / "compiler/docs/testing.md", *sorted((ROOT / "tests").glob("**/README.md"))]:
        for line in page.read_text(encoding="utf-8").splitlines():
            if "nightly" not in line.lower():
                continue
            for script in re.findall(r"tests/[\w/]+\.(?:py|sh)", line):
                if not any(script in text for text in listed):
                    problems.append(f"{page.relative_to(ROOT)} names {script} as a nightly run, and tools/test_nightly has no such part")
    faults = next((command for name, command, _ in rows if name == "faults"), [])
    if "--all" not in faults:
        problems.append("tools/test_nightly: the part faults has no --all")
    for command, wanted in ((["tests/no_such_test.py"], (0, 1)), ([sys.executable, "tests/no_such_test.py"], (0, 1)),
                            ([sys.executable, "tests/meta/nightly_parts.py", "silent"], (0, 1)), ([sys.executable, "tests/meta/nightly_parts.py", "nothing"], (0, 1)),
                            ([sys.executable, "tests/meta/nightly_parts.py", "crash"], (3, 1)), ([sys.executable, "tests/meta/nightly_parts.py", "sound"], (3, 0)),
                            ([sys.executable, "tests/meta/nightly_parts.py", "systems"], (3, 2))):
        with contextlib.redirect_stdout(io.StringIO()):
            found = nightly.run_part(command, {})
        if found != wanted:
            problems.append(f"tools/test_nightly: {' '.join(command[-2:])} counts as {found}, not as {wanted}")
    return problems


def check_cli_docs():
    return cli_docs.differences()


def main():
    checks = [(n[6:], f) for n, f in sorted(globals().items()) if n.startswith("check_")]
    wanted = sys.argv[1:]
    failed = 0
    ran = 0
    for name, check in checks:
        if wanted and not any(w in name for w in wanted):
            continue
        ran += 1
        problems = check()
        if problems:
            failed += 1
            print(f"FAILED {name}: {len(problems)}")
            for problem in problems[:40]:
                print(f"  {problem}")
            if len(problems) > 40:
                print(f"  … and {len(problems) - 40} more")
    print(f"meta: {ran - failed} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
