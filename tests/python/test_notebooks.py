#!/usr/bin/env python3
"""The notebooks of models/notebooks run from their first cell to their last, and their last values show themselves.

By Jupyter where `jupyter-nbconvert` and `python3-ipykernel` are installed; else the cells are executed one after the other here, which is all
that a kernel does with them. BIPC_BUILD_DIR names the build.
"""
import ast
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BUILD = pathlib.Path(os.environ.get("BIPC_BUILD_DIR") or ROOT / "build")
FOLDER = ROOT / "models/notebooks"
PYTHON = "/usr/bin/python3"  # whose module was built


def execute(path):
    """Executes the code cells; of each the last expression is asked for its picture or text, as a kernel does."""
    names, shown = {}, []
    os.chdir(path.parent)
    for cell in json.loads(path.read_text())["cells"]:
        if cell["cell_type"] != "code":
            continue
        tree = ast.parse(cell["source"])
        last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
        exec(compile(tree, str(path), "exec"), names)
        if last is None:
            continue
        value = eval(compile(ast.Expression(last.value), str(path), "eval"), names)
        if value is not None:
            shown.append(value._repr_svg_() if hasattr(value, "_repr_svg_") else repr(value))
    assert sum(text.startswith("<svg") for text in shown) >= 3, [text[:60] for text in shown]


def has_jupyter():
    return shutil.which("jupyter-nbconvert") and subprocess.run([PYTHON, "-c", "import ipykernel"], capture_output=True).returncode == 0


def main():
    environment = {**os.environ, "PYTHONPATH": str(BUILD / "python")}
    if len(sys.argv) > 1:
        return execute(pathlib.Path(sys.argv[1]))
    if not any((BUILD / "python/bipc").glob("_bipc*.so")):
        print("notebooks: left out, the Python module was not built\n0 passed, 0 failed")
        return None
    passed = failed = 0
    for path in sorted(FOLDER.glob("*.ipynb")):
        assert not any(cell.get("outputs") for cell in json.loads(path.read_text())["cells"]), f"{path}: outputs are not committed"
        with tempfile.TemporaryDirectory() as folder:
            commands = [[PYTHON, __file__, str(path)]]
            if has_jupyter():
                commands.append(["jupyter-nbconvert", "--to", "notebook", "--execute", "--output-dir", folder, str(path)])
            for command in commands:
                done = subprocess.run(command, env=environment, capture_output=True, text=True)
                passed += done.returncode == 0
                failed += done.returncode != 0
                if done.returncode:
                    print(f"FAILED {path.name} by {command[0]}\n{done.stdout[-1500:]}{done.stderr[-3000:]}")
    print(f"notebooks: {passed} passed, {failed} failed")
    return failed != 0


if __name__ == "__main__":
    sys.exit(main())
