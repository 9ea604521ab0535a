"""BIP models in Python: compile, check, run, explore, verify, draw.

    import bipc
    model = bipc.load("philosophers.bip", root="Table(5)")
    system = model.start(seed=42)
    trace = system.trace(100)
    verdict = model.verify("errors")

What is wrong with a model comes as `CompileError`, whose `diagnostics` are objects. Work is done without the GIL, and
Ctrl-C ends it. numpy and pandas are used where they are installed, and not needed. compiler/docs/python.md has examples.
"""
import html
import os

from . import _bipc
from ._bipc import Counterexample, CounterexampleStep, Diagnostic, Estimate, Exploration, Snapshot, Verdict, __version__

__all__ = ["BipError", "CompileError", "Counterexample", "CounterexampleStep", "Diagnostic", "Estimate", "Exploration", "Model", "Runs", "Snapshot", "Step",
           "System", "Trace", "Verdict", "check", "explore", "graph", "load", "simulate", "verify", "__version__"]

_SHOWN = 200  # rows of a table, interactions of a timeline


class BipError(Exception):
    """What this package raises on its own."""


class CompileError(BipError):
    """A model has errors. `diagnostics`: all of them, with warnings; `text`: as `bipc` prints them."""

    def __init__(self, diagnostics, text):
        errors = [d for d in diagnostics if d.severity == "error"]
        first = errors[0] if errors else None
        more = f" (and {len(errors) - 1} more)" if len(errors) > 1 else ""
        super().__init__(f"{first!r}{more}" if first else "the model does not compile")
        self.diagnostics = diagnostics
        self.text = text


def _raise_compile_error(diagnostics, text):
    raise CompileError(diagnostics, text)


def _source(model):
    """(text, path, is text): a path is an os.PathLike, or a text of one line that does not begin a package."""
    if isinstance(model, os.PathLike):
        return "", os.fspath(model), False
    if "\n" in model or model.lstrip().startswith(("package ", "@")):
        return model, "model.bip", True
    return "", model, False


def load(model, root="", *, folders=(), backend="auto", allow_cpp=True, cache=True, max_instances=0):
    """Compiles a model, given as a path or as a text, and returns a `Model`.

    root: "Ring(10)"; empty: the parameterless compound that no other one instantiates. folders: where packages are looked for first. backend: "auto",
    "jit" or "interp". allow_cpp: the model's C++ may be compiled and loaded. cache: machine code and proofs are kept for the next time. Raises CompileError.
    """
    text, path, is_text = _source(model)
    compiled, diagnostics, said = _bipc._compile(text, path, is_text, root, [os.fspath(f) for f in folders], backend, allow_cpp, cache, max_instances)
    if compiled is None:
        raise CompileError(diagnostics, said)
    return Model(compiled, diagnostics)


def check(model, root="", *, folders=()):
    """Checks a model as `bipc check` does: a file of types without a root is fine. Returns the warnings; raises CompileError."""
    text, path, is_text = _source(model)
    has_errors, diagnostics, said = _bipc._check(text, path, is_text, root, [os.fspath(f) for f in folders])
    if has_errors:
        raise CompileError(diagnostics, said)
    return diagnostics


def _as_model(model, root):
    return model if isinstance(model, Model) else load(model, root)


def explore(model, root="", **options):
    """`Model.explore` of a model, a path or a text."""
    return _as_model(model, root).explore(**options)


def verify(model, property="", root="", **options):
    """`Model.verify` of a model, a path or a text."""
    return _as_model(model, root).verify(property, **options)


def graph(model, root="", format="dot", part="all"):
    """`Model.graph` of a model, a path or a text."""
    return _as_model(model, root).graph(format, part)


def simulate(model, runs=1000, steps=1000, root="", **options):
    """`Model.simulate` of a model, a path or a text."""
    return _as_model(model, root).simulate(runs, steps, **options)


