"""How long tests wait for what has to happen. Python's library only.

A test waits for an event, not for a time: only what never comes fails, however slow or loaded the machine is. BIPC_TEST_PATIENCE is a factor,
which tests/run_all.py sets for sanitized builds.
"""
import os
import time

PATIENCE = float(os.environ.get("BIPC_TEST_PATIENCE") or 1)
LONG = 60 * PATIENCE  # seconds


def until(holds, seconds=LONG, pause=0.01):
    """Waits until `holds()`; returns what it gives, something false if that does not come in time."""
    end = time.monotonic() + seconds
    while not (found := holds()) and time.monotonic() < end:
        time.sleep(pause)
    return found
