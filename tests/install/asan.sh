#!/bin/sh
# The C library under AddressSanitizer, and what leaks. Usage: tests/install/asan.sh [BUILD]   (default: build/asan)
#
# Seen: every read and write of the library's Rust code beyond or after its memory, also of arrays on the heap that the programs
# in C hand in; memory given back twice or never. Not seen: reads and writes of the C programs themselves (valgrind has
# those, tests/install/run.sh) and inside the precompiled standard library, whose allocations are watched all the same;
# within the last page of a mapped file.
# Stable Rust takes its flag -Zsanitizer where RUSTC_BOOTSTRAP is set; nothing that is made here is installed.
set -eu

root=$(cd "$(dirname "$0")/../.." && pwd)
build=${1:-$root/build/asan}
mkdir -p "$build"
build=$(cd "$build" && pwd)
golden=$root/tests/golden
host=$(rustc -vV | sed -n 's/^host: //p')

# A program of Rust brings the sanitizer's run-time; a library leaves that to the program: in C it is linked as Rust has it.
cd "$root"
export RUSTC_BOOTSTRAP=1
CARGO_TARGET_DIR=$build/target RUSTFLAGS=-Zsanitizer=address \
    ${CARGO:-cargo} build --release --locked --target "$host" -p bsdfkit-c
library=$build/target/$host/release/libbsdfkit.a
runtime=$(find "$(rustc --print sysroot)/lib/rustlib/$host/lib" -name 'librustc*_rt.asan.a' | head -n 1)
[ -n "$runtime" ] || { echo "asan: expected the run-time librustc-*_rt.asan.a beside the compiler, found none" >&2; exit 1; }

"${PYTHON:-python3}" tests/install/golden.py "$golden" > "$build/golden.txt"
for program in contract container golden; do
    ${CC:-cc} -std=c99 -g -O1 -I bindings/c/include "tests/install/$program.c" "$library" \
        -Wl,--whole-archive "$runtime" -Wl,--no-whole-archive \
        -lstdc++ -lgcc_s -lutil -lrt -lpthread -lresolv -lm -ldl -lc -o "$build/$program"
done
export ASAN_OPTIONS=detect_leaks=1:detect_stack_use_after_return=1:strict_string_checks=1
"$build/contract" "$golden" > "$build/contract.log"
"$build/container" "$golden" "$build/scratch.safetensors" > "$build/container.log"
"$build/golden" "$golden" "$build/golden.txt" > "$build/golden.log"
echo "asan: contract, container and golden: nothing found"
