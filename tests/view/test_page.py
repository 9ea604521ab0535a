#!/usr/bin/env python3
"""Uses pages of `bipc view` in headless Chromium: keys, clicks, a deadlock walked back, the rover with its rules.

    tests/view/test_page.py [--update] [part of a case's name ...]

Needs a built bipc ($BIPC or build/bipc), chromium (Debian), node, and playwright-core of npm ($NODE_PATH, else the
global folder, has it): `tools/setup --browser` installs them. Without them the pages are only made, and the line
`skipped: ...` says what is missing. Screenshots are left in the build folder, in `pages/`. Parts of a page are compared
with the small pictures in `pictures/`, with a tolerance for other fonts; `--update` makes them anew: look at them.
"""
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
from html.parser import HTMLParser

from web_client import Model, Served

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
BUILD = pathlib.Path(os.environ.get("BIPC_BUILD_DIR") or ROOT / "build")
BIPC = os.environ.get("BIPC") or str(BUILD / "bipc")
MODELS = ROOT / "models"
DALA = MODELS / "dala"

# Parts of the page that are compared with golden pictures. Other fonts differ by 1.5, 3.8 and 7 at most, another state or panel by 7, 8 and 11 at least.
STRUCTURE = {"of": "#canvas", "golden": "deadlock_structure", "most": 4}
AUTOMATON = {"of": "#atom", "golden": "deadlock_automaton", "most": 5.5}
EXPLANATION = {"of": "#panel", "golden": "deadlock_explanation", "most": 8.5}

# (name, commands that make PAGE, what is done with it, ms until the first paint)
CASES = [
    ("philosophers_deadlock", ["verify --trace {dir}/dead.json {models}/classic/philosophers.bip", "view --trace {dir}/dead.json {models}/classic/philosophers.bip -o {page}"],
     [["deadlock"], ["walk"], ["measure"], ["key", "End"], ["key", "7"]], 2000),
    ("pictures", ["verify --trace {dir}/dead.json philosophers.bip", "view --trace {dir}/dead.json philosophers.bip -o {page}"],
     [["key", "End"], ["key", "7"], ["picture", STRUCTURE], ["picture", AUTOMATON], ["picture", EXPLANATION],
      ["style", "* { font-family: serif !important }"], ["picture", STRUCTURE], ["picture", AUTOMATON], ["picture", EXPLANATION],
      ["style", "#panel * { visibility: hidden }"], ["picture", STRUCTURE], ["otherPicture", EXPLANATION],
      ["style", ""], ["key", "1"], ["otherPicture", EXPLANATION], ["key", "7"], ["picture", EXPLANATION],
      ["key", "ArrowLeft"], ["otherPicture", STRUCTURE], ["key", "Home"], ["otherPicture", STRUCTURE], ["otherPicture", AUTOMATON]], 2000),
    ("philosophers_folded", ["view --root Table(1000) --steps 100 {models}/classic/philosophers.bip -o {page}"], [["walk"], ["measure"], ["key", "5"]], 2000),
    ("train_gate", ["view --steps 200 --seed 3 {models}/timed/train_gate.bip -o {page}"], [["walk"], ["plot"], ["measure"], ["key", "5"]], 2000),
    ("clocks", ["view --steps 60 --seed 3 {models}/timed/train_gate.bip -o {page}"], [["clocks"], ["key", "6"]], 2000),
    ("proof", ["verify --certificate {dir}/proof.cert {models}/classic/gas_station.bip", "view --certificate {dir}/proof.cert --steps 100 {models}/classic/gas_station.bip -o {page}"],
     [["proof"]], 2000),
    ("timed_proof", ["verify --certificate {dir}/timed.cert {models}/timed/train_gate.bip", "view --certificate {dir}/timed.cert --steps 100 --seed 3 {models}/timed/train_gate.bip -o {page}"],
     [["zones"]], 2000),
    ("long_run", ["view --steps 100000 --seed 3 {models}/classic/philosophers_safe.bip -o {page}"], [["scrub", 1000], ["stepList"], ["key", "5"]], 2000),
    ("long_timed_run", ["view --steps 50000 --seed 3 {models}/timed/train_gate.bip -o {page}"], [["scrub", 1000], ["key", "6"]], 2000),
    ("train_gate_dark", ["view --steps 60 --seed 3 {models}/timed/train_gate.bip -o {page}"], [["walk"], ["key", "4"]], 2000),
    ("tutorial_compounds", ["view --steps 50 {models}/tutorial/factory.bip -o {page}"], [["walk"], ["search", "worker"], ["levels"], ["measure"], ["key", "1"]], 2000),
    ("structure_alone", ["graph {models}/tutorial/factory.bip -o {page}"], [["search", "worker"], ["measure"]], 2000),
    ("dala", ["rules {rules}", "view --steps 300 {dir}/dala.bip -o {page}"], [["walk"], ["services"], ["search", "ndd"], ["levels"], ["key", "5"]], 2000),
]


