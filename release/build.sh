#!/usr/bin/env bash
# What a release consists of, from a clean checkout: wheels for CPython >= 3.10, the source distribution of the Python package and the
# source crates, with their checksums, in build/release. Usage: release/build.sh [--dirty]
#
# On Linux the wheel is linked against an old C library by zig, so that it installs on any distribution since 2018 (manylinux_2_28).
# Nothing is published. Needs rustup, Python >= 3.10 and, for the viewer's page, node and the target wasm32-unknown-unknown.
set -euo pipefail
cd "$(dirname "$0")/.."

fail() {
    echo "release: $1" >&2
    exit 1
}

if [ "${1:-}" != --dirty ]; then
    [ -z "$(git status --porcelain)" ] || fail "expected a clean checkout, found changes: git status; --dirty builds all the same"
fi

# One version, wherever it is written.
version=$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml)
expect() {
    [ "$2" = "$version" ] || fail "$1: expected version $version as in Cargo.toml, found ${2:-none}"
}
expect bindings/python/Cargo.toml "$(sed -n '1,/^\[workspace\]/s/^version = "\(.*\)"/\1/p' bindings/python/Cargo.toml)"
expect CITATION.cff "$(sed -n 's/^version: //p' CITATION.cff)"
expect "Cargo.toml, crates of this workspace" "$(sed -n 's/^bsdfkit.*version = "=\(.*\)" }/\1/p' Cargo.toml | sort -u | paste -sd ' ' -)"
grep -qE "^## ($version|Unreleased)" CHANGELOG.md || fail "CHANGELOG.md: expected a heading \"## $version\", found none"

out=build/release
rm -rf "$out"
mkdir -p "$out"
viewer/build.sh --if-possible

python=${PYTHON:-python3}
tools=build/release-tools
[ -d "$tools" ] || "$python" -m venv "$tools"
if [ -d "$tools/Scripts" ]; then bin=$tools/Scripts; else bin=$tools/bin; fi    # of Windows
"$bin/python" -m pip install --quiet --disable-pip-version-check -r release/requirements.txt
PATH=$PWD/$bin:$PATH

if [ "$(uname -s)" = Linux ]; then
    rustup target list --installed | grep -q "^$(uname -m)-unknown-linux-gnu$" || rustup target add "$(uname -m)-unknown-linux-gnu"
    maturin build --release --locked --strip --compatibility manylinux_2_28 --zig --out "$out"
else
    maturin build --release --locked --strip --out "$out"
fi
maturin sdist --out "$out"

# The others of the workspace are no libraries for strangers. The viewer's page was built above, and is in no commit.
cargo package --locked --allow-dirty --workspace --exclude bsdfkit-web --exclude bsdfkit-c --exclude bsdfkit-c-abi \
    --exclude bsdfkit-examples --exclude bsdfkit-fuzz ${RELEASE_VERIFY:---no-verify}
mkdir "$out/crates"
cp "${CARGO_TARGET_DIR:-target}"/package/bsdfkit*-"$version".crate "$out/crates"

# macOS has shasum.
if command -v sha256sum > /dev/null; then sum=(sha256sum); else sum=(shasum -a 256); fi
(cd "$out" && find . -type f ! -name SHA256SUMS | LC_ALL=C sort | xargs "${sum[@]}" > SHA256SUMS)
echo "$out:"
cat "$out/SHA256SUMS"
