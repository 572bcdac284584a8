#!/bin/sh
# The program as one file, made as docs/install.md says: sh tests/one_file.sh PYTHON
# PYTHON is that of an environment with pyinstaller and a wheel of this checkout (make wheel); it takes minutes.
set -eu
python=$1
page=$(cd "$(dirname "$0")/.." && pwd)/docs/install.md
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
sed -n 's/^    \(from multiprocessing import freeze_support\|from chipbreak.cli import main\|freeze_support()\|main()\)$/\1/p' \
    "$page" > run.py
eval "$python $(sed -n 's/^    py \(-m PyInstaller .*\)$/\1/p' "$page")" > build.log 2>&1 || { tail build.log; exit 1; }
mkdir in
printf 'G97 S3000 M3\nG0 X20. Z2.\nG1 Z-3. F0.05 N1.5\nM30\n' > part.nc
cp part.nc in/O0001
cp part.nc in/O0002
alone() { env -i HOME="$folder" PATH=/usr/bin:/bin ./dist/chipbreak "$@"; }
alone filter -q -p generic-lathe part.nc -o out.nc
alone restore out.nc -o back.nc
cmp part.nc back.nc
alone batch -q -p generic-lathe -j 2 in -o filtered
cmp out.nc filtered/O0001
cmp out.nc filtered/O0002
alone hooks write cam -p generic-lathe -o hooks > /dev/null
echo "$(alone --version): one file of $(wc -c < dist/chipbreak) bytes filters, restores and starts workers"
