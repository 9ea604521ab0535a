#!/usr/bin/env python3
"""Sessions of the debug adapter (`bipc dap`) against their goldens, and thousands of malformed messages.

    tests/dap/test_dap.py [--update] [part of a session's name ...]

A session (tests/dap/sessions/*.dap) is a list of lines:
    # comment
    > command {"json": "arguments"}     sent; what comes back until the next line is expected
    < {...}                             a response or event, without `seq` and with folders as $DIR
The models are files of tests/dap/models, copied into an empty folder; `$ ` lines are executed there. After a request that moves the model the client
waits for `stopped` or `terminated`, after `>> ` instead of `> ` only for the response. --update writes the `<` lines.
"""
import json
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
import client  # noqa: E402

MOVES = {"configurationDone", "next", "stepIn", "stepOut", "stepBack", "continue", "reverseContinue", "restart", "pause"}


def normal(message, folder):
    """As goldens have it."""
    message = {k: v for k, v in message.items() if k not in ("seq", "request_seq")}
    return json.dumps(message, ensure_ascii=False).replace(folder, "$DIR")


def play(path):
    """The session with what the adapter says."""
    lines = [line for line in path.read_text(encoding="utf-8").splitlines() if not line.startswith("< ")]
    shown = []
    with tempfile.TemporaryDirectory() as made:
        folder = str(pathlib.Path(made).resolve())
        for model in (HERE / "models").iterdir():
            shutil.copy(model, folder)
        c = client.Client(folder)
        for line in lines:
            shown.append(line)
            if line.startswith("$ "):
                command = line[2:].replace("bipc ", str(client.BIPC) + " ", 1)
                subprocess.run(command, shell=True, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            if not line.startswith((">", ">>")):
                continue
            waits = line.startswith("> ")
            command, _, arguments = line.lstrip(">").lstrip().partition(" ")
            sequence = c.send(command, json.loads(arguments.replace("$DIR", folder)) if arguments else None)
            is_answered = is_moved = False
            while not is_answered or not is_moved:
                message = c.receive()
                shown.append("< " + normal(message, folder))
                is_event = message["type"] == "event"
                if not is_event and message["request_seq"] == sequence:
                    is_answered = True
                    is_moved = not waits or command not in MOVES or not message["success"]
                    if command == "launch" and message["success"]:
                        is_moved = False
                if is_event and message["event"] in ("stopped", "terminated", "initialized"):
                    is_moved = True
        code = c.end()
    return shown, code


def check_sessions(only, update, report):
    passed = failed = 0
    for path in sorted((HERE / "sessions").glob("*.dap")):
        if only and not any(o in path.name for o in only):
            continue
        try:
            shown, code = play(path)
        except (client.Gone, OSError, KeyError, ValueError) as e:
            failed += 1
            report(f"{path.name}: {e}")
            continue
        text = "\n".join(shown) + "\n"
        if update:
            path.write_text(text, encoding="utf-8")
        wanted = path.read_text(encoding="utf-8")
        if text != wanted or code != 0:
            failed += 1
            got = text.splitlines()
            for k, line in enumerate(wanted.splitlines()):
                if k >= len(got) or got[k] != line:
                    report(f"{path.name}:{k + 1}: expected\n  {line}\ngot\n  {got[k] if k < len(got) else '(nothing)'}")
                    break
            else:
                report(f"{path.name}: exit code {code}")
        else:
            passed += 1
    return passed, failed


COMMANDS = ["initialize", "launch", "setBreakpoints", "setFunctionBreakpoints", "dataBreakpointInfo", "setDataBreakpoints", "setExceptionBreakpoints",
            "configurationDone", "threads", "stackTrace", "scopes", "variables", "setVariable", "evaluate", "next", "stepIn", "stepInTargets", "stepBack",
            "reverseContinue", "pause", "restart", "exceptionInfo", "completions", "", "x"]
KEYS = ["source", "path", "breakpoints", "line", "name", "condition", "hitCondition", "logMessage", "filters", "filterOptions", "filterId", "dataId",
        "frameId", "variablesReference", "start", "count", "value", "expression", "context", "targetId", "text", "column", "program", "args", "seed"]


def value(rng, depth=0):
    kind = rng.randrange(9 if depth < 3 else 6)
    if kind == 0:
        return rng.choice([-1, 0, 1, 2, 3, 1000, 1001, 2 ** 31, 2 ** 63, 2 ** 64 - 1, 1.5, 1e300])
    if kind in (1, 2):
        return rng.choice(["", "dine.bip", "a.b", "phil[0]@EATS", "phil[0].meals", "phil[0].meals > 1", "never phil[0]@EATS", "\u0000", "é𝄞", "x" * 400, "s 3", "b", "repl",
                           "99999999999999999999", "(" * 300])
    if kind == 3:
        return rng.choice([None, True, False, [], {}])
    if kind in (4, 5):
        return rng.randrange(40)
    if kind == 6:
        return [value(rng, depth + 1) for _ in range(rng.randrange(4))]
    return {rng.choice(KEYS): value(rng, depth + 1) for _ in range(rng.randrange(5))}


def malformed(count, seed, report):
    """The adapter answers each message, and is asked something sensible after each hundred."""
    rng = random.Random(seed)
    passed = failed = 0
    with tempfile.TemporaryDirectory() as folder:
        shutil.copy(HERE / "models" / "dine.bip", folder)
        c = client.Client(folder)
        c.send("initialize")
        c.send("launch", {"program": "dine.bip"})
        for batch in range(0, count, 100):
            for _ in range(100):
                message = {"seq": rng.choice([1, -1, "x", None]), "type": rng.choice(["request"] * 9 + ["event", 7]), "command": rng.choice(COMMANDS),
                           "arguments": {rng.choice(KEYS): value(rng) for _ in range(rng.randrange(6))} if rng.random() < 0.8 else value(rng)}
                body = json.dumps(message if rng.random() < 0.9 else value(rng)).encode("utf-8", "surrogatepass")
                if rng.random() < 0.1:
                    body = body[:rng.randrange(len(body) + 1)]
                c.raw(b"Content-Length: %d\r\n\r\n" % len(body) + body)
            body = b"[" * 50000
            c.raw(b"Content-Length: %d\r\n\r\n" % len(body) + body + b"Content-Length: x\r\n\r\n")
            try:
                sequence = c.send("threads")
                while True:
                    message = c.receive()
                    if message["type"] == "response" and message["command"] == "threads" and message["request_seq"] == c.sequence and message["success"]:
                        break
                passed += 1
            except (client.Gone, OSError) as e:
                failed += 1
                report(f"malformed messages, batch {batch}, seed {seed}: {e}, request {sequence}")
                return passed, failed
        c.send("disconnect")
        if c.process.wait(client.TIMEOUT) != 0:
            failed += 1
            report("the adapter did not end in order")
    return passed, failed


def main():
    update = "--update" in sys.argv
    only = [a for a in sys.argv[1:] if not a.startswith("--")]

    def report(text):
        print(f"FAILED {text[:2000]}", flush=True)

    passed, failed = check_sessions(only, update, report)
    if not only or "malformed" in only:
        good, bad = malformed(3000, 1, report)
        passed, failed = passed + good, failed + bad
    print(f"dap: {passed} passed, {failed} failed")
    return 1 if failed or not passed else 0


if __name__ == "__main__":
    sys.exit(main())
