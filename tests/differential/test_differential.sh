#!/usr/bin/env bash
# Random systems through every executor, the naive oracle and the round trips (tools/gen). Fails if any differs.
#
#   tests/differential/test_differential.sh [COUNT] [FROM] [--without-emitted]
#
# COUNT systems (default 500), seeds from FROM (default 1); without emitted C++ they take a fifth of the time.
#
# BUILD names the build directory (default: build beside the sources), JOBS the number of processes.
# Reduced models of failures are left in $BUILD/gen-failures. About three minutes for 500 systems on two cores.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
build=${BUILD:-$root/build}
count=${1:-500}
from=${2:-1}
emitted=(--emit-cpp)
[[ ${3-} != --without-emitted ]] || emitted=()
if [[ ! -x $build/bip-gen ]]; then
  echo "tests/differential/test_differential.sh: no bip-gen in $build; build it first: ninja -C $build bip-gen" >&2
  exit 2
fi
exec "$build/bip-gen" --check --from "$from" --count "$count" --jobs "${JOBS:-$(nproc)}" "${emitted[@]}" --out "$build/gen-failures"
