#!/usr/bin/env bash
set -euo pipefail
help="Usage: bash tests/run.sh [--quick | --coverage] [--long] [CTEST OPTION...]

Sets up what is missing, builds, and runs every test, in a private network so that nothing reaches the machine's own.

  --quick         what answers within seconds, once built: unit, golden, layers, layout and words
  --coverage      builds in build/coverage with gcc's counters, runs the unit, golden, property and sil tests there, and
                  prints which share of the lines and branches of each folder they reach (installs gcovr)
  --long          longer sweeps of the property tests and the fuzzer
  -h, --help      this text
  CTEST OPTION    handed to ctest, e.g. -R unit (tests whose name matches), -L sil (one folder), -V (all output)

Examples:
  bash tests/run.sh                       what a change must pass
  bash tests/run.sh --quick               while writing one
  bash tests/run.sh -R arch -V            the architecture tests, with all that they print
  bash tests/run.sh --coverage -L unit    what the unit tests alone reach
  SSV_SEED=7 bash tests/run.sh -R scalars other random tasks, where a test has a seed (tests/README.md)

Exit codes: 0 every test passed, 8 some failed, 1 the set-up or the build failed, 64 wrong usage."

# For each test. The longest takes a minute of processor time, and less than half of this where three neighbours want the same
# cores. One limit for all, since --long lifts it and a limit of a test's own would stay.
seconds_per_test=900
kind=all
options=()
for option in "$@"; do
    case $option in
        -h | --help) printf '%s\n' "$help" && exit 0 ;;
        --long) export SSV_LONG=1 seconds_per_test=36000 ;;
        --quick | --coverage)
            if [[ $kind != all ]]; then
                echo "--quick and --coverage exclude one another; --help tells more." >&2
                exit 64
            fi
            kind=${option#--}
            ;;
        *) options+=("$option") ;;
    esac
done

source "$(dirname "${BASH_SOURCE[0]}")/../host/setup.sh"

# run_tests FOLDER OPTION...: ctest in a build folder.
run_tests() {
    ssv_private ctest --test-dir "$1" --output-on-failure --no-tests=error --parallel 2 --timeout "$seconds_per_test" \
        "${@:2}" "${options[@]}"
}

case $kind in
    all)
        ssv_setup tests
        run_tests "$SSV_BUILD"
        ;;
    quick)
        ssv_setup tests
        run_tests "$SSV_BUILD" -R '^(unit\.|golden\.|arch\.(layers|format|words)$)'
        ;;
    coverage)
        ssv_setup tests gcovr
        folder=$SSV_BUILD/coverage
        # -D_exit=exit: the processes that share a sweep end with _exit, which would lose their counts.
        ssv_build "$folder" -DSSV_BUILD_TESTS=ON -DCMAKE_BUILD_TYPE=Debug -DCMAKE_C_FLAGS="--coverage -O1 -D_exit=exit"
        # Counts of an earlier run, and the programs by which cmake gets to know the compiler, which gcovr stumbles over.
        find "$folder" -name '*.gcda' -delete
        find "$folder/CMakeFiles" -name '*.gcno' -delete
        code=0
        run_tests "$folder" -L '^(unit|golden|property|sil)$' || code=$?
        gcovr --root "$SSV_ROOT" --object-directory "$folder" --filter "$SSV_ROOT/(firmware|host|sim)/" --json-summary-pretty \
            "$folder" 2>"$folder/gcovr.log" |
            python3 "$SSV_ROOT/tests/support/coverage.py" || { cat "$folder/gcovr.log" >&2 && exit 1; }
        exit "$code"
        ;;
esac
