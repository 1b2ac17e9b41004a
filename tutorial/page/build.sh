#!/bin/bash
# Builds the tutorial as one page that needs no network, build/page/index.html: the chapters' text,
# their figures, and the live figures with sss_resample.h compiled to WebAssembly behind them. Run
# from the top of the repository. SPDX-License-Identifier: MIT
set -euo pipefail
. tutorial/chapters.sh
out=build/page
page=tutorial/page
most=2000000 # bytes
mkdir -p $out/pictures

# ---- The header and figures.c, freestanding. The options are those of the programs: the same bits.

exact='-ffp-contract=off -fno-math-errno -fno-trapping-math'
strict='-Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror'
clang --target=wasm32 -msimd128 -mbulk-memory -std=c99 -O3 -ffreestanding -nostdlib $exact $strict \
    -I. $page/figures.c -Wl,--no-entry -Wl,--strip-all -Wl,-z,stack-size=262144 \
    -o $out/figures.wasm

{
    echo '"use strict";'
    echo '{'
    cat $page/live.js $page/figures/*.js
    echo "start(\"$(base64 -w 0 $out/figures.wasm)\");"
    echo '}'
} >$out/script.js

# ---- The text. Pictures of noise are smaller as WebP.

for slug in $(chapters); do
    cwebp -quiet -q 60 -m 6 "tutorial/$slug/figure.png" -o "$out/pictures/$slug.webp"
done

# Pictures on a line of their own: a drawing, and a still, which is the place of its live figure.
drawing='<figure class="drawing"><img src="tutorial/drawings/\2.svg" alt="\1"></figure>'
still='<img src="tutorial/page/still/\2.webp" alt="\1"><figcaption>\1</figcaption>'
still="<figure class=\"live\" id=\"live-\\2\">$still</figure>"

# A chapter (or the contents) as pandoc wants it: formulas between $$, links into the page, the slug
# as its name.
part() {
    sed -e '/^```math$/,/^```$/s/^```\(math\)\{0,1\}$/$$/' -e 's/<!-- [^>]* -->//g' \
        -e "1s/\$/ {#$1}/" -e "s|](figure\.png)|]($out/pictures/$1.webp)|" \
        -e "s|^!\[\(.*\)\](../page/still/\([a-z]*\)\.webp)\$|$still|" \
        -e "s|^!\[\(.*\)\](../drawings/\([a-z]*\)\.svg)\$|$drawing|" \
        -e 's|](../README\.md)|](#contents)|g' \
        -e 's|](\(\.\./\)\{0,1\}\([a-z]*\)/README\.md)|](#\2)|g' \
        -e 's|](\(\.\./\)\{0,1\}\([a-z]*\)\.h)|](../../tutorial/\2.h)|g' "$2"
    echo
}

# Some browsers blow up parentheses that may stretch, and no formula here needs that.
{
    part contents tutorial/README.md
    for slug in $(chapters); do part "$slug" "tutorial/$slug/README.md"; done
} | pandoc -f gfm+tex_math_dollars+attributes -t html5 --mathml --self-contained \
    --toc --toc-depth=1 --metadata title='Subsurface scattering in an afternoon' --metadata lang=en \
    --template $page/template.html --fail-if-warnings |
    sed -e 's|stretchy="true" form="\(prefix\)">(|stretchy="false" form="\1">(|g' \
        -e 's|stretchy="true" form="\(postfix\)">)|stretchy="false" form="\1">)|g' \
        -e "/^@script@\$/{r $out/script.js" -e 'd}' >$out/index.html

size=$(wc -c <$out/index.html)
echo "$out/index.html: $size bytes"
if [ "$size" -ge $most ]; then
    echo "page: $size bytes are too many: $((most - 1)) at most" >&2
    exit 1
fi
