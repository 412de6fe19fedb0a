#!/bin/sh
# Many queries from C, then many requests to the viewer's server. Usage: BSDF=... benches/soak/run.sh QUERIES REQUESTS
set -eu

root=$(cd "$(dirname "$0")/../.." && pwd)
build=$root/build/soak
mkdir -p "$build"
cd "$root"
${CARGO:-cargo} build --release --locked -p bsdfkit-c
target=${CARGO_TARGET_DIR:-$root/target}/release
${CC:-cc} -std=c99 -O2 -Wall -Wextra -Werror -I bindings/c/include benches/soak/queries.c "$target/libbsdfkit.a" \
    -lgcc_s -lutil -lrt -lpthread -lm -ldl -lc -o "$build/queries"
for file in xml/t4_rf_rb_tf_tb.xml compiled/kf_in_tf.safetensors compiled/render_turned.safetensors; do
    "$build/queries" "tests/golden/$file" "$(($1 / 3))"
done
"${PYTHON:-python3}" benches/soak/requests.py "$BSDF" tests/golden/xml/t4_tf.xml "$2"
