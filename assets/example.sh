#!/usr/bin/env bash
# Set up, calibrate the example, and bake it: report, picture and .blend go into the folder `out`.
#
#   assets/example.sh [CASE.toml]
set -euo pipefail
cd "$(dirname "$0")/.."
source tests/environment.sh

example=(assets/*/case.toml)
case=${1:-${example[0]}}
base=$(find_python 3.11 || find_python 3.13) || {
    echo "Python 3.11 or 3.13 is needed. On Debian 12: apt-get install python3 python3-venv" >&2
    exit 1
}
version=$("$base" -c "import sys; print('%d.%d' % sys.version_info[:2])")
python=$(make_environment "$version" "$base")
check_system "$python"

mkdir -p out
"$python" addon/batch.py -- "$case" \
    --out out/report.json --plot out/report.png --bake out/baked.blend
echo
echo "The whole report, the picture and the baked object:"
ls -l out/report.json out/report.png out/baked.blend
if [ -n "${DISPLAY:-}${WAYLAND_DISPLAY:-}" ] && command -v xdg-open >/dev/null; then
    xdg-open out/report.png >/dev/null 2>&1 &
fi
