#!/usr/bin/env python3
"""Measures the pictures of `bipc graph` on every model that has a root.

    tests/graph/test_pictures.py [part of a model's path ...]

In each picture no two labels overlap, each label and each box is inside of the box around it, boxes beside each other do
not overlap, and no line of a connector crosses a box. Two runs give the same bytes. Widths of text are estimated here,
independently of bipc. `dot` of Graphviz draws what `--format dot` prints of the rover's modules; skipped, and said so, where it is not
installed. Needs python3 and a built bipc ($BIPC or build/bipc).
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as xml

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BIPC = os.environ.get("BIPC") or str(pathlib.Path(os.environ.get("BIPC_BUILD_DIR") or ROOT / "build") / "bipc")
SVG = "{http://www.w3.org/2000/svg}"
FRAMES = {"compound", "closed", "atom", "automaton", "state"}
SLACK = 0.2  # coordinates are rounded to a tenth
# Larger ones are drawn in part; the rest of the options differs so that each is measured.
OPTIONS = {"bench/": ["--fold", "3"], "classic/hierarchical": ["--depth", "1"], "tutorial/factory": ["--depth", "2"], "timed/train_gates": ["--fold", "0"]}


def width_of(text, size, bold):
    """What the text takes in Helvetica, roughly and rather less."""
    units = sum(0.25 if c in "iljtfI.,:;'!|()[] -" else 0.8 if c in "mwMW@%" else 0.6 if c.isupper() else 0.5 for c in text)
    return units * size * (1.05 if bold else 1)


class Box:
    def __init__(self, x, y, width, height, what):
        self.x0, self.y0, self.x1, self.y1, self.what = x, y, x + width, y + height, what

    def is_inside(self, other):
        return (self.x0 >= other.x0 - SLACK and self.y0 >= other.y0 - SLACK and self.x1 <= other.x1 + SLACK
                and self.y1 <= other.y1 + SLACK)

    def meets(self, other):
        return (self.x0 < other.x1 - SLACK and other.x0 < self.x1 - SLACK and self.y0 < other.y1 - SLACK
                and other.y0 < self.y1 - SLACK)


class Picture:
    """Boxes and labels of an SVG file, in its coordinates."""

    def __init__(self, text):
        self.labels, self.frames, self.lines, self.problems = [], [], [], []
        top = xml.fromstring(text)
        page = Box(0, 0, float(top.get("width")), float(top.get("height")), "the page")
        self.visit(top, 0, 0, page, None)

    def visit(self, element, dx, dy, around, bold):
        classes = (element.get("class") or "").split()
        moved = re.match(r"translate\((\S+) (\S+)\)", element.get("transform") or "")
        if moved:
            dx, dy = dx + float(moved[1]), dy + float(moved[2])
        own = around
        for child in element:
            tag = child.tag.removeprefix(SVG)
            kinds = (child.get("class") or "").split()
            if tag == "rect" and {"frame", "sheet", "place"} & set(kinds):
                own = Box(float(child.get("x")) + dx, float(child.get("y")) + dy, float(child.get("width")), float(child.get("height")),
                          element.get("data-path") or element.get("data-type") or element.get("data-name") or "a place")
                if not own.is_inside(around):
                    self.problems.append(f"{own.what} is not inside of {around.what}")
                self.frames.append((own, around, "compound" in classes))
            elif tag == "rect" and kinds and kinds[0] == "tab":
                tab = Box(float(child.get("x")) + dx, float(child.get("y")) + dy, float(child.get("width")), float(child.get("height")), "a port")
                if not tab.is_inside(own):
                    self.problems.append(f"a port of {own.what} is not inside of it")
            elif tag == "path" and "wire" in kinds:
                for x0, y0, x1, y1 in re.findall(r"M(\S+) (\S+?)L(\S+) (-?[\d.]+)", child.get("d")):
                    self.lines.append((min(float(x0), float(x1)) + dx, min(float(y0), float(y1)) + dy, max(float(x0), float(x1)) + dx,
                                       max(float(y0), float(y1)) + dy, around))
            elif tag == "text":
                self.add_label(child, dx, dy, own)
            elif tag == "g":
                self.visit(child, dx, dy, own, bold)

    def add_label(self, element, dx, dy, around):
        text, size = "".join(element.itertext()), float(element.get("font-size"))
        width = width_of(text, size, "bold" in (element.get("class") or ""))
        x = float(element.get("x")) + dx - (width / 2 if element.get("text-anchor") == "middle" else 0)
        label = Box(x, float(element.get("y")) + dy - 0.7 * size, width, 0.75 * size, f"`{text}`")
        if not label.is_inside(around):
            self.problems.append(f"{label.what} is not inside of {around.what}")
        self.labels.append(label)

    def measure(self):
        overlapping(self.labels, self.problems)
        siblings = {}
        for frame, around, _ in self.frames:
            siblings.setdefault(id(around), []).append(frame)
        for frames in siblings.values():
            overlapping(frames, self.problems)
        for x0, y0, x1, y1, around in self.lines:
            if not Box(x0, y0, x1 - x0, y1 - y0, "").is_inside(around):
                self.problems.append(f"a line leaves {around.what}")
            for frame in siblings.get(id(around), []):
                if x0 < frame.x1 - 1 and x1 > frame.x0 + 1 and y0 < frame.y1 - 1 and y1 > frame.y0 + 1:
                    self.problems.append(f"a line crosses {frame.what}")
        return self.problems


def overlapping(boxes, problems):
    """Sorted by the left edge: each is compared with those that begin before it ends."""
    boxes = sorted(boxes, key=lambda b: b.x0)
    open_boxes = []
    for box in boxes:
        open_boxes = [b for b in open_boxes if b.x1 > box.x0]
        problems += [f"{b.what} overlaps {box.what}" for b in open_boxes if b.meets(box)]
        open_boxes.append(box)


def draw(path, options):
    done = subprocess.run([BIPC, "graph", str(path), "--format", "svg", *options], capture_output=True, timeout=120)
    return done.returncode, done.stdout.decode("utf-8"), done.stderr.decode("utf-8", "replace")


def generated(folder):
    """Systems that people do not write: the rover's modules, and one of them by itself."""
    dala = ROOT / "models/dala"
    for name, modules in (("ndd", [dala / "ndd.gen"]), ("dala", sorted(dala.glob("*.gen")))):
        target = pathlib.Path(folder) / f"{name}.bip"
        extra = ["--yields", str(dala / "dala.yields")] if name == "dala" else []
        subprocess.run([BIPC, "genom", *map(str, modules), *extra, "-o", str(target)], check=True, capture_output=True)
        yield target, ["--depth", "1", "--show", "structure"] if name == "dala" else []


