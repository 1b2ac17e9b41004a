#!/bin/sh
# Joins files into one text and prints it as a C array: embed.sh NAME FILE... > NAME.h. What the
# files include by "name" must come before them, here or in another array, so those lines are taken
# out.
# SPDX-License-Identifier: MIT
set -eu
name=$1
shift
for file in "$@"; do # before a word is printed, as a pipe would hide it
    [ -r "$file" ] || { echo "embed.sh: cannot read $file" >&2 && exit 1; }
done
echo '// Made by cl/embed.sh: a text of OpenCL C, ended by 0.'
echo "static const unsigned char $name[] = {"
for file in "$@"; do
    echo "#line 1 \"${file##*/}\"" # a build log then names the right file and line
    sed 's/^ *#include "[^"]*".*$//' "$file"
done | od -An -v -tu1 | sed 's/ *\([0-9][0-9]*\)/\1,/g'
echo '0};'