class Model:
    """A compiled model. Several threads may use it, one at a time."""

    def __init__(self, compiled, diagnostics):
        self._model = compiled
        self.warnings = diagnostics

    root = property(lambda self: self._model.root, doc='The root with its arguments, "Table(5)".')
    path = property(lambda self: self._model.path, doc="The file, or `model.bip` for a text.")
    components = property(lambda self: self._model.components, doc='The paths of all components, "ROOT.phil[0]".')
    system_text = property(lambda self: self._model.system_text, doc="The system as .bsys, which certcheck reads beside a certificate.")

    def variables(self, component):
        """The paths of the variables of a component."""
        return self._model.variables(component)

    def start(self, seed=0, policy="uniform", *, maximal_progress=True, asap=False, speed=0.0, strict=False):
        """Starts a run and returns a `System`.

        policy: as --policy of `bipc run`. speed: seconds of model time a second of the wall clock; 0: time passes without waiting.
        """
        return System(self, self._model._start(seed, policy, maximal_progress, asap, speed, strict))

    def simulate(self, runs=1000, steps=1000, *, seed=0, observe=(), until=None, stop="", policy="uniform", asap=False, threads=0):
        """Makes runs of at most `steps` steps as `bipc simulate` does, the first with `seed`, each later one with the next, and returns `Runs`.

        observe: what is measured of each run, "count NAME", "reaches EXPR", "time until EXPR", "duration of EXPR", "max EXPR", "min EXPR", "mean EXPR" or
        "last EXPR". until: instant in ns at which a run ends, in a model with clocks. stop: a run ends in the first state in which this condition holds.
        threads: 0 means all processors; the results are the same. Raises ValueError for an observer or a condition that says nothing of this model.
        """
        ends, taken, times, values, estimates, error = self._model._simulate(runs, seed, steps, -1 if until is None else until, stop, list(observe), policy,
                                                                             asap, threads)
        return Runs(range(seed, seed + runs), taken, ends, times, dict(zip(observe, values)), dict(zip(observe, estimates)), error)

    def explore(self, *, max_states=2**64 - 1, seconds=0.0, megabytes=0, threads=0, reduction="none", maximal_progress=True, trust_cpp=False):
        """Visits all reachable states, of a model with clocks all zones, and returns an `Exploration`."""
        return self._model._explore(max_states, seconds, megabytes, threads, reduction, maximal_progress, trust_cpp)

    def verify(self, property="", *, partial=False, timeout=60.0, wall_timeout=0.0, megabytes=2048, certificate=False, explain=False, fair="none"):
        """Decides a property: "" (deadlock-freedom), "errors", "never EXPR", "always EXPR", or of runs: "eventually EXPR", "EXPR leads to EXPR" and the like, or
        of what is possible: "possibly EXPR", "always possibly EXPR". `counterexample` of one that holds and begins with `possibly` is the run that shows it.
        Returns a `Verdict`; raises ValueError if it is none. fair: the runs that count for a property of runs, as `--fair` has it: "none" (all), "weak",
        "strong:atoms", "weak,strong:p.enter"; `counterexample.cycle` is the number of the first step that repeats for ever.

        timeout: seconds of the processor; wall_timeout: of wall-clock time, 0 means no limit. certificate: `Verdict.certificate` is a text for certcheck. explain: the invariants are part of `text`.
        """
        return self._model._verify(property, partial, timeout, wall_timeout, megabytes, certificate, explain, fair)

    def graph(self, format="dot", part="all"):
        """The system as "svg", "dot" or "json"; part: "all", "structure" (components and connectors) or "automata"."""
        return self._model._graph(format, part)

    def svg(self, part="all"):
        """The picture of `bipc graph -o x.svg`."""
        return self.graph("svg", part)

    def _repr_svg_(self):
        return self.svg()

    def __repr__(self):
        return f"<bipc.Model {self.root} of {self.path}, {len(self.components)} components>"


