"""The command `bipc` of a wheel: the program in the package's folder takes over the process."""
import os
import pathlib
import sys


def main():
    program = pathlib.Path(__file__).resolve().parent / "bin/bipc"
    if not program.exists():
        sys.exit("bipc: this Python package was installed without the program; Debian's package bipc has it")
    os.execv(program, ["bipc", *sys.argv[1:]])
