#!/usr/bin/env bash
# Checks oitbench on a machine with a GPU: capabilities, the tests that depend on the driver, the
# stability suite, the quick matrix and its report. It takes less than 8 minutes.
#
#   tests/benchmarks/on_gpu.sh            sets up .venv like test.sh, results in results/gpu
#   tests/benchmarks/on_gpu.sh OUT        results in OUT
#   PYTHON=/path/to/python tests/benchmarks/on_gpu.sh OUT
#                                         uses an interpreter that has all dependencies
#
# Each step runs even if the one before fails; the exit code is 1 if one of them does.
set -uo pipefail

root=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/../.." && pwd)
out=${1:-$root/results/gpu}
mkdir -p "$out"
out=$(cd -- "$out" && pwd)
cd -- "$root"
if [[ -z ${PYTHON:-} ]]; then
    ./reproduce.sh --setup-only test || exit 1
    PYTHON=$root/.venv/bin/python
fi
export PYTHONPATH=$root${PYTHONPATH:+:$PYTHONPATH}
failed=0
step() {
    local name=$1 start=$SECONDS
    shift
    printf '== %s\n' "$name" >&2
    "$@" >"$out/$name.txt" 2>&1 || { failed=1; printf '   failed; see %s\n' "$out/$name.txt" >&2; }
    printf '   %d s\n' $((SECONDS - start)) >&2
}

step doctor "$PYTHON" -m oitbench doctor
step tests "$PYTHON" -m pytest -q -p no:cacheprovider tests/gpu tests/gl tests/methods tests/measure
step stability "$PYTHON" -m oitbench stability --out "$out/stability"
step run "$PYTHON" -m oitbench run --out "$out/run"
step report "$PYTHON" -m oitbench report "$out/run" --out "$out/report"
step table "$PYTHON" -m oitbench report "$out/run" --markdown
cat "$out/table.txt"
exit "$failed"