# The same of live pages: (name, commands before, arguments of `view --port 0`, what is done with it, ms)
LIVE = [
    ("live_philosophers", ["verify --trace {dir}/live.json {models}/classic/philosophers.bip"], "--trace {dir}/live.json {models}/classic/philosophers.bip",
     [["walk"], ["key", "End"], ["anotherChoice"], ["measure"], ["drive"], ["key", "8"]], 2000),
    ("live_train_gate", [], "{models}/timed/train_gate.bip", [["timed"], ["key", "5"]], 2000),
    ("live_dala", ["rules {rules}"], "{dir}/dala.bip", [["steps"], ["search", "ndd"], ["key", "2"]], 2000),
]


# Pages of served models: (name, model, options of `bipc serve`, what is done with it, ms)
ATTACHED = [
    ("attached_philosophers", "classic/philosophers.bip", ["--paused"], [["attached"], ["measure"], ["key", "2"]], 2000),
    ("attached_train_gate", "timed/train_gate.bip", ["--speed", "10"], [["watched"], ["key", "5"]], 2000),
]


def run(arguments, **names):
    words = [word.format(**names) for word in arguments.split(" ")]
    if words[0] == "rules":
        words = ["rules", str(DALA / "dala.rules"), "--yields", str(DALA / "dala.yields"), "-o", f"{names['dir']}/dala.bip"]
    # Paths that pages show are relative where they must not depend on the machine.
    return words, subprocess.run([BIPC, *words], capture_output=True, text=True, timeout=300, cwd=names["dir"])


class Check(HTMLParser):
    """What can be said of a page without a browser: it asks for nothing, and its scripts are as many as ours."""

    def __init__(self, text, scripts):
        super().__init__()
        self.problems, self.scripts, self.data = [], 0, None
        self.is_data = False
        self.feed(text)
        if self.scripts != scripts:
            self.problems.append(f"{self.scripts} scripts instead of {scripts}: something in the model became markup")

    def handle_starttag(self, tag, attributes):
        self.scripts += tag == "script"
        self.is_data = ("id", "data") in attributes
        for key, value in attributes:
            if key in ("src", "href") or (value or "").startswith(("http:", "javascript:")) or key.startswith("on"):
                self.problems.append(f"<{tag} {key}={value}>" if key != "xmlns" else "")
        self.problems = [p for p in self.problems if p]

    def handle_data(self, text):
        if self.is_data and self.data is None:
            self.data = json.loads(text)


ODD = '''package odd
  port type Signal()
  atom type Lone()
    data string text = "</script><script>alert(1)</script><!--"
    export port Signal p()
    place HERE
    initial to HERE
    on p from HERE to HERE do { text = "<img src=x onerror=alert(1)>"; }
  end
  connector type One(Signal a) define a end
  compound type Root()
    component Lone a()
    connector One k(a.p)
  end
end
'''


def refused(folder):
    """Certificates that are none, or of another model."""
    problems = []
    safe, other = MODELS / "classic/philosophers_safe.bip", MODELS / "classic/atm.bip"
    subprocess.run([BIPC, "verify", "--certificate", str(folder / "other.cert"), str(other)], capture_output=True)
    text = (folder / "other.cert").read_text()
    for name, content, wanted in [("other", text, "no certificate of this model"), ("empty", "", "version 1"), ("later", "bipc-certificate 2\n", "version 1"), ("odd", "bipc-certificate 1\nfoo bar\n", "line 2: a row `foo`"),
                                  ("alone", "bipc-certificate 1\ntrap ROOT.nobody:0\n", "no component `nobody"), ("value", "bipc-certificate 1\nlemma ROOT.table.phil[0].weight=1\n", "no variable")]:
        (folder / f"{name}.cert").write_text(content)
        done = subprocess.run([BIPC, "view", "--certificate", str(folder / f"{name}.cert"), str(safe), "-o", str(folder / "x.html")], capture_output=True, text=True)
        if done.returncode != 2 or wanted not in done.stderr or (folder / "x.html").exists():
            problems.append(f"{name}: exit code {done.returncode}, {done.stderr.strip()}")
    done = subprocess.run([BIPC, "view", "--certificate", str(folder / "nowhere"), str(safe), "-o", str(folder / "x.html")], capture_output=True, text=True)
    if done.returncode != 1 or "error[B0090]" not in done.stderr:
        problems.append(f"no file: exit code {done.returncode}, {done.stderr.strip()}")
    return problems


