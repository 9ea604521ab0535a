# Shared by the scripts beside it: where things are, the lock, the build. Sourced, not run.
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
build_dir=${BIPC_BUILD_DIR:-$root/build}
# Build directories of one checkout share what ccache keeps, as far as their options agree.
# It goes before `base_dir` of ccache's own configuration; CCACHE_BASEDIR= leaves that as it is.
export CCACHE_BASEDIR=${CCACHE_BASEDIR-$root}

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

# show_progress TERMINAL: ninja's lines from the standard input. On a terminal (1) one line that changes; piped (0), a line each
# ten steps, with an estimate of the time that is left. What a failing step says is shown whole.
# Not by awk: Debian's (mawk) reads a pipe in blocks of 4 KiB, which are minutes of a first build.
show_progress() {
  local start=$SECONDS open='' line done all spent left
  while IFS= read -r line; do
    if [[ $line =~ ^\[([0-9]+)/([0-9]+)\]\  ]]; then
      done=${BASH_REMATCH[1]} all=${BASH_REMATCH[2]} left=''
      spent=$((SECONDS - start))
      ((done < 3)) || left="  ($spent s, about $(((spent * (all - done) + done / 2) / done)) s left)"
      if (($1)); then
        printf '\r\033[K%.90s%s' "$line" "$left"
        open=yes
      elif ((done % 10 == 0 || done == all)); then
        printf '%s%s\n' "$line" "$left"
      fi
    elif [[ ! $line =~ ^ninja:\ (Entering|no\ work)|Re-checking\ globbed|Re-running\ CMake|^--\  ]]; then
      [[ ! $open ]] || printf '\n'
      open=''
      printf '%s\n' "$line"
    fi
  done
  [[ ! $open ]] || printf '\r\033[K'
}

# Is the build folder one of build_runner, without the rest?
has_runner_only() { grep -qs '^BIPC_RUNNER_ONLY:BOOL=ON' "$build_dir/CMakeCache.txt"; }

# build_runner: builds the part of bipc that runs models, build/bipc-runner, for who has no bipc yet: about half of the packages
# and of the compilation. All that is compiled is a part of the whole.
build_runner() {
  "$root/tools/setup" --runner 9>&-
  [[ -f $build_dir/build.ninja ]] || configure_options+=(-DBIPC_RUNNER_ONLY=ON)
  configure_and_build bipc_runner
}

# configure_and_build [target...]: quiet if all is up to date, ninja's progress while there is work.
configure_and_build() {
  local log=$build_dir/configure.log
  if has_runner_only && [[ $* != bipc_runner ]]; then
    # With the options that it has, so that nothing compiles again.
    if ! cmake -DBIPC_RUNNER_ONLY=OFF "$build_dir" >"$log" 2>&1 9>&-; then
      cat "$log" >&2
      return 1
    fi
  fi
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
  ninja -C "$build_dir" -j"$jobs" "$@" 2>&1 9>&- | show_progress $terminal >&2
}
