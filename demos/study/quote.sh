#!/bin/bash
# quote.sh PAGE ...: puts the figures that demos/study/measured holds into pages that quote them;
# tutorial/weave.awk has the marks. Run from the top of the repository. SPDX-License-Identifier: MIT
set -eu
printed=$(mktemp)
trap 'rm -f "$printed" "$printed.md"' EXIT
cat demos/study/measured/*.txt >"$printed"
for page in "$@"; do
    awk -v output="$printed" -f tutorial/weave.awk "$page" >"$printed.md"
    cp "$printed.md" "$page"
done
