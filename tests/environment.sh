# Sourced by tests/run.sh, assets/example.sh and .ci/run: finds Pythons, makes environments.
# Each environment is a folder .venv-X.Y beside the sources, made anew when a requirement changes.

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

# The packages of a bare Debian 12 that `import bpy` and rendering need.
system_packages="libx11-6 libxrender1 libxfixes3 libxi6 libxkbcommon0 libsm6 libgl1 libegl1 libgl1-mesa-dri"

# find_python X.Y: print the path of a working Python of that version that can make environments.
find_python() {
    local version=$1 candidate
    for candidate in "python$version" python3 python \
        "${PYENV_ROOT:-$HOME/.pyenv}"/versions/"$version"*/bin/python3 \
        "$HOME"/.local/share/uv/python/cpython-"$version"*/bin/python3 \
        "$HOME"/.asdf/installs/python/"$version"*/bin/python3 \
        /usr/local/bin/"python$version" /opt/python*/bin/"python$version" \
        /opt/hostedtoolcache/Python/"$version"*/x64/bin/python3; do
        # A version manager's shim may exist and yet refuse to run: ask it.
        if "$candidate" -c "import ensurepip, venv, sys
sys.exit('%d.%d' % sys.version_info[:2] != '$version')" >/dev/null 2>&1; then
            command -v "$candidate"
            return 0
        fi
    done
    return 1
}

# make_environment X.Y PYTHON: print the path of the environment's Python, ready to use.
make_environment() {
    local version=$1 python=$2
    local folder=$root/.venv-$version
    local stamp
    stamp="$python $(cat "$root"/requirements.txt "$root"/requirements-dev.txt | sha256sum)"
    if [ "$(cat "$folder/ready" 2>/dev/null)" != "$stamp" ]; then
        echo "Installing Blender as a module and the libraries for Python $version" \
            "(about 1.5 GB) into $folder ..." >&2
        rm -rf "$folder"
        "$python" -m venv "$folder" >&2 || return 1
        "$folder/bin/python" -m pip install -q --disable-pip-version-check \
            --only-binary :all: -r "$root/requirements-dev.txt" >&2 || return 1
        echo "$stamp" >"$folder/ready"
    fi
    echo "$folder/bin/python"
}

# check_system: say which system packages `import bpy` lacks, if any.
check_system() {
    local python=$1
    if ! "$python" -c "import bpy" 2>/tmp/ringdown-import-$$; then
        tail -n 1 /tmp/ringdown-import-$$ >&2
        rm -f /tmp/ringdown-import-$$
        echo "Blender's libraries are missing. On Debian: apt-get install $system_packages" >&2
        return 1
    fi
    rm -f /tmp/ringdown-import-$$
}
