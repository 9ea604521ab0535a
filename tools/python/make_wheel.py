#!/usr/bin/env python3
"""Makes a wheel of the Python package `bipc` with all that it needs: the compiler's library, the JIT, the standard library, the program `bipc`.

    tools/python/make_wheel.py BUILD_DIRECTORY OUTPUT_FOLDER

Installs the build (cmake --install) into a temporary folder and packs it as PEP 427 says. In the wheel the folder bipc/ is at once the Python
package and a prefix like /usr: bin/, lib/, lib/bipc/, share/bipc/. Shared libraries that a `manylinux` system need not have (PEP 600) are put into
lib/. The platform tag is the C library's newest version that any of the files asks for. Prints the wheel's path.
"""
import base64
import hashlib
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import zipfile

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
# Of the libraries that PEP 600 allows to be outside, those that occur here.
OF_THE_SYSTEM = re.compile(r"(linux-vdso|ld-linux.*|libc|libm|libdl|librt|libpthread|libstdc\+\+|libgcc_s)\.so")

# Debian packages whose code is compiled into ours: their terms go with it.
COMPILED_IN = ("llvm-19-dev", "libcadical-dev", "libantlr4-runtime-dev", "libcli11-dev", "libasio-dev", "libboost-dev", "nlohmann-json3-dev", "pybind11-dev")

METADATA = """Metadata-Version: 2.1
Name: bipc
Version: {version}
Summary: compiler, runtime and verifier for BIP models
License: Apache-2.0 WITH LLVM-exception
Requires-Python: >=3.{minor}
Provides-Extra: tables
Requires-Dist: numpy; extra == "tables"
Requires-Dist: pandas; extra == "tables"
Description-Content-Type: text/markdown

"""


def install(build, stage):
    for component in ("bipc", "libs", "compiler", "python"):
        subprocess.run(["cmake", "--install", str(build), "--prefix", str(stage), "--component", component, "--strip"], check=True, stdout=subprocess.DEVNULL)


def lay_out(stage, package):
    """From an installation to the package's folder."""
    module = next(stage.glob("lib/python3*/**/_bipc*.so"))
    shutil.copytree(module.parent, package)
    shutil.copytree(stage / "bin", package / "bin")
    shutil.copytree(stage / "lib/bipc", package / "lib/bipc")
    shutil.copytree(stage / "share/bipc", package / "share/bipc")
    for name in ("libbip_compiler.so.0", "libbip_runtime.so.0"):
        shutil.copy(next(stage.glob(f"lib*/**/{name}")), package / "lib" / name)  # A wheel has no symbolic links: the library goes by its soname.
    return package / module.name


def bundle(files, library_folder, licences):
    """Copies what `files` link and a system need not have, each library with the terms of its Debian package."""
    environment = {**os.environ, "LD_LIBRARY_PATH": str(library_folder)}
    licences.mkdir()
    for file in files:
        listed = subprocess.run(["ldd", str(file)], capture_output=True, text=True, check=True, env=environment).stdout
        for name, path in re.findall(r"^\s*(\S+) => (/\S+)", listed, re.M):
            if not OF_THE_SYSTEM.match(name) and not (library_folder / name).exists():
                shutil.copy(os.path.realpath(path), library_folder / name)
                shutil.copy(f"/usr/share/doc/{debian_package(path)}/copyright", licences / name)


def debian_package(path):
    """Which package a library is of. dpkg may know it below /usr or, as before the two were joined, below /."""
    real = os.path.realpath(path)
    for candidate in (real, real.removeprefix("/usr")):
        found = subprocess.run(["dpkg", "-S", candidate], capture_output=True, text=True, check=False)
        if found.returncode == 0:
            return found.stdout.split(":")[0]
    sys.exit(f"make_wheel: {path} is of no Debian package, so its licence is not known")


def c_library(files):
    """The newest version of glibc whose symbols occur: (2, 36)."""
    versions = set()
    for file in files:
        symbols = subprocess.run(["objdump", "-T", str(file)], capture_output=True, text=True, check=True).stdout
        versions |= {tuple(map(int, version.split("."))) for version in re.findall(r"GLIBC_(\d+\.\d+)", symbols)}
    return max(versions)


def is_elf(path):
    with open(path, "rb") as file:
        return file.read(4) == b"\x7fELF"


def write_wheel(stage, wheel):
    """Zips the folder and its RECORD, the same bytes for the same files."""
    record = next(stage.glob("*.dist-info")) / "RECORD"
    lines = []
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in sorted(p for p in stage.rglob("*") if p.is_file()):
            data, name = path.read_bytes(), path.relative_to(stage).as_posix()
            digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
            lines.append(f"{name},sha256={digest},{len(data)}\n")
            entry = zipfile.ZipInfo(name)  # 1980-01-01
            entry.external_attr = ((0o100755 if os.access(path, os.X_OK) else 0o100644) << 16)
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, data)
        archive.writestr(zipfile.ZipInfo(record.relative_to(stage).as_posix()), "".join(lines) + f"{record.relative_to(stage)},,\n")


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__.split("\n\n")[1].strip())
    build, output = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2])
    version = re.search(r"^project\(bipc VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8"), re.M).group(1)
    with tempfile.TemporaryDirectory() as work:
        stage, installed = pathlib.Path(work) / "wheel", pathlib.Path(work) / "installed"
        stage.mkdir()
        install(build, installed)
        module = lay_out(installed, stage / "bipc")
        programs = [p for p in sorted((stage / "bipc").rglob("*")) if p.is_file() and not p.suffix == ".a" and is_elf(p)]
        facts = stage / f"bipc-{version}.dist-info"
        facts.mkdir()
        bundle(programs, stage / "bipc/lib", facts / "licenses")
        for name in COMPILED_IN:
            shutil.copy(f"/usr/share/doc/{name}/copyright", facts / "licenses" / name)
        tag_of_python = "cp" + re.search(r"cpython-(\d+)", module.name).group(1)
        machine = os.uname().machine
        major, minor = c_library([*programs, *(stage / "bipc/lib").glob("*.so*")])
        tag = f"{tag_of_python}-{tag_of_python}-manylinux_{major}_{minor}_{machine}"
        (facts / "METADATA").write_text(METADATA.format(version=version, minor=tag_of_python[3:]) + (ROOT / "compiler/docs/python.md").read_text(encoding="utf-8"), encoding="utf-8")
        (facts / "WHEEL").write_text(f"Wheel-Version: 1.0\nGenerator: make_wheel\nRoot-Is-Purelib: false\nTag: {tag}\n", encoding="utf-8")
        (facts / "entry_points.txt").write_text("[console_scripts]\nbipc = bipc.program:main\n", encoding="utf-8")
        shutil.copy(ROOT / "LICENSE", facts / "LICENSE")
        output.mkdir(parents=True, exist_ok=True)
        wheel = output / f"bipc-{version}-{tag}.whl"
        write_wheel(stage, wheel)
        print(wheel)


if __name__ == "__main__":
    main()
