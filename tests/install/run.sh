#!/bin/sh
# Installs the C library into a prefix of its own, and uses it as strangers do: by CMake, by
# pkg-config, under valgrind. Usage: tests/install/run.sh [BUILD]   (default: build/c)
# Leaves the programs in BUILD/cmake, among them `parity`. A tool that is missing is said to be; where CI is
# set, that is an error.
set -eu

# Whether tool $1 is there, which Debian has in package $2; $3 is what is not tried without.
have() {
    command -v "$1" > /dev/null && return
    if [ -n "${CI:-}" ]; then
        echo "C library: expected $1, found none: apt-get install $2" >&2
        exit 1
    fi
    echo "C library: $1 is missing (Debian: $2); not tried: $3"
    return 1
}

root=$(cd "$(dirname "$0")/../.." && pwd)
build=${1:-$root/build/c}
mkdir -p "$build"
build=$(cd "$build" && pwd)
prefix=$build/prefix
golden=$root/tests/golden

have cmake cmake "all of it" || exit 0
have c++ g++ "all of it" || exit 0

lines=$(wc -l < "$root/bindings/c/include/bsdfkit.h")
[ "$lines" -lt 300 ] || { echo "bsdfkit.h: expected under 300 lines, found $lines" >&2; exit 1; }

rm -rf "$prefix" "$build/cmake"
${MAKE:-make} -s -C "$root/bindings/c" install PREFIX="$prefix"

echo "C library: a stranger's CMake project"
cmake -S "$root/tests/install" -B "$build/cmake" -DCMAKE_PREFIX_PATH="$prefix" > "$build/cmake.log" \
    || { cat "$build/cmake.log"; exit 1; }
cmake --build "$build/cmake" >> "$build/cmake.log" 2>&1 || { cat "$build/cmake.log"; exit 1; }
ctest --test-dir "$build/cmake" --output-on-failure --no-tests=error > "$build/ctest.log" \
    || { cat "$build/ctest.log"; exit 1; }
grep 'tests passed' "$build/ctest.log"

if have pkg-config pkg-config "that way of finding it"; then
    echo "C library: pkg-config"
    export PKG_CONFIG_PATH="$prefix/lib/pkgconfig"
    flags=$(pkg-config --cflags --libs bsdfkit)
    # shellcheck disable=SC2086 # words, not one
    ${CC:-cc} -std=c99 -Wall -Wextra -Wpedantic -Werror "$root/examples/c/query.c" \
        $flags -Wl,-rpath,"$prefix/lib" -o "$build/query"
    "$build/query" "$golden/xml/t4_tf.xml" > /dev/null
fi

if have valgrind valgrind "looking for leaks and bad reads"; then
    echo "C library: valgrind"
    # The pool's threads outlive main: what they hold is reachable, and no error.
    for program in "query $golden/xml/t4_tf.xml" "query $golden/xml/missing.xml" \
        "query_cpp $golden/xml/kf_in_tf.xml" "parity $golden/xml/t3_rf_rb_tf_tb.xml" \
        "contract $golden" "container $golden $build/scratch.safetensors" \
        "golden $golden $build/cmake/golden.txt"; do
        status=0
        # shellcheck disable=SC2086 # a program and its argument
        valgrind --quiet --error-exitcode=99 --leak-check=full --show-leak-kinds=definite,indirect \
            --errors-for-leak-kinds=definite,indirect "$build/cmake/"$program \
            > "$build/valgrind.log" 2>&1 || status=$?
        case "$program $status" in
            *missing.xml\ 1 | *\ 0) ;;
            *) cat "$build/valgrind.log"; echo "valgrind: $program: status $status" >&2; exit 1 ;;
        esac
    done
fi
