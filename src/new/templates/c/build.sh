#!/usr/bin/env sh
# Builds the library beside this file; more arguments go to the compiler.
set -eu
cd "$(dirname "$0")"
"${CC:-cc}" -std=c11 -O2 -Wall -Wextra -shared -fPIC -fvisibility=hidden "$@" -I . plugin.c -o lib{{name}}.so -lm