def drawn_by_graphviz(folder):
    """Of each module of the rover: what `dot` says that it should not; and how many it has drawn."""
    dala = ROOT / "models/dala"
    problems, drawn = [], 0
    for modules in ([gen] for gen in sorted(dala.glob("*.gen"))):
        target = pathlib.Path(folder) / f"{modules[0].stem}.bip"
        subprocess.run([BIPC, "genom", *map(str, modules), "-o", str(target)], check=True, capture_output=True)
        printed = subprocess.run([BIPC, "graph", str(target), "--format", "dot"], check=True, capture_output=True).stdout
        done = subprocess.run(["dot", "-Tsvg"], input=printed, capture_output=True, timeout=120)
        drawn += 1
        if done.returncode != 0 or b"Error" in done.stderr:
            problems.append(f"{target.name}: dot ends with {done.returncode}: {done.stderr.decode('utf-8', 'replace')[:300]}")
        names = {e.text for e in xml.fromstring(done.stdout).iter("{http://www.w3.org/2000/svg}text")} if done.returncode == 0 else set()
        priorities = {name.split("\\n")[0] for name in re.findall(r'style=dashed, arrowhead=empty, [^\]]*label="([^"]*)"', printed.decode("utf-8"))} - {""}
        if done.returncode == 0 and not priorities <= names:
            problems.append(f"{target.name}: dot draws no name of {sorted(priorities - names)[:3]}")
    printed = subprocess.run([BIPC, "graph", str(dala / "dala.rules"), "--show", "modules", "--format", "dot"], check=True, capture_output=True).stdout
    done = subprocess.run(["dot", "-Tsvg"], input=printed, capture_output=True, timeout=120)
    drawn += 1
    # A port of a record that there is not is a warning.
    if done.returncode != 0 or done.stderr:
        problems.append(f"dala.rules: dot ends with {done.returncode}: {done.stderr.decode('utf-8', 'replace')[:300]}")
    return problems, drawn


ODD = '''package odd
  port type Signal()
  connector type Two(Signal a, Signal b) define a' b on a provided ("<b>&\\"x\\"" != "") end
  atom type Lone()
    data string text = "<script>&amp;]]>"
    export port Signal p()
    place HERE
    initial to HERE
    on p from HERE to HERE provided (text != "\\"'<&>") do { text = "a & b < c"; }
  end
  compound type Root()
    component Lone a()
    component Lone b()
    connector Two k(a.p, b.p)
  end
end
'''


def main():
    wanted = sys.argv[1:]
    passed, failed = 0, 0
    with tempfile.TemporaryDirectory() as folder:
        odd = pathlib.Path(folder) / "odd.bip"
        odd.write_text(ODD, encoding="utf-8")
        models = [(p, next((o for part, o in OPTIONS.items() if part in str(p)), [])) for p in sorted((ROOT / "models").rglob("*.bip"))]
        models += [(odd, []), *generated(folder), (ROOT / "models/dala/dala.rules", ["--show", "modules"])]
        for path, options in models:
            name = str(path.relative_to(ROOT)) if path.is_relative_to(ROOT) else path.name
            if wanted and not any(part in name for part in wanted):
                continue
            code, text, error = draw(path, options)
            if code != 0 and "B4003" in error:
                continue  # no root
            problems = [f"exit code {code}: {error}"] if code != 0 else Picture(text).measure()
            if code == 0 and draw(path, options)[1] != text:
                problems.append("a second run draws something else")
            if code == 0 and not Picture(text).labels:
                problems.append("the picture has no label")
            passed, failed = (passed, failed + 1) if problems else (passed + 1, failed)
            for problem in problems[:8]:
                print(f"{name}: {problem}")
        if not wanted or "dot" in wanted:
            if shutil.which("dot"):
                problems, drawn = drawn_by_graphviz(folder)
                passed, failed = passed + drawn - len(problems), failed + len(problems)
                for problem in problems:
                    print(problem)
            else:
                print("skipped: `dot` of Graphviz is not installed, so it has drawn nothing (tools/setup --test installs it)")
    print(f"pictures: {passed} passed, {failed} failed")
    return 1 if failed or (not wanted and passed < 30) else 0


if __name__ == "__main__":
    sys.exit(main())
