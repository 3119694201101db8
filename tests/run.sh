#!/usr/bin/env bash
set -euo pipefail
help="Usage: bash tests/run.sh [--long] [CTEST OPTION...]

Sets up what is missing, builds, and runs every test, in a private network so that nothing reaches the machine's own.

  --long          longer sweeps of the property tests and the fuzzer
  -h, --help      this text
  CTEST OPTION    handed to ctest, e.g. -R unit (tests whose name matches), -L sil (one folder), -V (all output)

Examples:
  bash tests/run.sh               what a change must pass
  bash tests/run.sh -R arch -V    the architecture tests, with all that they print

Exit codes: 0 every test passed, 8 some failed, 1 the set-up or the build failed."

seconds_per_test=900
options=()
for option in "$@"; do
    case $option in
        -h | --help) printf '%s\n' "$help" && exit 0 ;;
        --long) export SSV_LONG=1 seconds_per_test=36000 ;;
        *) options+=("$option") ;;
    esac
done

source "$(dirname "${BASH_SOURCE[0]}")/../host/setup.sh"
ssv_setup tests
ssv_private ctest --test-dir "$SSV_BUILD" --output-on-failure --no-tests=error --parallel 2 \
    --timeout "$seconds_per_test" "${options[@]}"
