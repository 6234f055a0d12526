#!/usr/bin/env bash
# Sets everything up, runs the quick matrix, writes its report and prints its path.
#
#   ./reproduce.sh                       results/ and results/report/
#   ./reproduce.sh --preset standard     further arguments go to `oitbench run`
#   ./reproduce.sh --setup-only [EXTRA]  the set-up alone, with an optional extra of pyproject.toml
#
# Needs Debian or Ubuntu with Python 3.10 or newer; PYTHON names another interpreter. It can be
# run again; installed parts are kept, unless PYTHON has another version than they were made with.
set -euo pipefail

root=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd)
system_python=${PYTHON:-python3}
python=$root/.venv/bin/python

say() { printf '%s\n' "$*" >&2; }
fail() { say "${0##*/}: $*"; exit 1; }

check_python() {
    command -v "$system_python" >/dev/null ||
        fail "there is no $system_python; apt-get install python3, or set PYTHON"
    "$system_python" -c 'import sys; sys.exit(sys.version_info < (3, 10))' ||
        fail "$("$system_python" -V) is too old; Python 3.10 is the oldest that works (set PYTHON)"
}

# Succeeds if the dynamic linker finds a library with a matching name.
has_library() {
    PATH="$PATH:/usr/sbin:/sbin" ldconfig -p | grep -E "^[[:space:]]*$1" >/dev/null
}

has_gl_driver() {
    dpkg-query --show --showformat='${db:Status-Status}' libgl1-mesa-dri 2>/dev/null |
        grep -qx installed || has_library 'libEGL_nvidia\.so' || has_library 'libgallium-'
}

# The LLVM package to install: 19 if the distribution has it, else the newest that drjit can use, else
# $1. Without LLVM, path tracing uses a slower variant.
llvm_package() {
    local known
    known=$(apt-cache search --names-only '^libllvm(1[7-9]|2[0-2])(t64)?$' 2>/dev/null | cut -d' ' -f1)
    [[ -n ${known:=$1} ]] || return 0
    grep -E '^libllvm19(t64)?$' <<<"$known" || sort --version-sort <<<"$known" | tail -n 1
}

# Prints the missing packages; $1 is the LLVM to install if none is known. drjit aborts with an LLVM
# before 17.
missing_packages() {
    "$system_python" -c 'import ensurepip, venv' 2>/dev/null || echo python3-venv
    has_library 'libatomic\.so\.1' || echo libatomic1
    has_library 'libEGL\.so\.1' || echo libegl1
    has_library 'libGL\.so\.1' || echo libgl1
    has_gl_driver || echo libgl1-mesa-dri
    has_library 'libLLVM(-|\.so\.)(1[7-9]|2[0-2])([. ]|$)' || llvm_package "$1"
}

install_packages() {
    local missing as_root=()
    readarray -t missing < <(missing_packages libllvm19)
    ((${#missing[@]})) || return 0
    if [[ $(id -u) != 0 ]]; then as_root=(sudo -n); fi
    if ! command -v apt-get >/dev/null || ! "${as_root[@]}" true 2>/dev/null; then
        say "System libraries are missing. Install them, then run this again:"
        say "  sudo apt-get install -y --no-install-recommends ${missing[*]}"
        exit 1
    fi
    "${as_root[@]}" apt-get update -qq || say "apt-get update failed; trying the packages that are known"
    readarray -t missing < <(missing_packages '') # The update may have made an LLVM known.
    ((${#missing[@]})) || return 0
    say "Installing ${missing[*]} ..."
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
        apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
}

# Prints the version of a Python interpreter.
version_of() {
    "$1" -c 'import platform; print(platform.python_version())'
}

# Succeeds if .venv works, and has the version of the interpreter that PYTHON names, if it is set.
has_environment() {
    "$python" -m pip --version >/dev/null 2>&1 || return 1
    [[ -z ${PYTHON:-} || $(version_of "$python") == "$(version_of "$PYTHON")" ]]
}

# Makes .venv with the project and an extra; returns at once if this pyproject.toml is installed.
install_project() {
    local extra=${1:-} stamp=$root/.venv/installed wanted
    wanted="$(cksum <"$root/pyproject.toml") $root"
    if [[ -n $extra ]]; then stamp+=-$extra; fi
    if ! has_environment; then
        say "Making .venv ..."
        "$system_python" -m venv --clear "$root/.venv"
    elif [[ -f $stamp && $(<"$stamp") == "$wanted" ]]; then
        return 0
    fi
    say "Installing oitbench and its dependencies into .venv (a minute or two the first time) ..."
    "$python" -m pip install -qq --disable-pip-version-check -e "$root${extra:+[$extra]}"
    tee "$root/.venv/installed" <<<"$wanted" >"$stamp"
}

# Prints the folder of results: the last --out among the arguments.
results_folder() {
    local folder=$root/results
    while (($#)); do
        case $1 in
        --out) folder=${2:-} ;;
        --out=*) folder=${1#--out=} ;;
        esac
        shift
    done
    printf '%s\n' "$folder"
}

check_python
install_packages
if [[ ${1:-} == --setup-only ]]; then
    install_project "${2:-}"
    exit
fi
install_project
results=$(results_folder "$@")
"$python" -m oitbench run --out "$results" "$@"
say "Writing the report ..."
say "Report: $("$python" -m oitbench report "$results")"
