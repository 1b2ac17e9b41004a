#!/bin/bash
# Runs the commands that the chapters print, and makes their figures, listings and quoted numbers
# anew from what comes out: make.sh [SLUG ...], all chapters without one. Run from the top of the
# repository. SPDX-License-Identifier: MIT
set -eu
. tutorial/chapters.sh
mkdir -p build
[ $# -gt 0 ] || set -- $(chapters)
for slug in "$@"; do
    echo "$slug"
    block 1 "tutorial/$slug/README.md" >"build/$slug.commands"
    bash -eu "build/$slug.commands" >"build/$slug.output"
    weave "$slug" "build/$slug.output" >"build/$slug.md"
    cp "build/$slug.md" "tutorial/$slug/README.md"
    cp "build/$slug.png" "tutorial/$slug/figure.png"
done
