#!/bin/sh
# Whether programs in several languages print the same text of every golden file, of an interpolant and of its render form, faults included.
# Usage: tests/parity/run.sh COMMAND COMMAND...   (each takes the file as its last argument)
set -eu

root=$(cd "$(dirname "$0")/../.." && pwd)
[ $# -ge 2 ] || { echo "usage: run.sh COMMAND COMMAND..." >&2; exit 2; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# The text on both streams, and the status.
answer() {
    status=0
    # shellcheck disable=SC2086 # a command and its arguments
    $1 "$2" > "$3" 2>&1 || status=$?
    echo "status $status" >> "$3"
}

# An interpolant of what a cloth reflects and a pane transmits: light from behind takes the second the other way.
bsdf=${BSDF:-$root/target/release/bsdf}
for material in fabric fritted-glass; do
    "$bsdf" simulate $material -o "$work/$material" --sweeps 12 --points-per-sweep 60 --spiral-points 300 > /dev/null
done
"$bsdf" fit "$work/fabric" "$work/fritted-glass" -o "$work/both.safetensors" > /dev/null 2>&1

# The same as tables that move along with its peaks, and these cut short.
"$bsdf" compile "$work/both.safetensors" -o "$work/render.safetensors" > /dev/null 2>&1
head -c 100000 "$work/render.safetensors" > "$work/short_render.safetensors"

# A container cut short, and one of which nothing but the name is left.
head -c 4096 "$root/tests/golden/compiled/t4_tf.safetensors" > "$work/short.safetensors"
: > "$work/empty.safetensors"

files=0
for file in "$root"/tests/golden/xml/*.xml "$root"/tests/golden/badxml/*.xml \
    "$root"/tests/golden/compiled/*.safetensors "$work"/*.safetensors "$root/no/such/file.xml"; do
    answer "$1" "$file" "$work/first"
    for command in "$@"; do
        [ "$command" != "$1" ] || continue
        answer "$command" "$file" "$work/other"
        if ! diff "$work/first" "$work/other" > "$work/diff"; then
            echo "$file: $1 (<) and $command (>) differ:" >&2
            head -n 10 "$work/diff" >&2
            exit 1
        fi
    done
    files=$((files + 1))
done
echo "parity: $# programs print the same of $files files"
