"""The inputs that libFuzzer learnt: one archive per target, tests/fuzz/corpus/TARGET.tar.xz, made the same for the same inputs."""
import io
import pathlib
import tarfile

CORPUS = pathlib.Path(__file__).resolve().parent / "corpus"


def unpack(target, folder):
    """Writes the target's inputs into the folder; returns their paths, sorted. None if there is no archive."""
    archive = CORPUS / f"{target}.tar.xz"
    if not archive.exists():
        return []
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    with tarfile.open(archive, "r:xz") as tar:
        for member in tar.getmembers():
            if not member.isfile() or "/" in member.name:
                raise ValueError(f"{archive}: {member.name} is no plain file")
            (folder / member.name).write_bytes(tar.extractfile(member).read())
            paths.append(folder / member.name)
    return sorted(paths)


def pack(target, inputs):
    """inputs: name -> bytes."""
    CORPUS.mkdir(exist_ok=True)
    with tarfile.open(CORPUS / f"{target}.tar.xz", "w:xz", format=tarfile.USTAR_FORMAT) as tar:
        for name in sorted(inputs):
            info = tarfile.TarInfo(name)
            info.size = len(inputs[name])
            tar.addfile(info, io.BytesIO(inputs[name]))
