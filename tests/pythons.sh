#!/bin/sh
# Runs the fast part of the tests on every Python that the package names, as far as this machine has it: the one
# on PATH, else the newest one of pyenv.  A Python that is not here is said and left out.
#   sh tests/pythons.sh FOLDER TEST...      environments go into FOLDER; "make test-pythons" fills in both
set -u
folder=$1
shift
cd "$(dirname "$0")/.." || exit 2

runs() { "$1" -c "import sys; sys.exit('%d.%d' % sys.version_info[:2] != '$2')" 2>/dev/null; }

find_python() { # 3.12 -> the path of an interpreter that really runs, or nothing
    on_path=$(command -v "python$1") && runs "$on_path" "$1" && echo "$on_path" && return
    # Of several the last one by version number.
    for candidate in $(ls -d "${PYENV_ROOT:-$HOME/.pyenv}/versions/$1".*/bin/python 2>/dev/null | sort -rV); do
        runs "$candidate" "$1" && echo "$candidate" && return
    done
}

tried=""
failed=""
for version in 3.11 3.12 3.13 3.14; do
    python=$(find_python "$version")
    if [ -z "$python" ]; then
        echo "PYTHON $version IS NOT HERE: not tried"
        continue
    fi
    echo "== Python $version: $python"
    tried="$tried $version"
    environment="$folder/python$version"
    [ -x "$environment/bin/python" ] || "$python" -m venv "$environment"
    if ! "$environment/bin/python" -m pip install --quiet --require-hashes --requirement tests/requirements.txt ||
        ! "$environment/bin/python" -m pip install --quiet --no-deps --no-build-isolation --editable . ||
        ! "$environment/bin/python" -m pytest -q -n auto "$@"; then
        failed="$failed $version"
    fi
done
[ -n "$tried" ] || { echo "no Python was tried"; exit 1; }
[ -z "$failed" ] || { echo "failed on Python$failed"; exit 1; }
echo "passed on Python$tried"
