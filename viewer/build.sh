#!/usr/bin/env bash
# Builds the viewer's page: crates/web by Rust for WebAssembly, the rest by node.
#
# viewer/build.sh [--if-possible]: with the option, what is missing is said and no fault, unless CI is set.
set -euo pipefail
cd "$(dirname "$0")/.."

cargo=${CARGO:-cargo}
target=${CARGO_TARGET_DIR:-target}
page=crates/viewer/page/viewer.html
triple=wasm32-unknown-unknown

missing() {
    echo "viewer: $1" >&2
    [ "${option:-}" = --if-possible ] && [ -z "${CI:-}" ] && exit 0
    exit 1
}
option=${1:-}

command -v node > /dev/null && command -v npm > /dev/null || missing "no node or npm: no page is built"
# A toolchain without the target is no fault anywhere: it cannot be had everywhere, and all else builds without.
if [ ! -d "$(rustc --print target-libdir --target $triple 2> /dev/null)" ]; then
    echo "viewer: no Rust target $triple (rustup target add $triple): no page is built" >&2
    [ "$option" = --if-possible ] && exit 0
    exit 1
fi

# The command line tool must be of the same version as the crate.
version=$(sed -n 's/^wasm-bindgen = "=\([0-9.]*\)".*/\1/p' Cargo.toml)
bindgen=${WASM_BINDGEN:-build/tools/bin/wasm-bindgen}
if [ "$("$bindgen" --version 2> /dev/null || true)" != "wasm-bindgen $version" ]; then
    "$cargo" install --quiet wasm-bindgen-cli --version "=$version" --no-default-features --bin wasm-bindgen --root build/tools
    bindgen=build/tools/bin/wasm-bindgen
fi

"$cargo" build --locked --profile viewer -p bsdfkit-web --target $triple
"$bindgen" --target web --remove-name-section --remove-producers-section --out-dir build/viewer/web \
    "$target/$triple/viewer/bsdfkit_web.wasm"
[ viewer/node_modules/.package-lock.json -nt viewer/package-lock.json ] || npm ci --prefix viewer --no-audit --no-fund --silent
npm run --prefix viewer --silent check
node viewer/build.mjs build/viewer/web "$page"
