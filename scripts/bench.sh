# Sourced by ./run: builds the benchmarks optimised and runs those of the folders named (all of them without a word).
run_bench() {
  local folders=("$@") folder source name ran=0
  [ ${#folders[@]} -gt 0 ] || for folder in tests/bench/*/; do folders+=("$(basename "$folder")"); done
  mkdir -p out/bench
  for folder in "${folders[@]}"; do
    [ -d "tests/bench/$folder" ] || {
      echo "run: no benchmarks for '$folder'; there are: $(ls tests/bench | tr '\n' ' ')" >&2
      exit 2
    }
    for source in "tests/bench/$folder"/*_bench.cpp "tests/bench/$folder"/*_bench.py; do
      [ -e "$source" ] || continue
      if [[ $source == *.py ]]; then
        # Measures whole programs: it names those it needs in its first lines.
        name=$(basename "$source" _bench.py)
        # shellcheck disable=SC2046
        build release $(sed -n 's/^# programs: //p' "$source")
        echo "== $folder/$name"
        in_netns env KAWARA_BIN=build/release/bin PYTHONPATH=tests/support /usr/bin/python3 -B "$source" --json "out/bench/$name.json"
        ran=$((ran + 1))
        continue
      fi
      name=$(basename "$source" _bench.cpp)
      build release "bench_$name"
      echo "== $folder/$name"
      "build/release/bin/bench_$name" --benchmark_out="out/bench/$name.json" --benchmark_out_format=json --benchmark_min_time=0.2 \
        --benchmark_counters_tabular=true 2>/dev/null
      ran=$((ran + 1))
    done
  done
  echo "bench: $ran programs; figures in out/bench/*.json"
}
