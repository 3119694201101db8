# Set-up for host/demo.sh and tests/run.sh, which source this file (bash). A person needs none of it directly.
#
#   ssv_setup demo|tests [PACKAGE...]  installs what is missing, and these Debian packages, configures and builds in build/;
#                             the script ends when that fails
#   ssv_build FOLDER OPTION...  configures and builds the checkout in another folder, with more options of cmake
#   ssv_private CMD...        runs CMD where LCM works and nothing can leave: a network namespace with loopback alone
#   ssv_with_multicast CMD... runs CMD on this machine's network if it carries multicast, else as ssv_private does
#   SSV_ROOT SSV_BUILD SSV_PYTHON   the checkout, the build folder, the Python of the venv in it
#
# Each step is a line on stderr as it starts; what a step prints is shown only when it fails, and then all of it.

SSV_ROOT=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
SSV_BUILD=$SSV_ROOT/build
SSV_PYTHON=$SSV_BUILD/venv/bin/python

_ssv_say() { printf '%s\n' "$*" >&2; }
_ssv_die() { printf '%s\n' "$@" >&2; exit 1; }

# Whether the step that ran last, or the reading of the package lists before it, did not reach the network. apt-get update
# ends well even then; what comes after it fails with another message.
_ssv_lists_unread=
_ssv_saw_no_network() {
    grep -qE 'Temporary failure (resolving|in name resolution)|Could not (resolve|connect)|Network is unreachable|Cannot initiate|'\
'Unable to connect|Failed to establish a new connection|Connection (failed|refused)' "$SSV_BUILD/setup.log"
}

# _ssv_step WHAT CMD...: runs CMD with its output in a log, which is shown only when CMD fails.
_ssv_step() {
    local what=$1 log=$SSV_BUILD/setup.log
    shift
    _ssv_say "$what ..."
    if ! "$@" >"$log" 2>&1 </dev/null; then
        cat "$log" >&2
        printf '\n%s\n' "Failed: $what. The output above is also in $log" >&2
        if [[ -n $_ssv_lists_unread ]] || _ssv_saw_no_network; then
            _ssv_die "The network is missing, or a server cannot be reached. The first run needs it for Debian packages, LCM and" \
                "Unity; runs after that do not. Connect this machine (behind a proxy, set http_proxy and https_proxy) and" \
                "run the script again."
        fi
        exit 1
    fi
}

# _ssv_missing_packages RELEASE demo|tests [PACKAGE...]: the Debian packages that such a build needs and the machine lacks.
_ssv_missing_packages() {
    local release=$1 wanted package
    wanted=(ca-certificates cmake gcc iproute2 libc6-dev libfyaml-dev libjansson-dev libjs-dygraphs libjs-three libmicrohttpd-dev
        ninja-build)
    case $release in
        debian12) wanted+=(libglib2.0-0) ;;
        debian13) wanted+=(libglib2.0-0t64) ;;
    esac
    if [[ $2 == tests ]]; then
        wanted+=(clang g++ libclang-rt-dev llvm default-jdk-headless) # llvm: names in the stack traces of findings
        wanted+=(clang-tidy cppcheck) # the target check
        wanted+=(gnuplot-nox)
        wanted+=(gcc-arm-none-eabi libnewlib-arm-none-eabi qemu-system-arm) # tests on bare Cortex-M cores
        if [[ -n ${SSV_LONG:-} ]]; then
            wanted+=(tshark)   # the link as a tool of others sees it
            wanted+=(chromium) # pages as a browser shows them
            wanted+=(xvfb default-jre) # lcm-spy on a display that nobody sees
        fi
        # and on other processors with an operating system
        wanted+=(gcc-aarch64-linux-gnu gcc-arm-linux-gnueabihf libc6-dev-arm64-cross libc6-dev-armhf-cross qemu-user)
    fi
    wanted+=("${@:3}")
    if ! python3 -c 'import ensurepip, venv' 2>/dev/null; then
        wanted+=(python3-venv)
    fi
    for package in "${wanted[@]}"; do
        if [[ $(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null) != installed ]]; then
            printf '%s ' "$package"
        fi
    done
}

# _ssv_install_packages demo|tests [PACKAGE...]: installs them.
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
    missing=$(_ssv_missing_packages "$release" "$@")
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
    if _ssv_saw_no_network; then _ssv_lists_unread=1; fi
    # shellcheck disable=SC2086  # one word per package
    _ssv_step "Installing ${missing% }" "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
        apt-get -o DPkg::Lock::Timeout=300 install -y --no-install-recommends $missing
    _ssv_lists_unread=
}

# LCM comes as a wheel, and host/requirements.txt locks those that there are.
_ssv_check_python() {
    local found words
    found=$(python3 -c 'import platform as p; print(p.python_implementation(), *p.python_version_tuple()[:2], p.machine())')
    if [[ ! $found =~ ^CPython\ 3\ 1[0-4]\ (aarch64|x86_64)$ ]]; then
        read -ra words <<<"$found"
        _ssv_die "LCM 1.5.3 is to be had for CPython 3.10, 3.11, 3.12, 3.13 and 3.14 on aarch64 and x86_64; this is" \
            "${words[0]} ${words[1]}.${words[2]} on ${words[3]} ($(command -v python3)). Put one of those first in PATH as" \
            "python3. The planner library alone needs no LCM: cmake -DSSV_BUILD_HOST=OFF -DSSV_BUILD_TESTS=OFF"
    fi
}

