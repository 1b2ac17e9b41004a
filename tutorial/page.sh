#!/bin/bash
# Prints the whole tutorial as one static page: page.sh > build/tutorial.html. Formulas become MathML, figures are in
# the page, and nothing is fetched from anywhere. Run from the top of the repository. SPDX-License-Identifier: MIT
set -euo pipefail
. tutorial/chapters.sh

# Some browsers blow up parentheses that may stretch, and no formula here needs that.

# A chapter (or the contents) as pandoc wants it: formulas between $$, links into the page, the slug as its name.
part() {
    sed -e '/^```math$/,/^```$/s/^```\(math\)\{0,1\}$/$$/' -e 's/<!-- [^>]* -->//g' \
        -e "1s/\$/ {#$1}/" -e "s|](figure\.png)|](tutorial/$1/figure.png)|" \
        -e 's|](../../|](../|g' -e 's|](../README\.md)|](#contents)|g' \
        -e 's|](\(\.\./\)\{0,1\}\([a-z]*\)/README\.md)|](#\2)|g' -e 's|](tutorial\.h)|](../tutorial/tutorial.h)|' "$2"
    echo
}

{
    part contents tutorial/README.md
    for slug in $(chapters); do part "$slug" "tutorial/$slug/README.md"; done
} | pandoc -f gfm+tex_math_dollars+attributes -t html5 --mathml --self-contained --toc --toc-depth=1 \
    --metadata title='Subsurface scattering in an afternoon' --metadata lang=en --css tutorial/page.css \
    --template tutorial/page.html --fail-if-warnings |
    sed -e 's|stretchy="true" form="\(prefix\)">(|stretchy="false" form="\1">(|g' \
        -e 's|stretchy="true" form="\(postfix\)">)|stretchy="false" form="\1">)|g'
