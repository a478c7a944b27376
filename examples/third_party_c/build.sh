#!/usr/bin/env sh
# Builds both libraries into the folder that is named, or here; a second argument and more go to both compilers.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
out=${1:-$here}
[ $# -eq 0 ] || shift
flags="-O2 -Wall -Wextra -Wpedantic -shared -fPIC -fvisibility=hidden"
# shellcheck disable=SC2086 # The flags are words.
"${CC:-cc}" -std=c11 $flags "$@" -I "$here/../../include" "$here/planner.c" -o "$out/libwave.so" -lm
# shellcheck disable=SC2086
"${CXX:-c++}" -std=c++17 $flags "$@" -I "$here/../../include" "$here/localizer.cpp" -o "$out/libdead_reckoning.so"
