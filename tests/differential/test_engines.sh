#!/usr/bin/env bash
# Random systems run by the engines with several threads (--engine=threads, --engine=batch), under random delays, and by the
# simulated one, with cuts, losses and crashes of nodes; every run is
# recorded and followed by the core (runtime/engine/replay_record.hpp). Fails if one is no run of its model.
#
#   tests/differential/test_engines.sh [COUNT] [FROM] [RUNS]        COUNT systems (default 100), seeds from FROM (default 1), RUNS of
#                                                           each engine with each executor (default 4)
#
# BUILD names the build directory (default: build beside the sources), JOBS the number of processes. Built with the preset `tsan`
# (`BIPC_JIT=OFF` will do) the same runs are watched by the thread sanitizer, emitted C++ and its compiled steps included.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
build=${BUILD:-$root/build}
if [[ ! -x $build/bip-gen ]]; then
  echo "tests/differential/test_engines.sh: no bip-gen in $build; build it first: ninja -C $build bip-gen" >&2
  exit 2
fi
export TSAN_OPTIONS=${TSAN_OPTIONS:-halt_on_error=1}
exec "$build/bip-gen" --check --engines "${3:-4}" --from "${2:-1}" --count "${1:-100}" --jobs "${JOBS:-$(nproc)}" --emit-cpp --out "$build/gen-failures"
