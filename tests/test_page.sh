#!/bin/bash
# The live page: it builds, and does what it says in Chromium. The checks are tests/page.py; what
# this needs is installed by make setup-page. Run from the top of the repository.
# SPDX-License-Identifier: MIT
set -eu
for tool in clang wasm-ld pandoc cwebp chromium chromedriver python3; do
    command -v $tool >/dev/null && continue
    echo "ok 1 - the live page # SKIP $tool is not here: make setup-page"
    echo '1..1'
    exit 0
done
make --no-print-directory page build/page/figures >&2
exec python3 tests/page.py
