"""The option `--every N` of scripts that take words: of N cases only the first, for sampled runs (run_all.py --sample)."""
import sys


def take_every(words):
    """(N, the words without the option); N is 1 without it. Ends the program if N is no number from 1 on."""
    words = list(words)
    if "--every" not in words:
        return 1, words
    at = words.index("--every")
    value = words[at + 1] if at + 1 < len(words) else ""
    if not value.isdigit() or int(value) < 1:
        sys.exit("--every takes a number from 1 on")
    return int(value), words[:at] + words[at + 2:]