class System:
    """A run of a model."""

    def __init__(self, model, started):
        self.model = model
        self._system = started
        # The calls of a loop over single steps: as few layers as can be.
        self.step = started.step
        self.run = started.run
        self.candidates = started.candidates
        self.place = started.place
        self.read = started.read
        self.snapshot = started.snapshot
        self.restore = started.restore
        self.post = started.post
        self.stop = started.stop
        self.go_on = started.go_on

    outcome = property(lambda self: self._system.outcome, doc='How the last call ended: "stepped", "deadlock", "final", "fault" or "stopped".')
    steps = property(lambda self: self._system.steps, doc="The number of steps since the start.")
    now = property(lambda self: self._system.now, doc="The model's instant in ns; 0 in a model without clocks.")
    fault = property(lambda self: self._system.fault, doc="The text of the run-time error, or an empty text.")
    story = property(lambda self: self._system.story, doc="Who waits for whom, if the state is a deadlock.")

    def fire(self, candidate):
        """Takes a candidate, by its number or its name, and returns the outcome. Raises ValueError if there is none of this name."""
        if isinstance(candidate, str):
            names = self.candidates()
            if candidate not in names:
                raise ValueError(f"`{candidate}` is no candidate; there are {', '.join(names) or 'none'}")
            candidate = names.index(candidate)
        return self._system._fire(candidate)

    def trace(self, steps, *, values=False):
        """Takes up to `steps` steps and returns them as a `Trace`. values: with the values of the ports' variables."""
        return Trace(*self._system._record(steps, values))

    def __repr__(self):
        return f"<bipc.System {self.model.root}, {self.steps} steps, {self.outcome}>"


class Step:
    """A step of a trace: `number`, `time` in ns, `interaction`, `values` by "ROOT.a.port.variable"."""

    __slots__ = ("number", "time", "interaction", "values")

    def __init__(self, number, time, interaction, values):
        self.number, self.time, self.interaction, self.values = number, time, interaction, values

    def __repr__(self):
        return f"<{self.number}: {self.interaction}>"


class Trace:
    """Steps that were taken, in columns. A sequence of `Step`."""

    def __init__(self, first, names, interactions, times, values):
        self.first = first
        self.names = names  # of interactions, in the order in which they came first
        self.interactions = interactions  # a row of `names` a step
        self.times = times
        self._values = {}
        for row, variable, value in values:
            self._values.setdefault(row, {})[variable] = value

    def __len__(self):
        return len(self.interactions)

    def __getitem__(self, row):
        if isinstance(row, slice):
            return [self[k] for k in range(*row.indices(len(self)))]
        if row < 0:
            row += len(self)
        if not 0 <= row < len(self):
            raise IndexError(row)
        return Step(self.first + row, self.times[row], self.names[self.interactions[row]], self._values.get(row, {}))

    def to_numpy(self):
        """A structured array with `number`, `time` and `interaction`, a row of `names`. Needs numpy."""
        import numpy
        rows = numpy.empty(len(self), dtype=[("number", "u8"), ("time", "i8"), ("interaction", "u4")])
        rows["number"] = numpy.arange(self.first, self.first + len(self))
        rows["time"] = self.times
        rows["interaction"] = self.interactions
        return rows

    def to_pandas(self):
        """A DataFrame with a row a step; the values of variables are columns. Needs pandas."""
        import pandas
        frame = pandas.DataFrame({"time": self.times, "interaction": pandas.Categorical.from_codes(self.interactions, self.names)})
        frame.index = pandas.RangeIndex(self.first, self.first + len(self), name="number")
        if self._values:
            frame = frame.join(pandas.DataFrame([self._values.get(k, {}) for k in range(len(self))], index=frame.index))
        return frame

    def timeline(self):
        """A picture: a line an interaction, a mark a step; over time if the model has clocks."""
        return Timeline(self)

    def _repr_html_(self):
        rows = "".join(f"<tr><td>{s.number}</td><td>{s.time}</td><td><code>{html.escape(s.interaction)}</code></td>"
                       f"<td>{html.escape(', '.join(f'{k} = {v}' for k, v in s.values.items()))}</td></tr>" for s in self[:_SHOWN])
        more = f"<p>… and {len(self) - _SHOWN} more</p>" if len(self) > _SHOWN else ""
        return f"<table><tr><th>step</th><th>time (ns)</th><th>interaction</th><th>values</th></tr>{rows}</table>{more}"

    def __repr__(self):
        return f"<bipc.Trace of {len(self)} steps, {len(self.names)} interactions>"