# build/venv with exactly what the requirement files say; the stamp spares the second run the network.
_ssv_make_venv() {
    local lcm=$SSV_ROOT/host/requirements.txt mavlink=$SSV_ROOT/firmware/link/requirements.txt
    local stamp=$SSV_BUILD/venv/requirements.stamp wanted
    wanted="$(python3 --version) $(cat "$lcm" "$mavlink" | sha256sum) $SSV_BUILD"
    if [[ -f $stamp && $(<"$stamp") == "$wanted" ]]; then
        return
    fi
    _ssv_check_python
    _ssv_step "Making a Python environment" python3 -m venv --clear "$SSV_BUILD/venv"
    _ssv_step "Fetching LCM and pymavlink" "$SSV_PYTHON" -m pip install --no-deps --only-binary :all: --require-hashes \
        -r "$lcm" -r "$mavlink"
    printf '%s\n' "$wanted" >"$stamp"
}

# The tools of the checks, in build/venv beside LCM; their own stamp spares the second run the network.
_ssv_fetch_checks() {
    local requirements=$SSV_ROOT/tests/requirements-check.txt stamp=$SSV_BUILD/venv/requirements-check.stamp wanted
    wanted=$(sha256sum <"$requirements")
    if [[ -f $stamp && $(<"$stamp") == "$wanted" ]]; then
        return
    fi
    _ssv_step "Fetching clang-format" "$SSV_PYTHON" -m pip install --no-deps --only-binary :all: --require-hashes -r "$requirements"
    printf '%s\n' "$wanted" >"$stamp"
}

# A build folder holds the path of its checkout; cmake refuses it, at length, after either has moved.
_ssv_refuse_moved_checkout() {
    local home
    home=$(sed -n 's/^CMAKE_HOME_DIRECTORY:INTERNAL=//p' "$SSV_BUILD/CMakeCache.txt" 2>/dev/null) || return 0
    if [[ -n $home && ! $home -ef $SSV_ROOT ]]; then
        _ssv_die "$SSV_BUILD was made for the checkout $home, this one is $SSV_ROOT." \
            "Remove it and run the script again, which makes it anew:" \
            "  rm -rf $SSV_BUILD"
    fi
}

ssv_build() {
    local folder=$1
    _ssv_step "Configuring ${folder#"$SSV_ROOT/"}" cmake -S "$SSV_ROOT" -B "$folder" -G Ninja -DPython3_EXECUTABLE="$SSV_PYTHON" \
        -DCMAKE_PREFIX_PATH="$("$SSV_PYTHON" -c 'import sysconfig; print(sysconfig.get_path("platlib"))')" "${@:2}"
    _ssv_step "Building ${folder#"$SSV_ROOT/"}" cmake --build "$folder"
}

# build/NAME, an environment with exactly tests/requirements-NAME.txt: what the long run alone takes, and what does not
# work from a folder on the module path.
_ssv_fetch_environment() {
    local folder=$SSV_BUILD/$1 requirements=$SSV_ROOT/tests/requirements-$1.txt wanted
    local stamp=$folder/requirements.stamp
    wanted="$(python3 --version) $(sha256sum <"$requirements")"
    if [[ -f $stamp && $(<"$stamp") == "$wanted" ]]; then
        return
    fi
    _ssv_step "Making an environment for $1" python3 -m venv --clear "$folder"
    _ssv_step "Fetching $1" "$folder/bin/python" -m pip install --no-deps --only-binary :all: --require-hashes -r "$requirements"
    printf '%s\n' "$wanted" >"$stamp"
}

# build/judges with exactly tests/requirements-judges.txt: packages that the tests alone import.
_ssv_fetch_judges() {
    local requirements=$SSV_ROOT/tests/requirements-judges.txt stamp=$SSV_BUILD/judges/requirements.stamp wanted
    wanted="$(python3 --version) $(sha256sum <"$requirements")"
    if [[ -f $stamp && $(<"$stamp") == "$wanted" ]]; then
        return
    fi
    rm -rf "$SSV_BUILD/judges"
    _ssv_step "Fetching MuJoCo and SciPy" "$SSV_PYTHON" -m pip install --no-deps --only-binary :all: --require-hashes \
        --target "$SSV_BUILD/judges" -r "$requirements"
    printf '%s\n' "$wanted" >"$stamp"
}

ssv_setup() {
    local tests=OFF
    mkdir -p "$SSV_BUILD"
    _ssv_refuse_moved_checkout
    _ssv_install_packages "$@"
    _ssv_make_venv
    if [[ $1 == tests ]]; then
        tests=ON
        _ssv_fetch_checks
        _ssv_step "Looking for Unity" python3 "$SSV_ROOT/tests/support/fetch_unity.py"
        _ssv_fetch_judges
        if [[ -n ${SSV_LONG:-} ]]; then
            _ssv_fetch_environment coal
            _ssv_fetch_environment mavproxy
            _ssv_fetch_environment schedules
        fi
    fi
    ssv_build "$SSV_BUILD" -DSSV_BUILD_TESTS=$tests
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
