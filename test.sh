#!/usr/bin/env bash
# The same set-up as reproduce.sh, then format, lint, types, layers and tests; arguments go to pytest.
# All of them run; it fails if one of them does.
set -euo pipefail

cd -- "$(dirname -- "${BASH_SOURCE[0]}")"
./reproduce.sh --setup-only test

failed=0
check() {
    printf '== %s\n' "$*" >&2
    ".venv/bin/$1" "${@:2}" || failed=1
}
check ruff format --check .
check ruff check .
check mypy
check lint-imports --no-cache
check pytest "$@"
exit "$failed"
