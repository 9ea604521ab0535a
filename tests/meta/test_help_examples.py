#!/usr/bin/env python3
"""Each example of each command's --help is run, with files of the names that it uses.

    tests/meta/test_help_examples.py [COMMAND ...]

An example works if the shell ends with an exit code of an answer (0; 3, a violated property; 4, undecided) and no program said that
the command line is wrong or the model has errors. spin's part is left out where it is not installed. Python's library only.
"""
import os
import pathlib
import re
import shutil
import socket
import subprocess
import sys
import tempfile

import cli_docs

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BIPC = os.path.abspath(cli_docs.bipc())
ANSWERS = (0, 3, 4)
ENDS = {"bipc dap": 1}  # what its editor did not say
BRIDGES = ("bipc ros1 rover.gen --serve", "bipc ros2 rover.gen --serve")  # go on until they are ended: here after some seconds
SECONDS = 300
# The names that examples use: a ring or a table of philosophers, and a root that has some of them.
MODEL = """package model
  port type Signal()
  connector type Alone(Signal a) define a end
  connector type Two(Signal a, Signal b) define a b end
  atom type Fork()
    export port Signal take(), put()
    place FREE, USED
    initial to FREE
    on take from FREE to USED
    on put from USED to FREE
  end
  atom type Phil()
    export port Signal ask(), left(), right(), put_left(), put_right()
    place THINKS, HUNGRY, HAS_LEFT, EATS, LEAVES
    initial to THINKS
    on ask from THINKS to HUNGRY
    on left from HUNGRY to HAS_LEFT
    on right from HAS_LEFT to EATS
    on put_left from EATS to LEAVES
    on put_right from LEAVES to THINKS
  end
"""
COMPOUND = """  compound type {0}({1})
    component Phil phil[{2}]
    component Fork fork[{2}]
    for i in 0..{2} {{
      connector Alone ask[i](phil[i].ask)
      connector Two left[i](phil[i].left, fork[i].take)
      connector Two eat[i](phil[i].right, fork[(i + 1) % {2}].take)
      connector Two put_left[i](phil[i].put_left, fork[i].put)
      connector Two put_right[i](phil[i].put_right, fork[(i + 1) % {2}].put)
    }}
  end
"""
BIP1 = """model Relay
  port type Event
  atomic type Clock
    export port Event tick
    behavior
      initial to S
      state S
        on tick to S
    end
  end
  connector type One(Event e)
    define [e]
  end
  compound type Relay
    component Clock clock
    connector One one(clock.tick)
  end
  component Relay relay
end
"""
passed = failed = 0


def write_files(folder):
    model = MODEL + COMPOUND.format("Ring", "int n", "n") + COMPOUND.format("Table", "int n", "n") + COMPOUND.format("Root", "", "3") + "end\n"
    (folder / "model.bip").write_text(model, encoding="utf-8")
    (folder / "bip1.bip").write_text(BIP1, encoding="utf-8")
    for name in ("kitchen.bip", "arm.gen", "arm.rules"):
        shutil.copy(ROOT / "models/tutorial" / name, folder)
    shutil.copy(folder / "arm.gen", folder / "demo.gen")
    shutil.copy(folder / "arm.gen", folder / "rover.gen")
    (folder / "rover.rules").write_text((folder / "arm.rules").read_text(encoding="utf-8").replace("rules arm;", "rules rover;", 1), encoding="utf-8")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        (folder / "robot.place").write_text(f"node field host 127.0.0.1:{free.getsockname()[1]}\n* on field\n", encoding="utf-8")
    with open(folder / "run.txt", "w", encoding="utf-8") as trace:
        subprocess.run([BIPC, "run", "--limit", "5", "--seed", "1", "--trace-format", "bip2", "model.bip"], cwd=folder, stdout=trace, check=True)
    subprocess.run([BIPC, "run", "--silent", "--limit", "20", "--seed", "1", "--trace", "run.jsonl", "model.bip"], cwd=folder, stdout=subprocess.DEVNULL, check=True)


def examples(command):
    """The lines `  bipc …` behind `Example:`."""
    text = cli_docs.help_of(command)
    return re.findall(r"^  (bipc .*)$", text[text.index("Example:"):], re.M)


def run(line):
    """None, or why the example does not work."""
    if "spin " in line and not shutil.which("spin"):
        print(f"skipped: the part of `{line}` behind the export: there is no spin")
        line = line.split("&&")[0]
    is_bridge = line.startswith(BRIDGES)
    plugin, library = ("ros1", "roscpp") if line.startswith("bipc ros1") else ("dds", "Cyclone DDS")
    if is_bridge and not pathlib.Path(BIPC).with_name(f"libbipc_{plugin}.so").exists():
        print(f"skipped: `{line}`: {library} was not there when bipc was built")
        return None
    if is_bridge:
        line = "timeout -s TERM 3 " + line
    with tempfile.TemporaryDirectory() as work:
        folder = pathlib.Path(work)
        write_files(folder)
        (folder / "bin").mkdir()
        (folder / "bin/bipc").symlink_to(BIPC)
        environment = {**os.environ, "PATH": f"{folder / 'bin'}:{os.environ['PATH']}"}
        if line.startswith("bipc node"):
            subprocess.run([BIPC, "deploy", "--placement", "robot.place", "-o", "robot", "model.bip"], cwd=folder, stdout=subprocess.DEVNULL, check=True)
        # What a debugging session or an editor reads: nothing more.
        done = subprocess.run(["sh", "-c", line], cwd=folder, env=environment, capture_output=True, text=True, timeout=SECONDS, stdin=subprocess.DEVNULL)
    said = done.stdout[-1500:] + done.stderr[-1500:]
    if is_bridge and done.returncode == 124 and "ROS 2 domain" in said:
        return None
    # ROS 1 has a master, and the tests of help have none.
    if is_bridge and done.returncode == 2 and "no master of ROS" in said:
        return None
    if done.returncode not in ANSWERS and done.returncode != ENDS.get(line):
        return f"exit code {done.returncode}\n{said}"
    wrong = re.search(r"^bipc: (?!seed).*|error\[B\d{4}\].*", done.stdout + done.stderr, re.M)
    return f"{wrong.group(0)}\n{said}" if wrong else None


def main():
    global passed, failed
    for command in cli_docs.commands_of(cli_docs.help_of()):
        if sys.argv[1:] and command not in sys.argv[1:]:
            continue
        for line in examples(command):
            why = run(line)
            passed += why is None
            failed += why is not None
            if why:
                print(f"FAILED {line}\n{why}")
    print(f"help_examples: {passed} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
