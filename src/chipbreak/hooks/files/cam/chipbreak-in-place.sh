#!/bin/sh
# A CAM system runs this with the name of the program that it has just posted, as its last argument.
# A rejected program is taken away from its place, so that nobody runs it: NAME.rejected says why, NAME.unfiltered is it.
for program in "$@"; do :; done
"@CHIPBREAK@" filter -p "${CHIPBREAK_PROFILE:-@PROFILE@}" -i --fresh --backup .unfiltered --reject-file \
    --log "$(dirname "$program")/chipbreak.log" "$program"
code=$?
[ "$code" -eq 0 ] || mv -f "$program" "$program.unfiltered"
exit "$code"
