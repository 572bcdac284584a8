#!/bin/sh
# Run inside a repository of NC programs: git then compares them by what their blocks say.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
attributes="$(git rev-parse --show-toplevel)/.gitattributes"
while IFS= read -r line; do
    grep -qxF "$line" "$attributes" 2>/dev/null || printf '%s\n' "$line" >> "$attributes"
done < "$here/gitattributes.part"
git config diff.nc.command '"@CHIPBREAK@" git-diff'
git config diff.nc.textconv '"@CHIPBREAK@" textconv'
