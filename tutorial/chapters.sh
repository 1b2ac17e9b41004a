# What tutorial/make.sh, tutorial/page/build.sh and tests/test_tutorial.sh share; sourced from the
# top of the repository. SPDX-License-Identifier: MIT

# The chapters' folders, in the order of the table of contents, the appendix (A) last.
chapters() { sed -n 's|^[0-9A]*\. \[.*\](\([a-z]*\)/README\.md).*|\1|p' tutorial/README.md; }

# block N FILE: the commands of its Nth sh block; nothing when there is none.
block() {
    awk -v n="$1" '/^```/ { in_block = $0 == "```sh"; count += in_block; next } in_block && count == n' "$2"
}

# Where a chapter's listings may come from.
sources() { echo "tutorial/$1/main.c" tutorial/*.h; }

# weave SLUG OUTPUT: the chapter's text with its listings, output and numbers as they should be.
weave() {
    awk -v sources="$(sources "$1")" -v output="$2" -f tutorial/weave.awk "tutorial/$1/README.md"
}
