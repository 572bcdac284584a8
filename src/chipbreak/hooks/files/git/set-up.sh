#!/bin/sh
# Run inside a repository of NC programs: git then compares them by what their blocks say.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
cat "$here/gitattributes.part" >> "$(git rev-parse --show-toplevel)/.gitattributes"
git config diff.nc.command '"@CHIPBREAK@" git-diff'
git config diff.nc.textconv '"@CHIPBREAK@" textconv'
