#!/usr/bin/env sh
# Builds the library into the folder that is named, or here; a second argument and more go to the compiler.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
out=${1:-$here}
[ $# -eq 0 ] || shift
flags="-O2 -Wall -Wextra -Wpedantic -shared -fPIC -fvisibility=hidden"
# shellcheck disable=SC2086 # The flags are words.
"${CC:-cc}" -std=c11 $flags "$@" -I "$here/../../include" "$here/kinect_live.c" -o "$out/libkinect_live.so" -lm -lpthread -ldl
