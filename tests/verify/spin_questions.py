"""Properties of runs that test_exports.py asks of bipc and of SPIN: (model, root or None, kind of fairness, property).

The protocols that papers about liveness use, at sizes that SPIN visits within seconds. Strong fairness multiplies SPIN's states by 2 for each
interaction, so it is asked of small ones.
"""

PETERSON, BAKERY, SZYMANSKI = "liveness/peterson", "liveness/bakery", "liveness/szymanski"
LIBRARY, ELEVATOR, COMMIT = "classic/readers_writers", "classic/elevator", "classic/two_phase_commit"
BITS, ELECTION, TOKENS, QUEUE = "liveness/alternating_bit", "liveness/leader_election", "classic/token_ring", "liveness/philosophers_queue"

QUESTIONS = [
    (PETERSON, None, "none", "p@WAITS leads to p@CRITICAL"),
    (PETERSON, None, "none", "always eventually p@CRITICAL"),
    (PETERSON, None, "weak", "always eventually p@CRITICAL"),
    (PETERSON, None, "strong", "(always eventually p@CRITICAL) && (always eventually q@CRITICAL)"),
    (PETERSON, None, "weak:atoms", "always eventually q@CRITICAL"),
    (PETERSON, None, "none", "happens p_asks leads to happens p_enters"),
    (PETERSON, None, "weak", "happens p_asks leads to happens p_enters"),
    (PETERSON, None, "none", "(eventually always p@IDLE) || (always eventually happens p_asks)"),
    (BAKERY, None, "none", "p@HOLDS leads to p@SERVED"),
    (BAKERY, None, "none", "always eventually q@SERVED"),
    (BAKERY, None, "weak", "always eventually q@SERVED"),
    (BAKERY, None, "weak:atoms", "always eventually happens q_enters"),
    (BAKERY, None, "none", "always (happens p_draws implies ((!happens q_enters) unless happens p_enters))"),
    (BAKERY, None, "none", "always (happens p_draws && q@AWAY implies ((!happens q_enters) unless happens p_enters))"),
    (SZYMANSKI, None, "none", "process[0]@OUTSIDE leads to process[0]@CRITICAL"),
    (SZYMANSKI, None, "none", "process[1]@OUTSIDE leads to process[1]@CRITICAL"),
    (SZYMANSKI, None, "none", "always eventually process[0]@CRITICAL"),
    (SZYMANSKI, None, "weak", "always eventually process[0]@CRITICAL"),
    (SZYMANSKI, None, "weak:atoms", "always eventually process[1]@CRITICAL"),
    (SZYMANSKI, None, "weak", "always eventually process[1]@ROOM"),
    (LIBRARY, "Database(2, 1)", "weak", "always eventually writer[0]@ACTIVE"),
    (LIBRARY, "Database(2, 1)", "strong", "always eventually writer[0]@ACTIVE"),
    (LIBRARY, "Database(2, 1)", "strong", "always eventually reader[0]@ACTIVE"),
    (LIBRARY, "Database(2, 1)", "weak:atoms", "always eventually reader[0]@ACTIVE"),
    (LIBRARY, None, "none", "database.writer[0]@ACTIVE leads to database.writer[0]@IDLE"),
    (LIBRARY, None, "weak", "database.reader[0]@ACTIVE leads to database.reader[0]@IDLE"),
    (ELEVATOR, None, "none", "tower.call[2]@LIT leads to tower.call[2]@DARK"),
    (ELEVATOR, None, "weak", "tower.call[2]@LIT leads to happens tower.serve[2]"),
    (ELEVATOR, None, "weak", "always (tower.door@OPEN implies ((!happens tower.cabin.rise) until tower.door@SHUT))"),
    (ELEVATOR, None, "none", "always (tower.door@OPEN implies ((!happens tower.cabin.rise) unless tower.door@SHUT))"),
    (COMMIT, "Transactions(2)", "none", "coordinator@HEARS leads to coordinator@ASKS"),
    (COMMIT, "Transactions(2)", "weak", "always eventually coordinator@COMMITS"),
    (COMMIT, "Transactions(2)", "weak", "always eventually coordinator@ASKS"),
    (COMMIT, None, "none", "transactions.coordinator@COMMITS leads to transactions.coordinator@ASKS"),
    (BITS, None, "none", "sender@ZERO leads to sender@ONE"),
    (BITS, None, "weak", "sender@ZERO leads to sender@ONE"),
    (BITS, None, "weak", "happens accepts0 leads to happens accepts1"),
    (BITS, None, "strong", "sender@ZERO leads to sender@ONE"),
    (BITS, None, "none", "always (happens accepts0 implies next ((!happens accepts0) unless happens accepts1))"),
    (BITS, None, "none", "always (happens accepts0 implies next ((!happens repeats0) unless happens accepts1))"),
    (ELECTION, None, "none", "eventually ring.node[2]@LEADER"),
    (ELECTION, "Ring(5)", "none", "eventually node[4]@LEADER"),
    (ELECTION, None, "none", "eventually ring.node[0]@LEADER"),
    (ELECTION, None, "none", "(!ring.node[2]@LEADER) until happens ring.wins[2]"),
    (ELECTION, None, "none", "always eventually can ring.gives[0]"),
    (TOKENS, "Ring(4)", "none", "always eventually station[2]@HOLDS"),
    (TOKENS, "Ring(4)", "weak", "always eventually happens pass[1]"),
    (QUEUE, "Table(4)", "none", "phil[0]@HUNGRY leads to phil[0]@EATS"),
    (QUEUE, "Table(4)", "weak", "phil[0]@HUNGRY leads to phil[0]@EATS"),
]
