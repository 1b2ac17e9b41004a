#!/bin/sh
# Joins files into one text and prints it as a C array: embed.sh FILE... > sss_cl_source.h. What the files include from
# each other by "name" must come before them on the command line, so those lines are taken out.
# SPDX-License-Identifier: MIT
set -eu
for file in "$@"; do # before a word is printed, as a pipe would hide it
    [ -r "$file" ] || { echo "embed.sh: cannot read $file" >&2 && exit 1; }
done
echo '// Made by cl/embed.sh: the text of the kernels and of all that they include, ended by 0.'
echo 'static const unsigned char sss_cl_source[] = {'
for file in "$@"; do
    echo "#line 1 \"${file##*/}\"" # a build log then names the right file and line
    sed 's/^ *#include "[^"]*".*$//' "$file"
done | od -An -v -tu1 | sed 's/ *\([0-9][0-9]*\)/\1,/g'
echo '0};'
