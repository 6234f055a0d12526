#!/usr/bin/env bash
# Runs the tests with the lowest and with the newest versions of all packages that pyproject.toml
# allows. Each set has an environment of its own, which is kept and brought up to date.
#
#   tests/benchmarks/versions.sh [PYTEST ARGUMENT ...]
#
# VERSIONS names the folder of the environments (default: ~/.cache/oitbench/versions), PYTHON the
# interpreter. The lowest versions have no wheels for Python 3.13 and newer.
set -euo pipefail

root=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/../.." && pwd)
folder=${VERSIONS:-${XDG_CACHE_HOME:-$HOME/.cache}/oitbench/versions}

# Prints every bound NAME>=VERSION of pyproject.toml as NAME==VERSION.
lowest() {
    sed -nE 's/^ *"([A-Za-z0-9-]+)>=([0-9.]+)",$/\1==\2/p' "$root/pyproject.toml"
}

# Installs the project into the environment $1 with the arguments for pip that follow, and tests it.
check() {
    local python=$folder/$1/bin/python
    shift
    printf '== %s\n' "$python" >&2
    [[ -x $python ]] || "${PYTHON:-python3}" -m venv "${python%/bin/python}" || return 1
    "$python" -m pip install -q --disable-pip-version-check "$@" -e "$root[test]" &&
        "$python" -m pip check &&
        "$python" -m pytest --rootdir "$root" "${arguments[@]}"
}

arguments=("$@")
mkdir -p "$folder"
cd -- "$root"
lowest >"$folder/lowest.txt"
failed=0
check lowest --constraint "$folder/lowest.txt" || failed=1
check newest --upgrade --upgrade-strategy eager || failed=1
exit "$failed"
