"""Models that people's generators write: flat, without parameters and loops, in the order in which things came to mind.

Each function returns the text of a model of size n; tools/bench/engine runs it beside the program by hand of the same
behaviour. Python's library only.
"""
import random

PHILOSOPHER = """  port type Signal()
  connector type Three(Signal who, Signal left, Signal right)
    define who left right
  end
  atom type Philosopher()
    data int meals = 0
    export port Signal take(), give()
    place THINKS, EATS
    initial to THINKS
    on take from THINKS to EATS do { meals = meals + 1; }
    on give from EATS to THINKS
  end
  atom type Fork()
    export port Signal take(), give()
    place FREE, TAKEN
    initial to FREE
    on take from FREE to TAKEN
    on give from TAKEN to FREE
  end
"""


def flat_table(name, components, connectors):
    lines = "\n".join(f"    {line}" for line in [*components, *connectors])
    return f"package {name}\n{PHILOSOPHER}  compound type Root()\n{lines}\n  end\nend\n"


def table_parts(n):
    components = [f"component Philosopher phil{i}()" for i in range(n)] + [f"component Fork fork{i}()" for i in range(n)]
    connectors = [[f"connector Three {what}{i}(phil{i}.{what}, fork{i}.{what}, fork{(i + 1) % n}.{what})" for i in range(n)]
                  for what in ("take", "give")]
    return components, connectors


def shuffled(n):
    """The philosophers of models/bench, components and connectors in random order."""
    components, (takes, gives) = table_parts(n)
    connectors = takes + gives
    order = random.Random(n)
    order.shuffle(components)
    order.shuffle(connectors)
    return flat_table("shuffled", components, connectors)


def interleaved(n):
    """The same with both connectors of a philosopher side by side."""
    components, (takes, gives) = table_parts(n)
    return flat_table("interleaved", components, [line for pair in zip(takes, gives) for line in pair])


# Receivers that always hear, and a sender that counts between broadcasts.
ALL_HEAR = {"sender": """    export port Signal count()
    place READY, COUNTS
    initial to READY
    on send from READY to COUNTS
    on count from COUNTS to READY do { value = value + 1; }
""", "receiver": """    place S
    initial to S
    on hear from S to S do { heard = heard + value; }
""", "connectors": lambda n: "    connector One count(sender.count)\n"}
# Receivers that have to be re-armed, one by one: most broadcasts reach some of them.
SOME_HEAR = {"sender": """    place READY
    initial to READY
    on send from READY to READY do { value = value + 1; }
""", "receiver": """    export port Signal rearm()
    place LISTENING, FULL
    initial to LISTENING
    on hear from LISTENING to FULL do { heard = heard + value; }
    on rearm from FULL to LISTENING
""", "connectors": lambda n: "".join(f"    connector One again{i}(receiver{i}.rearm)\n" for i in range(n))}


def data_broadcast(n, name="data_broadcast", parts=ALL_HEAR):
    """A sender that hands an int to all of n receivers, with a clause for all of them."""
    receivers = range(n)
    parameters = "".join(f", Number r{i}" for i in receivers)
    names = " ".join(f"r{i}" for i in receivers)
    down = " ".join(f"r{i}.value = s.value;" for i in receivers)
    components = "".join(f"    component Receiver receiver{i}()\n" for i in receivers)
    ports = "".join(f", receiver{i}.hear" for i in receivers)
    return f"""package {name}
  port type Signal()
  port type Number(int value)
  connector type One(Signal p) define p end
  connector type All(Number s{parameters})
    define s' {names}
    on s {names} down {{ {down} }}
  end
  atom type Sender()
    data int value = 0
    export port Number send(value)
{parts["sender"]}  end
  atom type Receiver()
    data int value = 0, heard = 0
    export port Number hear(value)
{parts["receiver"]}  end
  compound type Root()
    component Sender sender()
{components}    connector All all(sender.send{ports})
{parts["connectors"](n)}  end
end
"""


def data_broadcast_some(n):
    """The same with receivers of which some are ready."""
    return data_broadcast(n, "data_broadcast_some", SOME_HEAR)


MODELS = {"shuffled": shuffled, "interleaved": interleaved, "data_broadcast": data_broadcast, "data_broadcast_some": data_broadcast_some}
