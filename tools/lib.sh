# Shared by the scripts beside it: where things are, the lock, the build. Sourced, not run.
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
build_dir=${BIPC_BUILD_DIR:-$root/build}

# Two builds at once would tread on each other's files: the second one waits.
with_lock() {
  mkdir -p "$build_dir"
  if command -v flock >/dev/null; then
    exec 9>"$build_dir/.lock"
    if ! flock -n 9; then
      echo "waiting for another build of $build_dir" >&2
      flock 9
    fi
  fi
}
release_lock() {
  if command -v flock >/dev/null; then exec 9>&-; fi
}

# Configures with the preset `release` (ccache, mold, warnings are errors) and what the array `configure_options` adds.
configure_options=()
configure() {
  (cd "$root" && cmake --preset release -B "$build_dir" "${configure_options[@]}")
}

# configure_and_build [target...]: quiet if all is up to date, ninja's progress while there is work.
configure_and_build() {
  local log=$build_dir/configure.log
  # Also if the tests were left out for want of packages that are there now.
  if [[ ! -f $build_dir/build.ninja ]] || { grep -q 'tests are left out' "$log" 2>/dev/null && dpkg-query -W catch2 >/dev/null 2>&1; }; then
    echo "configuring $build_dir" >&2
    if ! configure >"$log" 2>&1 9>&-; then
      cat "$log" >&2
      return 1
    fi
  fi
  local jobs terminal=0
  jobs=$(nproc 2>/dev/null || echo 2)
  [[ -t 2 ]] && terminal=1
  # On a terminal one line that changes; piped, a line each ten steps, with an estimate of the time that is left. What a
  # failing step says is shown whole.
  ninja -C "$build_dir" -j"$jobs" "$@" 2>&1 9>&- | awk -v terminal=$terminal '
    BEGIN { start = systime() }
    /^ninja: (Entering|no work)/ || /Re-checking globbed|Re-running CMake/ || /^-- / { next }
    /^\[[0-9]+\/[0-9]+\] / {
      split($1, n, /[\[\/\]]/)
      spent = systime() - start
      left = n[2] < 3 ? "" : sprintf("  (%d s, about %d s left)", spent, spent * (n[3] - n[2]) / n[2] + 0.5)
      if (terminal) { printf "\r\033[K%.90s%s", $0, left; open = 1 }
      else if (n[2] % 10 == 0 || n[2] == n[3]) print $0 left
      fflush(); next
    }
    { if (open) { printf "\n"; open = 0 } print; fflush() }
    END { if (open) printf "\r\033[K" }' >&2
}