def browser():
    """(chromium, environment), or the reason why there is none."""
    program = next((p for p in map(shutil.which, ("chromium", "chromium-browser", "google-chrome")) if p), None)
    if program is None:
        return None, "no chromium: pages are not opened (tools/setup --browser)"
    if shutil.which("node") is None:
        return None, "no node: pages are not opened"
    folder = os.environ.get("NODE_PATH") or subprocess.run(["npm", "root", "-g"], capture_output=True, text=True).stdout.strip()
    if not (pathlib.Path(folder.split(":")[0] or "/nowhere") / "playwright-core").exists():
        return None, "no playwright-core: pages are not opened (tools/setup --browser)"
    return program, {**os.environ, "NODE_PATH": folder}


def main():
    update = ["--update"] if "--update" in sys.argv else []
    wanted = [word for word in sys.argv[1:] if word != "--update"]
    passed, failed, cases = 0, 0, []
    screenshots = BUILD / "pages"
    screenshots.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        shutil.copy(MODELS / "classic/philosophers.bip", folder)
        odd = pathlib.Path(folder) / "odd.bip"
        odd.write_text(ODD, encoding="utf-8")
        made = [("odd", [f"view --steps 3 {odd} -o {{page}}"], [["walk"]], 2000)] + CASES
        for name, commands, steps, most in made:
            if wanted and not any(part in name for part in wanted):
                continue
            page = pathlib.Path(folder) / f"{name}.html"
            problems = []
            for command in commands:
                words, done = run(command, dir=folder, models=MODELS, page=page, rules=DALA)
                if done.returncode != (3 if words[:2] == ["verify", "--trace"] else 0):
                    problems.append(f"bipc {' '.join(words)}: exit code {done.returncode}\n{done.stderr[-400:]}")
            if page.exists():
                text = page.read_text(encoding="utf-8")
                problems += Check(text, 6 + ("--certificate" in commands[-1])).problems
                _, done = run(commands[-1], dir=folder, models=MODELS, page=page, rules=DALA)
                if page.read_text(encoding="utf-8") != text:
                    problems.append("the same run gives another page")
            elif not problems:
                problems.append("no page")
            passed, failed = (passed, failed + 1) if problems else (passed + 1, failed)
            for problem in problems:
                print(f"FAILED {name}: {problem}")
            cases.append({"name": name, "file": str(page), "dark": name.endswith("_dark"), "steps": steps, "most": most})
        if not wanted:
            problems = refused(pathlib.Path(folder))
            passed, failed = (passed, failed + 1) if problems else (passed + 1, failed)
            for problem in problems:
                print(f"FAILED certificates: {problem}")
        program, environment = browser()
        served = []
        for name, commands, arguments, steps, most in LIVE if program else []:
            if wanted and not any(part in name for part in wanted):
                continue
            for command in commands:
                run(command, dir=folder, models=MODELS, page=None, rules=DALA)
            served.append(Served(BIPC, *arguments.format(dir=folder, models=MODELS).split(" ")))
            cases.append({"name": name, "address": served[-1].address, "dark": False, "steps": steps, "most": most})
        models = []
        for name, model, options, steps, most in ATTACHED if program else []:
            if wanted and not any(part in name for part in wanted):
                continue
            models.append(Model(BIPC, MODELS / model, *options))
            served.append(Served(BIPC, "--attach", models[-1].where, MODELS / model))
            cases.append({"name": name, "address": served[-1].address, "dark": False, "steps": steps, "most": most})
        if program is None:
            print(f"skipped: {environment}")
        elif cases and not failed:
            listed = pathlib.Path(folder) / "cases.json"
            listed.write_text(json.dumps(cases), encoding="utf-8")
            done = subprocess.run(["node", str(HERE / "drive.mjs"), program, str(listed), str(screenshots), str(HERE / "pictures"), *update], env=environment, capture_output=True, text=True, timeout=600)
            lines = re.findall(r"^(ok|FAILED) .*", done.stdout, re.M)
            bad = sum(line == "FAILED" for line in lines) + (len(lines) != len(cases))
            print(done.stdout.rstrip() + done.stderr[-2000:])
            passed, failed = passed + sum(line == "ok" for line in lines), failed + bad
        for one in served:
            one.__exit__()
            passed, failed = (passed + 1, failed) if one.code == 0 else (passed, failed + 1)
        for model in models:
            model.__exit__()
    print(f"view: {passed} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
