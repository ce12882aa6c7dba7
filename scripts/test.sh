# Sourced by ./run: what `./run test` does. Each stage adds to passed/failed; the last line is their sum.
passed=0 failed=0
failed_names=() skipped=()

note() { # name exit-code
  if [ "$2" -eq 0 ]; then passed=$((passed + 1)); else
    failed=$((failed + 1))
    failed_names+=("$1")
    echo "FAILED: $1" >&2
  fi
}

# ctest in a namespace of its own; counts its tests one by one.
run_ctest() { # label-regex
  local out
  out=$(mktemp)
  in_netns ctest --test-dir build --output-on-failure -j "$jobs" -L "$1" 2>&1 | tee "$out" || true
  local ok bad
  ok=$(grep -cE ' Passed +[0-9.]+ sec' "$out" || true)
  bad=$(grep -cE '\*\*\*(Failed|Timeout|Exception|Not Run)' "$out" || true)
  passed=$((passed + ok)) failed=$((failed + bad))
  [ "$bad" -gt 0 ] && failed_names+=("$(grep -oE '[a-z]+\.[a-z0-9_]+ .*\*\*\*' "$out" | cut -d' ' -f1 | tr '\n' ' ')")
  [ $((ok + bad)) -gt 0 ] || note "ctest $1 (no test ran)" 1
  rm -f "$out"
}

