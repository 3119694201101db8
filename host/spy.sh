#!/usr/bin/env bash
# Opens lcm-spy on the planner's messages; see usage below.
set -euo pipefail

usage() {
    cat <<'END'
Usage: bash host/spy.sh [--lcm-url URL]

Opens lcm-spy with the planner's message types: every channel with its rate, and on a double click every field of the
last message, with graphs of the numbers. A double click on SSV_PLAN shows the thrusts and the way from above instead, on
SSV_PLANNER_STATUS what each planner does in a second; their fields are in the menu of the right button. Needs a build
(bash host/demo.sh makes one) and a display.

  --lcm-url URL   where to listen (default: $LCM_DEFAULT_URL, else udpm://239.255.76.67:7667?ttl=0)
  --help          this text

Example: bash host/spy.sh --lcm-url 'udpm://239.255.76.67:7700?ttl=0'

Exit codes: 0 window closed, 1 something is missing (the message says what), 64 wrong usage.
END
}

die() {
    printf 'spy.sh: %s\n' "$@" >&2
    exit 1
}

url=
while [ $# -gt 0 ]; do
    case $1 in
        --lcm-url) url=${2-}; shift ;;
        --lcm-url=*) url=${1#*=} ;;
        --help | -h) usage; exit 0 ;;
        *) printf 'spy.sh: unknown argument "%s"\n\n' "$1" >&2; usage >&2; exit 64 ;;
    esac
    if [ -z "$url" ]; then
        printf 'spy.sh: --lcm-url needs a URL\n\n' >&2; usage >&2; exit 64
    fi
    shift
done
url=${url:-${LCM_DEFAULT_URL:-udpm://239.255.76.67:7667?ttl=0}}

build=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)/build
python=$build/venv/bin/python3
jar=$build/share/ssv_lcmtypes.jar

[ -x "$python" ] || die "not built yet: no $python" "build with: bash host/demo.sh"
java -version >/dev/null 2>&1 || die "no Java runtime" "install one with: apt-get install default-jdk"
[ -f "$jar" ] || die "the message types for Java are missing: no $jar" \
    "install a Java compiler and build again: apt-get install default-jdk && bash host/demo.sh"
[ -n "${DISPLAY-}" ] || die "no display: DISPLAY is not set" "run this in a desktop session or over ssh -X"
java_home=$(java -XshowSettings:properties -version 2>&1 | sed -n 's/^ *java\.home = //p')
[ -e "$java_home/lib/libawt_xawt.so" ] || die "the Java runtime in $java_home cannot open windows" \
    "install one that can: apt-get install default-jre"
"$python" -c 'import sys, lcm; lcm.LCM(sys.argv[1])' "$url" 2>/dev/null || die "cannot listen on $url" \
    "if the URL is right, the machine has no multicast route; as root: ip link set lo up && ip route add 224.0.0.0/4 dev lo"

# The program behind the wheel's wrapper becomes this process, so that a signal to it ends lcm-spy.
spy=$("$python" -c 'import lcm; print(lcm.LCM_BIN_DIR + "/lcm-spy")')
echo "spy.sh: listening on $url (ClassDiscoverer lines about classes that are not found are harmless)"
CLASSPATH=$jar${CLASSPATH:+:$CLASSPATH} exec "$spy" --lcm-url "$url" --title-url
