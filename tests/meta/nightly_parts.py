"""Parts for the meta-test of tools/test_nightly: `silent` ends without its line, `nothing` passes nothing, `systems` ends as bip-gen does, `crash` fails after its line, and
`sound` passes."""
import sys

LINES = {"silent": "no line", "nothing": "part: 0 passed, 0 failed", "crash": "part: 3 passed, 0 failed", "sound": "part: 3 passed, 0 failed",
         "systems": "differential: 5 systems, 2 failed"}
print(LINES[sys.argv[1]])
sys.exit(1 if sys.argv[1] in ("crash", "systems") else 0)