# The programs given, side by side, each with its output in out/checks/NAME.log, shown if it fails.
run_side_by_side() { # stage [name command...]... as lines on standard input
  local stage=$1 folder=out/checks
  mkdir -p "$folder"
  rm -f "$folder/$stage".*
  export -f in_netns
  xargs -P "$jobs" -I{} bash -c '
    set -- {}
    log=$0.$1.log
    shift
    "$@" >"$log" 2>&1
    echo $? >"${log%.log}.rc"' "$folder/$stage"
  local rc name
  for rc in "$folder/$stage".*.rc; do
    name=${rc#"$folder/"}
    name=${name%.rc}
    [ "$(cat "$rc")" = 0 ] || tail -n 40 "${rc%.rc}.log" >&2
    note "$name" "$(cat "$rc")"
  done
}

# Unit tests of folders under a sanitizer.
run_sanitized() { # preset folder...
  local preset=$1 folder
  shift
  # shellcheck disable=SC2046
  build "$preset" $(printf 'test_%s\n' "$@") || { note "$preset build" 1; return; }
  ASAN_OPTIONS=detect_leaks=1:allocator_may_return_null=1 UBSAN_OPTIONS=print_stacktrace=1 \
    TSAN_OPTIONS="halt_on_error=1" \
    run_side_by_side "$preset" < <(for folder in "$@"; do echo "$folder in_netns build/$preset/bin/test_$folder --gtest_brief=1"; done)
}

fuzz_targets() { find tests/fuzz -name '*_fuzz.cpp' -printf '%f\n' | sed 's/_fuzz.cpp$//' | sort; }

# Every fuzzer for some seconds, from its committed corpus and what earlier runs found (out/fuzz/NAME).
run_fuzz() { # seconds [target...]
  local seconds=$1 name log
  shift
  local names=("$@")
  # shellcheck disable=SC2207
  [ ${#names[@]} -gt 0 ] || names=($(fuzz_targets))
  build asan "${names[@]/#/fuzz_}" || { note "fuzz build" 1; return; }
  mkdir -p "${names[@]/#/out/fuzz/}"
  run_side_by_side fuzz < <(for name in "${names[@]}"; do
    echo "$name build/asan/bin/fuzz_$name -max_total_time=$seconds -max_len=4096 -rss_limit_mb=1024 -timeout=5" \
      "-malloc_limit_mb=256 -print_final_stats=1 -artifact_prefix=out/fuzz/crash-$name- out/fuzz/$name tests/fuzz/corpus/$name"
  done)
  for name in "${names[@]}"; do
    log=out/checks/fuzz.$name.log
    echo "fuzz $name: $(grep -oE 'number_of_executed_units: +[0-9]+' "$log" | grep -oE '[0-9]+$' || echo 0) inputs in $seconds s"
  done
}

# What needs a kernel with devices: in a virtual machine. Where that cannot be had the stage is left out, and said so
# where nobody overlooks it; tests that began and did not end well have failed.
run_vm() {
  local out status=0 ok bad why
  out=$(mktemp)
  if ! (need vm) 2>"$out"; then
    status=126
  else
    build dev test_vm kawara-camera kawara-onboard kawara-log || { note "vm build" 1; return; }
    tests/vm/machine.sh --time "${KAWARA_VM_SECONDS:-900}" build/bin/test_vm 2>&1 | tee "$out" || status=${PIPESTATUS[0]}
  fi
  if [ "$status" = 126 ]; then
    why=$(grep -oE '^(machine.sh|run): .*' "$out" | tail -1)
    skipped+=("vm (${why:-no reason given})")
    printf '\n!!! %s\n' "SKIPPED: the tests on a real kernel did not run: ${why:-no reason given}" >&2
  else
    ok=$(grep -c '^\[       OK \]' "$out" || true)
    bad=$(grep -cE '^\[  FAILED  \] .*\([0-9]+ ms\)' "$out" || true)
    passed=$((passed + ok)) failed=$((failed + bad))
    [ "$bad" -eq 0 ] || failed_names+=("$(grep -oE '^\[  FAILED  \] .*\([0-9]+ ms\)' "$out" | awk '{print $4}' | tr '\n' ' ')")
    [ "$bad" -gt 0 ] || [ "$status" = 0 ] || note "vm (the machine or the tests ended with status $status)" 1
    [ "$ok" -gt 0 ] || note "vm (no test ran)" 1
  fi
  rm -f "$out"
}

run_format() {
  local rc=0
  sources | xargs clang-format --dry-run -Werror || rc=$?
  note "clang-format (./run fmt mends it)" "$rc"
}

run_lint() {
  local rc=0
  [ -f build/compile_commands.json ] || cmake --preset dev >/dev/null
  build dev kawara_lcmtypes_gen
  cppcheck --quiet --std=c++20 --language=c++ --enable=warning,portability,performance --inline-suppr --error-exitcode=1 \
    --suppressions-list=scripts/cppcheck.suppress -j "$jobs" -I . core drivers estimation vision gis comms onboard station sim tools || rc=$?
  note cppcheck "$rc"
  rc=0
  /usr/bin/python3 -B scripts/lint.py build "$jobs" || rc=$?
  note clang-tidy "$rc"
  echo "lint: $passed passed, $failed failed"
  [ "$failed" -eq 0 ]
}

run_tests() {
  local stages=("$@") stage start=$SECONDS
  [ ${#stages[@]} -gt 0 ] || stages=(format unit hil vm)
  [ "${stages[*]}" != all ] || stages=(format unit hil vm asan tsan fuzz lint)
  for stage in "${stages[@]}"; do
    echo "== $stage"
    case "$stage" in
      format) run_format ;;
      unit) build dev && run_ctest unit || note "build" 1 ;;
      hil | replay) build dev && run_ctest 'hil|replay' || note "build" 1 ;;
      vm) run_vm ;;
      asan) run_sanitized asan core config drivers estimation vision vision_camera gis comms onboard onboard_check survey station sim sim_site sim_render sim_vehicle sim_evaluate sim_radio navigate ;;
      tsan) run_sanitized tsan core drivers comms onboard station sim sim_render ;;
      fuzz) run_fuzz "${KAWARA_FUZZ_SECONDS:-5}" ;;
      lint) run_lint || true ;;
      *) echo "run: no test stage '$stage'" >&2; exit 2 ;;
    esac
  done
  [ "$failed" -eq 0 ] || printf 'failed: %s\n' "${failed_names[*]}"
  [ ${#skipped[@]} -eq 0 ] || printf '!!! SKIPPED: %s\n' "${skipped[@]}"
  echo "took $((SECONDS - start)) s; logs in build/Testing and out/checks"
  echo "tests: $passed passed, $failed failed"
  [ "$failed" -eq 0 ]
}
