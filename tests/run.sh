#!/usr/bin/env bash
# Set up and run the tests, on each supported Python that is found:
# 3.11 with Blender 4.5 LTS and 3.13 with Blender 5.2 LTS, side by side, a core each.
#
#   tests/run.sh [--all] [--twice] [PYTEST'S ARGUMENTS]
#
# --all fails when one of the two Pythons is not found. Without arguments for pytest everything
# runs; -m "not slow" leaves out what takes long. Each slow test of core, which knows nothing of
# Blender, runs on one of the two Pythons, and with --twice on both.
set -uo pipefail
cd "$(dirname "$0")/.."
source tests/environment.sh

demand_all=false
twice=false
while true; do
    case "${1:-}" in
    --all) demand_all=true ;;
    --twice) twice=true ;;
    *) break ;;
    esac
    shift
done
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 MPLBACKEND=Agg PYTHONDONTWRITEBYTECODE=1

pythons=()
for version in 3.11 3.13; do
    if base=$(find_python $version); then
        python=$(make_environment $version "$base") && check_system "$python" || exit 1
        pythons+=("$python")
    elif $demand_all; then
        echo "Python $version is not found. Install it with its venv module." >&2
        exit 1
    else
        echo "Python $version is not found: its tests are left out." >&2
    fi
done
if [ ${#pythons[@]} -eq 0 ]; then
    echo "Python 3.11 or 3.13 is needed. On Debian 12: apt-get install python3 python3-venv" >&2
    exit 1
fi

logs=$(mktemp -d)
trap 'kill $(jobs -p) 2>/dev/null; rm -rf "$logs"' EXIT
shares=(1/1 1/1)
if [ ${#pythons[@]} -eq 2 ]; then
    $twice || shares=(1/2 2/2)
    "${pythons[1]}" -m pytest -p no:cacheprovider --share ${shares[1]} "$@" >"$logs/second" 2>&1 &
    second=$!
fi
"${pythons[0]}" -m pytest -p no:cacheprovider --share ${shares[0]} "$@" 2>&1 | tee "$logs/first"
status=$?
if [ -n "${second:-}" ]; then
    wait "$second"
    other=$?
    cat "$logs/second"
    # One of the two may have nothing to run of what is asked for, which is pytest's code 5.
    if [ $status -eq 0 ] && [ $other -ne 5 ] || [ $status -eq 5 ]; then
        status=$other
    fi
    # The last line is the closing line of a run that failed, if one did.
    tail -n 1 "$logs/second" | grep -q failed || [ $status -eq 0 ] || tail -n 1 "$logs/first"
fi
exit $status
