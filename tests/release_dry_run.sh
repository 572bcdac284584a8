#!/bin/sh
# Everything of a release but the upload: source archive and wheel from a clean clone at a temporary tag, checked,
# installed where the checkout cannot be seen, and tried on a sample.  What is committed is what is tried.
#   sh tests/release_dry_run.sh PYTHON [VERSION]      "make release-dry-run" gives the project's own Python
set -eu
python=$1
version=${2:-99.0.0}
checkout=$(cd "$(dirname "$0")/.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

echo "== clean clone at v$version"
git clone --quiet "$checkout" "$work/clone"
git -C "$work/clone" -c user.name=release -c user.email=release@localhost tag --message "$version" "v$version"

echo "== source archive and wheel"
"$python" -m venv "$work/builder"
"$work/builder/bin/python" -m pip install --quiet build twine
"$work/builder/bin/python" -m build --outdir "$work/dist" "$work/clone" >"$work/build.log" 2>&1 ||
    { cat "$work/build.log"; exit 1; }
wheel="$work/dist/chipbreak-$version-py3-none-any.whl"
archive="$work/dist/chipbreak-$version.tar.gz"
[ -f "$wheel" ] || { echo "no wheel of version $version:"; ls "$work/dist"; exit 1; }
"$work/builder/bin/python" -m twine check --strict "$archive" "$wheel"

echo "== the wheel, on its own"
"$python" -m venv "$work/fresh"
"$work/fresh/bin/python" -m pip install --quiet "$wheel"
cp "$work/clone/samples/turning.nc" "$work/turning.nc"
cd "$work"
said=$("$work/fresh/bin/chipbreak" --version)
case $said in *"$version"*) echo "$said" ;; *) echo "--version says: $said"; exit 1 ;; esac
"$work/fresh/bin/chipbreak" filter -p generic-lathe turning.nc -o wheel.nc
"$work/fresh/bin/chipbreak" restore wheel.nc | cmp - turning.nc
if cmp -s wheel.nc turning.nc; then echo "the sample was not changed at all"; exit 1; fi

echo "== the same from the source archive"
"$work/builder/bin/python" -m venv "$work/from_source"
"$work/from_source/bin/python" -m pip install --quiet "$archive"
"$work/from_source/bin/chipbreak" filter -p generic-lathe turning.nc | cmp - wheel.nc

echo "== the same as the checkout"
PYTHONPATH="$work/clone/src" "$work/fresh/bin/python" -m chipbreak filter -p generic-lathe turning.nc | cmp - wheel.nc
echo "release $version could go out; nothing was uploaded"
