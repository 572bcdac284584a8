#!/bin/sh
# Installs LinuxCNC for the tests marked "linuxcnc": as root, where apt-get knows the package.
# Everywhere else it says so in one line and ends with success, because those tests are then skipped.
set -u

package=linuxcnc-uspace
have() { command -v "$1" >/dev/null 2>&1; }
give_up() { echo "LINUXCNC IS NOT INSTALLED ($1): the tests that need it will be skipped." >&2; exit 0; }

if have rs274 && have linuxcnc && have halsampler && have ip && have gcc && have Xvfb && have xdotool; then exit 0; fi
have apt-get || give_up "no apt-get here; on Debian 12 it is the package $package"
[ "$(id -u)" -eq 0 ] || give_up "not root; run: sudo sh tests/linuxcnc/install.sh"

export DEBIAN_FRONTEND=noninteractive
log=$(mktemp)
# Without the recommended packages: they bring a realtime kernel, which a simulated machine does not need.
# xvfb and xdotool are for AXIS, on a display that nobody sees.
install() { apt-get install -y --no-install-recommends "$package" gcc libc6-dev iproute2 util-linux xvfb xdotool; }
echo "Installing $package for the tests; log in $log" >&2
if install >"$log" 2>&1 || { apt-get update >>"$log" 2>&1 && install >>"$log" 2>&1; }; then
    rm -f "$log"
else
    give_up "apt-get failed: $(grep '^E:' "$log" | tail -n 1)"
fi
