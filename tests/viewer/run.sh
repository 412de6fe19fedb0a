#!/usr/bin/env bash
# The viewer in Chromium. Where the page, node or the browser is missing, that is said; where CI is set, a missing browser is
# an error.
set -euo pipefail
cd "$(dirname "$0")"

chromium=${CHROMIUM:-/usr/bin/chromium}
without() {
    echo "viewer: $1: the page is not tested"
    [ -z "${CI:-}" ] || [ "${2:-}" = anywhere ] || exit 1
    exit 0
}
[ -f "${BSDFKIT_VIEWER:-../../crates/viewer/page/viewer.html}" ] || without "no page is built" anywhere
command -v node > /dev/null && command -v npm > /dev/null || without "no node or npm"
[ -x "$chromium" ] || without "no browser at $chromium (CHROMIUM names another)"
[ node_modules/.package-lock.json -nt package-lock.json ] || npm ci --no-audit --no-fund --silent
# What hangs is a fault, too.
node --test --test-timeout=180000
