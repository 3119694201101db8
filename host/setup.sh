# Set-up for host/demo.sh and tests/run.sh, which source this file (bash). A person needs none of it directly.
#
#   ssv_setup demo|tests      installs what is missing, configures and builds in build/; the script ends when that fails
#   ssv_private CMD...        runs CMD where LCM works and nothing can leave: a network namespace with loopback alone
#   ssv_with_multicast CMD... runs CMD on this machine's network if it carries multicast, else as ssv_private does
#   SSV_ROOT SSV_BUILD SSV_PYTHON   the checkout, the build folder, the Python of the venv in it
#
# Progress goes to stderr when that is a terminal; in a pipe nothing is printed unless a step fails, and then all of it.

SSV_ROOT=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
SSV_BUILD=$SSV_ROOT/build
SSV_PYTHON=$SSV_BUILD/venv/bin/python

_ssv_say() { if [[ -t 2 ]]; then printf '%s\n' "$*" >&2; fi; }
_ssv_die() { printf '%s\n' "$@" >&2; exit 1; }

# _ssv_step WHAT CMD...: runs CMD with its output in a log, which is shown only when CMD fails.
_ssv_step() {
    local what=$1 log=$SSV_BUILD/setup.log
    shift
    _ssv_say "$what ..."
    if ! "$@" >"$log" 2>&1 </dev/null; then
        cat "$log" >&2
        _ssv_die "" "Failed: $what. The output above is also in $log"
    fi
}

# The Debian packages that a `demo` or `tests` build needs and the machine lacks.
_ssv_missing_packages() {
    local release=$1 wanted package
    wanted=(ca-certificates cmake gcc iproute2 libc6-dev libcyaml-dev libjansson-dev ninja-build)
    case $release in
        debian12) wanted+=(libglib2.0-0) ;;
        debian13) wanted+=(libglib2.0-0t64) ;;
    esac
    if [[ $2 == tests ]]; then
        wanted+=(clang libclang-rt-dev default-jdk-headless)
        wanted+=(gcc-arm-none-eabi libnewlib-arm-none-eabi qemu-system-arm) # tests on bare Cortex-M cores
        if [[ -n ${SSV_LONG:-} ]]; then
            wanted+=(tshark) # the link as a tool of others sees it
        fi
        # and on other processors with an operating system
        wanted+=(gcc-aarch64-linux-gnu gcc-arm-linux-gnueabihf libc6-dev-arm64-cross libc6-dev-armhf-cross qemu-user)
    fi
    if ! python3 -c 'import ensurepip, venv' 2>/dev/null; then
        wanted+=(python3-venv)
    fi
    for package in "${wanted[@]}"; do
        if [[ $(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null) != installed ]]; then
            printf '%s ' "$package"
        fi
    done
}

_ssv_install_packages() {
    local release missing as_root=()
    release=$(. /etc/os-release && printf '%s%s' "$ID" "${VERSION_ID:-}")
    case $release in
        debian12 | debian13) ;;
        *)
            _ssv_say "This is $release, not Debian 12 or 13: the packages that the build needs are up to you."
            return
            ;;
    esac
    missing=$(_ssv_missing_packages "$release" "$1")
    if [[ -z $missing ]]; then
        return
    fi
    if [[ $EUID -ne 0 ]]; then
        as_root=(sudo -n)
        if ! sudo -n true 2>/dev/null; then
            _ssv_die "Debian packages are missing. Run this line as root, then the script again:" \
                "  apt-get update && apt-get install -y --no-install-recommends ${missing% }"
        fi
    fi
    _ssv_step "Reading the package lists" "${as_root[@]}" apt-get -o DPkg::Lock::Timeout=300 update
    # shellcheck disable=SC2086  # one word per package
    _ssv_step "Installing ${missing% }" "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
        apt-get -o DPkg::Lock::Timeout=300 install -y --no-install-recommends $missing
}

# build/venv with exactly what the requirement files say; the stamp spares the second run the network.
_ssv_make_venv() {
    local lcm=$SSV_ROOT/host/requirements.txt mavlink=$SSV_ROOT/firmware/link/requirements.txt
    local stamp=$SSV_BUILD/venv/requirements.stamp wanted
    wanted="$(python3 --version) $(cat "$lcm" "$mavlink" | sha256sum) $SSV_BUILD"
    if [[ -f $stamp && $(<"$stamp") == "$wanted" ]]; then
        return
    fi
    _ssv_step "Making a Python environment" python3 -m venv --clear "$SSV_BUILD/venv"
    _ssv_step "Fetching LCM and pymavlink" "$SSV_PYTHON" -m pip install --no-deps --only-binary :all: --require-hashes \
        -r "$lcm" -r "$mavlink"
    printf '%s\n' "$wanted" >"$stamp"
}

ssv_setup() {
    local tests=OFF
    mkdir -p "$SSV_BUILD"
    _ssv_install_packages "$1"
    _ssv_make_venv
    if [[ $1 == tests ]]; then
        tests=ON
        _ssv_step "Looking for Unity" python3 "$SSV_ROOT/tests/support/fetch_unity.py"
    fi
    _ssv_step "Configuring" cmake -S "$SSV_ROOT" -B "$SSV_BUILD" -G Ninja -DSSV_BUILD_TESTS=$tests \
        -DPython3_EXECUTABLE="$SSV_PYTHON" \
        -DCMAKE_PREFIX_PATH="$("$SSV_PYTHON" -c 'import sysconfig; print(sysconfig.get_path("platlib"))')"
    _ssv_step "Building" cmake --build "$SSV_BUILD"
}

# Whether packets to LCM's default group have somewhere to go.
_ssv_has_multicast() { ip route get 239.255.76.67 >/dev/null 2>&1; }

ssv_private() {
    local way enter=()
    for way in "unshare --map-root-user --net" "unshare --net"; do
        # shellcheck disable=SC2086  # a command and its options
        if $way ip link set lo up 2>/dev/null; then
            read -ra enter <<<"$way"
            "${enter[@]}" bash -c 'ip link set lo up && ip route add 224.0.0.0/4 dev lo && exec "$@"' _ "$@"
            return
        fi
    done
    if ! _ssv_has_multicast; then
        _ssv_die "LCM needs a multicast route. This machine has none, and lets no program make a private network" \
            "(unshare --net is refused, as in many containers). Give it one, as root, then run the script again:" \
            "  ip link set lo up && ip route add 224.0.0.0/4 dev lo"
    fi
    echo "No private network to be had (unshare --net is refused): using the machine's own." >&2
    "$@"
}

ssv_with_multicast() {
    if _ssv_has_multicast; then
        "$@"
    else
        ssv_private "$@"
    fi
}
