__version__: str

class Diagnostic:
    code: str
    severity: str
    message: str
    file: str
    line: int
    column: int
    end_line: int
    end_column: int
    label: str
    notes: list[str]
    help: list[str]

class CounterexampleStep:
    time: int
    choice: int
    interaction: str

class Counterexample:
    end: str
    steps: list[CounterexampleStep]
    text: str
    def __len__(self) -> int: ...

class Exploration:
    end: str
    states: int
    steps: int
    deadlocks: int
    finals: int
    time_locks: int
    errors: int
    depth: int
    seconds: float
    bytes: int
    deadlock: Counterexample | None
    time_lock: Counterexample | None
    error: Counterexample | None
    text: str

class Verdict:
    name: str
    holds: bool
    violated: bool
    unknown: bool
    property: str
    method: str
    reason: str
    states: int
    invariants: int
    lemmas: int
    certificate: str
    counterexample: Counterexample | None
    text: str
    json: str
    diagnostics: list[Diagnostic]

class Estimate:
    count: int
    mean: float
    deviation: float
    least: float
    greatest: float
    q05: float
    median: float
    q95: float
    low: float
    high: float

class Snapshot: ...