class Timeline:
    """A trace as SVG."""

    def __init__(self, trace):
        self._trace = trace

    def _repr_svg_(self):
        trace, names = self._trace, self._trace.names[:_SHOWN]
        left, width, line = 8 * max((len(name) for name in names), default=0) + 12, 700, 18
        at = trace.times if any(trace.times) else range(len(trace))
        begin, end = (at[0], max(at[-1], at[0] + 1)) if len(trace) else (0, 1)
        rows = "".join(f'<text x="4" y="{line * k + 14}">{html.escape(name)}</text><line x1="{left}" x2="{left + width}" y1="{line * k + 9}" '
                       f'y2="{line * k + 9}" stroke="#ddd"/>' for k, name in enumerate(names))
        marks = "".join(f'<rect x="{left + (at[k] - begin) * width / (end - begin) - 1:.1f}" y="{line * row + 3}" width="2" height="12"/>'
                        for k, row in enumerate(trace.interactions) if row < len(names))
        return (f'<svg xmlns="http://www.w3.org/2000/svg" width="{left + width + 8}" height="{line * len(names) + 4}" font-family="monospace" '
                f'font-size="12">{rows}<g fill="#06c">{marks}</g></svg>')


class Runs:
    """What `Model.simulate` returns, by run: `seeds`, `steps` taken, `ends` ("limit", "deadlock", "final", "error", "time" or "stop"), `times` of the ends in
    seconds (in a model with clocks), `values` by observer (NaN: undefined in this run). `estimates` by observer: mean, deviation, quantiles and the 95%
    interval of the mean. `first_error`: the text of the first run that ended with one."""

    def __init__(self, seeds, steps, ends, times, values, estimates, first_error):
        self.seeds, self.steps, self.ends, self.times, self.values = seeds, steps, ends, times, values
        self.estimates, self.first_error = estimates, first_error

    def __len__(self):
        return len(self.seeds)

    def to_pandas(self):
        """A DataFrame with a row a run. Needs pandas."""
        import pandas
        times = {"time": self.times} if self.times else {}
        return pandas.DataFrame({"seed": self.seeds, "end": self.ends, "steps": self.steps, **times, **self.values})

    def to_numpy(self):
        """The values as an array with a row a run and a column an observer. Needs numpy."""
        import numpy
        return numpy.array(list(self.values.values()), dtype=float).reshape(len(self.values), len(self)).T

    def _repr_html_(self):
        rows = "".join(f"<tr><td><code>{html.escape(name)}</code></td>" + "".join(f"<td>{value:.6g}</td>" for value in (
            e.count, e.mean, e.deviation, e.least, e.q05, e.median, e.q95, e.greatest)) + f"<td>[{e.low:.6g}, {e.high:.6g}]</td></tr>"
            for name, e in self.estimates.items())
        head = "".join(f"<th>{name}</th>" for name in ("observer", "runs", "mean", "deviation", "least", "5%", "median", "95%", "greatest", "95% interval"))
        ends = ", ".join(f"{self.ends.count(end)} {end}" for end in dict.fromkeys(self.ends))
        return f"<p>{len(self)} runs, {sum(self.steps)} steps; ends: {html.escape(ends)}</p><table><tr>{head}</tr>{rows}</table>"

    def __repr__(self):
        return f"<bipc.Runs: {len(self)} runs of up to {max(self.steps, default=0)} steps>"
