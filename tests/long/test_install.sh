#!/bin/bash
# An example, built in each way that others take the header by: CMake's three and pkg-config. Each
# prints the digits of the example as the repository builds it. Run from the top of the repository.
# SPDX-License-Identifier: MIT
set -u
. tests/check.sh

# The installed header has no repository around it: only examples/ is copied.
build_directly() {
    gcc -std=c99 -O1 -ffp-contract=off -I. examples/all_hits.c -o "$work/direct" -lm &&
        "$work/direct" >"$work/digits"
}
same_digits() { "$1" >"$work/other" && cmp "$work/digits" "$work/other"; }

by_cmake() { # WAY SOURCE [OPTIONS]
    local way=$1 source=$2
    shift 2
    rm -rf "$work/by"
    cmake -S tests/consumer -B "$work/by" -DWAY="$way" -DSOURCE="$source" "$@" &&
        cmake --build "$work/by" &&
        same_digits "$work/by/consumer"
}
by_package() { # PREFIX [OPTIONS]: the source tree has no header then
    mkdir -p "$work/bare/examples" && cp examples/*.[ch] "$work/bare/examples/" &&
        by_cmake package "$work/bare" -DCMAKE_PREFIX_PATH="$@"
}
by_pkg_config() { # PREFIX
    local flags
    flags=$(PKG_CONFIG_PATH=$1/share/pkgconfig pkg-config --cflags --libs sss_resample) || return 1
    gcc -std=c99 -O1 -ffp-contract=off "$work/bare/examples/all_hits.c" -o "$work/with_flags" $flags &&
        same_digits "$work/with_flags"
}
by_cmake_install() {
    cmake -S . -B "$work/own" && cmake --install "$work/own" --prefix "$work/cmake prefix"
}
same_files() { diff -r "$work/prefix" "$work/cmake prefix"; }
too_new() { ! by_package "$work/prefix" -DWANTED=99.0; }
asks_for_this() {
    by_package "$work/prefix" -DWANTED="$(sed -n '1s/.* v\([0-9.]*\) .*/\1/p' sss_resample.h)"
}

check "the example as it is built here" build_directly
check "make install" make -s install PREFIX="$work/prefix"
if have cmake; then
    check "add_subdirectory" by_cmake subdirectory "$PWD"
    check "FetchContent" by_cmake fetch "$PWD"
    check "find_package after make install" by_package "$work/prefix"
    check "find_package asks for this version" asks_for_this
    check "find_package refuses a version to come" too_new
    check "cmake --install" by_cmake_install
    check "find_package after cmake --install" by_package "$work/cmake prefix"
    check "both install the same" same_files
else
    skip "CMake" "cmake is not here: make setup-long"
fi
if have pkg-config; then check "pkg-config" by_pkg_config "$work/prefix"
else skip "pkg-config" "it is not here: make setup-long"; fi
finish
