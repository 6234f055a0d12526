#!/usr/bin/env bash
# Sets everything up like reproduce.sh, then checks format, lint, types and layers, and runs the
# tests. Arguments go to pytest. All checks run; the script fails if one of them does.
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
check pytest -n auto --dist loadfile "$@"
exit "$failed"
