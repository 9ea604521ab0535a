"""Certificates of `bipc verify`, given to certcheck: what tests of models and documents share. Python's library only."""
import json
import pathlib
import subprocess
import tempfile

COMPILE_OPTIONS = ("--root", "-I")
# Documented reasons for which there is no certificate (B1900; compiler/docs/verification.md, compiler/diag/explain). All others are failures.
WITHOUT_CERTIFICATE = ("whose zones are too many for --timeout and --memory", "guards of connectors or priorities that end in an error",
                       "a certificate for a model with time and priorities below connectors",
                       "a certificate for a model with time and data of a type other than", "`resume`, of a property with `can`",
                       "a certificate for a property of runs of a model with floats", "a certificate for a property that a run shows", "a certificate for a property of runs without a limit for a model with time",
                       "a certificate for an invariant that looks back, of a model with time")
# Documented reasons for which certcheck cannot check one.
NOT_CHECKABLE = ("the evidence is a search of all states", "C++ functions get references to variables")
passed_over = []  # (arguments, reason) of proofs whose certificates were not checked, in the order in which they were met


def print_passed_over():
    """One line for each proof that has no certificate to be checked, with the reason."""
    for arguments, reason in sorted(set(passed_over)):
        print(f"no certificate checked: bipc verify {arguments}: {reason}", flush=True)


def compile_arguments(arguments):
    """The arguments of `bipc verify` that `bipc check` takes, too: the file, its root and its packages."""
    kept, it = [], iter(arguments)
    for argument in it:
        if argument in COMPILE_OPTIONS:
            kept += [argument, next(it, "")]
        elif argument in ("--property", "--timeout", "--memory", "--backend", "--cache", "--fair", "--for-all"):
            next(it, None)
        elif not argument.startswith("-") or argument.startswith(COMPILE_OPTIONS):
            kept.append(argument)
    return kept


def shown(arguments):
    """The arguments as they are told, without the folders of the checkout."""
    root = str(pathlib.Path(__file__).resolve().parent.parent) + "/"
    return " ".join(argument.replace(root, "") for argument in arguments)


def problem_of_certificate(bipc, certcheck, arguments, cwd=None, timeout=600):
    """Asks once more with --certificate, and certcheck about that. None if it is accepted, the property does not hold, or there is no certificate that can be
    checked for a documented reason (then the proof is in passed_over, too); else what is wrong."""
    if any(a in ("--certificate", "--help") for a in arguments):
        return None
    with tempfile.TemporaryDirectory(prefix="certificates-") as work:
        system, certificate = pathlib.Path(work) / "system.bsys", pathlib.Path(work) / "certificate"
        run = {"cwd": cwd, "capture_output": True, "text": True, "errors": "replace", "stdin": subprocess.DEVNULL, "timeout": timeout}
        asked = subprocess.run([bipc, "verify", "--no-reuse", "--certificate", str(certificate), *arguments], **run)
        if asked.returncode == 2 and "is of one answer" in asked.stderr:
            # The model states properties as well.
            answers = json.loads(subprocess.run([bipc, "verify", "--no-reuse", "--json", *arguments], **run).stdout)["verdicts"]
            names = [answer["name"] for answer in answers if answer["verdict"] in ("holds", "deadlock-free")]
            problems = [problem_of_certificate(bipc, certcheck, [*arguments, "--property", name], cwd, timeout) for name in names]
            return next((f"{name}: {problem}" for name, problem in zip(names, problems) if problem), None)
        # 3: it does not hold; 4: nothing is known.
        if asked.returncode in (3, 4):
            return None
        refused = next((reason for reason in WITHOUT_CERTIFICATE if asked.returncode == 1 and reason in asked.stderr), None)
        if refused:
            passed_over.append((shown(arguments), refused))
            return None
        if asked.returncode != 0 or not certificate.exists():
            return f"no certificate, exit code {asked.returncode}: {(asked.stdout + asked.stderr).strip()[-500:]}"
        sizes = [*arguments[arguments.index("--for-all"):][:2]] if "--for-all" in arguments else None
        made = subprocess.run([bipc, *(["verify", *sizes] if sizes else ["check"]), "--emit=system", *compile_arguments(arguments)], **run)
        system.write_text(made.stdout, encoding="utf-8")
        try:
            done = subprocess.run([certcheck, str(system), str(certificate)], **run)
        except subprocess.TimeoutExpired:
            return f"certcheck does not end within {timeout} s"
    if done.returncode == 0:
        return None
    # "not checkable" is an answer, of these certificates: only another search can check them.
    if reason := next((reason for reason in NOT_CHECKABLE if done.returncode == 4 and reason in done.stdout), None):
        passed_over.append((shown(arguments), reason))
        return None
    return f"the certificate is not accepted: {(done.stdout + done.stderr).strip()}"
