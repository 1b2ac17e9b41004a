#!/bin/bash
# Runs one test for prove: run.sh TEST [--long]. The test speaks TAP; what it says is kept in
# build/logs too.
# SPDX-License-Identifier: MIT
logs=${BUILD:-build}/logs
mkdir -p "$logs"
export CMOCKA_MESSAGE_OUTPUT=TAP
[ "${2:-}" != --long ] || export SSS_TEST_LONG=1

# cmocka 1.1 calls a skipped test "not ok", and its closing line says nothing new.
{
    case $1 in
    *.sh) bash "$@" ;;
    *) "$@" ;;
    esac
} 2>&1 | sed -u -e 's/^not ok \([0-9]* # SKIP\)/ok \1/' -e '/^# ok - /d' |
    tee "$logs/$(basename "$1").log"
exit "${PIPESTATUS[0]}"
