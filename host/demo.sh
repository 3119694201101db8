#!/usr/bin/env bash
set -euo pipefail
help="Usage: bash host/demo.sh

Builds, starts the planner ssv-plannerd, sends it the paper's case study over LCM, and prints the paper's Tables 5-7 beside
what comes back by the paper's method, and what method optimal saves. Then flies it in simulation, in rough water, and writes the
flight as a page for a browser, build/demo.html. Stops what it started and leaves no process and no other file behind, whatever
happens.

Exit codes: 0 every plan arrived and the flight docked, 1 the set-up or the build failed or one of them did not, 64 wrong arguments."

if (($# > 0)); then
    case $1 in
        -h | --help) printf '%s\n' "$help" && exit 0 ;;
        *) printf 'There are no arguments.\n%s\n' "$help" >&2 && exit 64 ;;
    esac
fi

source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"
ssv_setup demo
ssv_with_multicast "$SSV_PYTHON" -B "$SSV_ROOT/host/demo.py" "$SSV_BUILD/bin" "$SSV_BUILD/demo.html"
