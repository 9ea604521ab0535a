#!/usr/bin/env python3
"""tests/fuzz/long.py [--seconds N] [--turn N] [--only TARGET] [--keep]: an hour of libFuzzer, one process at a time.

The targets take turns (`--turn` seconds, default 150) until `--seconds` (default 3600) have passed; a finding ends its turn only. Seeds are
our own models and goldens (`tests/fuzz/test_fuzz.py --corpus`), tests/fuzz/corpus and the kept inputs; the dictionary is made from the grammar's words. What the
turns learn stays in BUILD/fuzzing/TARGET, findings in BUILD/fuzzing/findings; a second call goes on from there. `--keep` (alone: with `--seconds 0`)
minimises what was learnt (-merge=1) into the archives in tests/fuzz/corpus, the smallest inputs first, at most 350 kB a target.
BIPC_FUZZ_BUILD names the build of the preset `fuzz` (default: build-fuzz). The last line is "fuzzed N s, N inputs, N findings"; exit code 1 if there is a finding.
"""
import argparse
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

import kept_inputs

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
HERE = ROOT / "tests" / "fuzz"
BUILD = pathlib.Path(os.environ.get("BIPC_FUZZ_BUILD") or ROOT / "build-fuzz").resolve()
WORK = BUILD / "fuzzing"
TARGETS = ("text", "bsys", "format", "lsp", "genom", "rules", "property", "frame", "bip1")
MOST_BYTES = 350_000
PROTOCOL = ["textDocument", "uri", "text", "version", "position", "line", "character", "range", "start", "end", "contentChanges", "newName", "context", "includeDeclaration", "jsonrpc",
            "method", "params", "id", "initialize", "shutdown", "exit", "textDocument/didOpen", "textDocument/didChange", "textDocument/didClose", "textDocument/didSave",
            "textDocument/definition", "textDocument/references", "textDocument/hover", "textDocument/rename", "textDocument/prepareRename", "textDocument/completion",
            "textDocument/documentSymbol", "textDocument/formatting", "textDocument/semanticTokens/full", "textDocument/codeAction", "Content-Length: "]


def dictionary():
    """The grammar's words and the protocol's, in libFuzzer's form."""
    grammar = "".join((ROOT / "grammar" / name).read_text(encoding="utf-8") for name in ("BipLexer.g4", "BipParser.g4", "Bip1Lexer.g4", "Bip1Parser.g4"))
    words = sorted({word for word in re.findall(r"'([!-&(-\[\]-~]{1,16})'", grammar)} | set(PROTOCOL))
    path = WORK / "words.dict"
    path.write_text("".join('"' + word.replace("\\", "\\\\").replace('"', '\\"') + '"\n' for word in words), encoding="utf-8")
    return path


# libFuzzer's time-out goes by the clock, and `nice` may let us wait: what takes a minute is run once more by itself, and counts if it takes ten
# seconds of the processor (bip-fuzz).
def command(target, *options):
    return ["nice", "-n", "19", str(BUILD / f"fuzz_{target}"), "-rss_limit_mb=2048", "-malloc_limit_mb=1024", "-timeout=60", "-print_final_stats=1", *options]


def turn(target, seconds, words):
    """One turn; its number of inputs, seconds and whether it found something."""
    start = time.monotonic()
    found = WORK / "findings"
    kept = [str(path) for path in (WORK / "corpus" / target, HERE / "regressions" / target) if path.is_dir()]
    done = subprocess.run(command(target, f"-max_total_time={seconds}", f"-dict={words}", f"-artifact_prefix={found}/{target}-", "-max_len=8000", "-reload=0", str(WORK / target), *kept),
                          capture_output=True, text=True, errors="replace", cwd=WORK)
    inputs = re.search(r"stat::number_of_executed_units:\s*(\d+)", done.stderr)
    coverage = re.findall(r" cov: (\d+)", done.stderr)
    with open(WORK / f"{target}.log", "a", encoding="utf-8") as log:
        log.write(done.stderr[-20000:])
    is_found = done.returncode != 0
    if is_found and "SUMMARY: libFuzzer: timeout" in done.stderr:
        slow = re.search(r"Test unit written to (\S+)", done.stderr)
        if slow and subprocess.run([str(BUILD / "bip-fuzz"), target, slow.group(1)], capture_output=True, cwd=WORK).returncode == 0:
            pathlib.Path(slow.group(1)).unlink()
            is_found = False
    if is_found:
        summary = [line for line in done.stderr.splitlines() if "SUMMARY" in line or "ERROR" in line or "Test unit written" in line]
        print(f"{target}: " + "\n  ".join(summary or done.stderr.splitlines()[-5:]), flush=True)
    ran = int(inputs.group(1)) if inputs else 0
    print(f"{target}: {time.monotonic() - start:.0f} s, {ran} inputs, coverage {coverage[-1] if coverage else '?'}", flush=True)
    return ran, time.monotonic() - start, is_found


def keep(target):
    """What covers all that was covered, the smallest inputs first, into tests/fuzz/corpus."""
    folder = WORK / "corpus" / target
    with tempfile.TemporaryDirectory() as least:
        sources = [str(path) for path in (folder, WORK / target) if path.is_dir()]
        subprocess.run(command(target, "-merge=1", "-max_len=8000", least, *sources), capture_output=True, check=True, cwd=WORK)
        inputs, total = {}, 0
        for path in sorted(pathlib.Path(least).iterdir(), key=lambda p: (p.stat().st_size, p.name)):
            total += path.stat().st_size
            if total > MOST_BYTES:
                total -= path.stat().st_size
                break
            inputs[path.name] = path.read_bytes()
        kept_inputs.pack(target, inputs)
    print(f"{target}: kept {len(inputs)} inputs, {total} bytes", flush=True)


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--seconds", type=int, default=3600)
    arguments.add_argument("--turn", type=int, default=150)
    arguments.add_argument("--only", choices=TARGETS)
    arguments.add_argument("--keep", action="store_true")
    options = arguments.parse_args()
    targets = [options.only] if options.only else list(TARGETS)
    missing = [t for t in targets if not (BUILD / f"fuzz_{t}").exists()]
    if missing:
        sys.exit(f"tests/fuzz/long.py: no fuzz_{missing[0]} in {BUILD}; build it: tools/setup --fuzz && cmake --preset fuzz && cmake --build --preset fuzz")
    (WORK / "findings").mkdir(parents=True, exist_ok=True)
    subprocess.run([sys.executable, str(HERE / "test_fuzz.py"), "--corpus", str(WORK)], check=True, env={**os.environ, "BIPC_BUILD_DIR": os.environ.get("BIPC_BUILD_DIR") or str(BUILD)})
    for target in targets:
        (WORK / target).mkdir(exist_ok=True)
        kept_inputs.unpack(target, WORK / "corpus" / target)
    if (WORK / "format").is_dir():
        for path in (WORK / "text").iterdir():
            if not (WORK / "format" / path.name).exists():
                shutil.copyfile(path, WORK / "format" / path.name)
    words = dictionary()
    passed = inputs = findings = number = 0
    while passed < options.seconds:
        ran, seconds, found = turn(targets[number % len(targets)], max(1, min(options.turn, int(options.seconds - passed))), words)
        number += 1
        inputs += ran
        passed += seconds
        findings += found
    if options.keep:
        for target in targets:
            keep(target)
    print(f"fuzzed {passed:.0f} s, {inputs} inputs, {findings} findings")
    sys.exit(1 if findings else 0)


if __name__ == "__main__":
    main()
