#!/usr/bin/env bash
# Random systems: the prover's verdicts against a visit of all states, its proofs given to certcheck.
#
#   tests/verify/test_verify.sh [COUNT] [FROM]        COUNT systems (default 2000), half of them small nets
#
# BUILD names the build directory (default: build beside the sources), JOBS the number of processes, STATES how many a visit
# may see (default 2000). CERTIFICATES=all gives every proof to certcheck, not those of one system in five. About ten minutes for
# 2000 systems on two quiet cores.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
build=${BUILD:-$root/build}
count=${1:-2000}
from=${2:-1}
jobs=${JOBS:-$(nproc)}
states=${STATES:-2000}
for program in bip-verify-check certcheck bip-mutate-certificates; do
  if [[ ! -x $build/$program ]]; then
    echo "tests/verify/test_verify.sh: no $program in $build; build it first: ninja -C $build $program" >&2
    exit 2
  fi
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
seeds=$(((count + 1) / 2))
each=$(((seeds + jobs - 1) / jobs))
for ((j = 0; j < jobs; j++)); do
  mkdir "$work/proofs$j"
  {
    "$build/bip-verify-check" --from $((from + j * each)) --count $each --states "$states" --out "$work/proofs$j" || true
    # Of one system in five the proofs are checked by the other program, and with their first lemma, invariant or set of places turned
    # into one that no state satisfies, which must not be accepted.
    if [[ -x $build/certcheck ]]; then
      for proof in "$work/proofs$j"/*-?.cert; do
        [[ -e $proof ]] || continue
        [[ ${CERTIFICATES:-some} == all || $proof == *[04]-?.cert ]] || continue
        code=0
        timeout 60 "$build/certcheck" "${proof%.cert}.bsys" "$proof" >"$work/told$j" 2>&1 || code=$?
        # 124: no time. 4: not checkable.
        if [[ $code -eq 1 ]]; then echo "FAILED certificate $(basename "$proof"): $(tail -1 "$work/told$j")"; fi
        echo "certificate $code"
        for part in '^(lemma|trap|one-token) ' '^component ' '^bound '; do
          # `component NAME class N reachable`, and then none; a lemma, trap or set of nothing.
          awk -v part="$part" '$0 ~ part && !done { $0 = $1 == "component" ? $1 " " $2 " " $3 " " $4 " " $5 : $1; done = 1 } { print } END { exit !done }' \
            "$proof" >"$work/broken$j" || continue
          code=0
          timeout 60 "$build/certcheck" "${proof%.cert}.bsys" "$work/broken$j" >"$work/told$j" 2>&1 || code=$?
          if [[ $code -eq 0 ]]; then echo "FAILED broken certificate $(basename "$proof") is accepted"; fi
          echo "broken $code"
        done
      done
    fi
  } >"$work/log$j" 2>&1 &
done
# Seeds that once failed: kept lemmas, true ones, with which the next proof had no end.
once=(6026460)
for seed in "${once[@]}"; do
  "$build/bip-verify-check" --sort nets --from "$seed" --count 1 --states "$states" --seconds 1 >"$work/log-$seed" 2>&1 || true
done
if [[ -x $build/bip-mutate-certificates ]]; then
  # Changed proofs of other systems, each judged by a visit of all states that its clauses allow.
  "$build/bip-mutate-certificates" --from "$from" --count $(((seeds + 39) / 40)) --each 15 >"$work/mutations" 2>&1 || echo "FAILED mutations" >>"$work/mutations"
else
  echo "mutations: left out, certcheck is not built" >"$work/mutations"
fi
wait
cat "$work/mutations"
cat "$work"/log* | grep -v -E '^(certificate|broken) '
awk '/^systems / { n += $2; f += $4; found++ }
/^FAILED (broken )?certificate/ { f++ }
/^mutations: [0-9]/ { n += $2; f += $4 }
/^FAILED mutations/ { f++ }
/^certificate / { checked++; accepted += $2 == 0 }
/^broken / { broken++; refused += $2 == 1 }
END {
  printf "certificates: %d of %d accepted; broken ones: %d of %d refused\n", accepted, checked, refused, broken
  # Of many systems some are proved, so that there is something to refuse.
  if (n >= 200 && (checked == 0 || refused == 0)) { print "FAILED no certificate was checked"; f++ }
  bad = f + (found == jobs + once && 1 ? 0 : 1)
  print n - f " passed, " bad " failed"
  exit bad != 0
}' jobs="$jobs" once="${#once[@]}" "$work/mutations" "$work"/log*
