#!/bin/bash
# tile --quick prints both tables. What is sure of its figures: grey media have one exit whatever
# per_channel says, a medium that no rule shares has the variance of its own lookups, and sharing
# pays where a length is many pixels. Run from the top of the repository. SPDX-License-Identifier:
# MIT
set -u
. tests/check.sh
tile=$build/tile
needs "$tile"

tables() {
    "$tile" --quick >"$work/table" || return 1
    awk '
        $2 == "grey" && $4 == "pixels" { grey++; if ($NF != "1.0000") bad = "grey alone: " $0 }
        # Least lengths of 1 and 2 pixels share nothing of a dmfp of 2 pixels or less.
        $4 == "pixels" && $3 <= 2 { few++; if ($10 != $NF || $11 != $NF) bad = "not shared: " $0 }
        $4 == "pixels" && $3 == 100 { many++; if (!($9 < 0.9 * $NF)) bad = "does not pay: " $0 }
        / candidate/ { plans++ }
        /nan|inf/ { bad = "no number: " $0 }
        END {
            if (grey != 24 || few != 24 || many != 6 || plans != 16)
                bad = "rows: " grey " " few " " many " " plans
            if (bad) { print bad; exit 1 }
        }' "$work/table"
}

check "tile --help" sh -c "'$tile' --help | grep -q '^usage: '"
check "tile --quick" tables
finish
