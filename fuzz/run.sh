#!/bin/sh
# Runs programs of libFuzzer one after the other. Usage: fuzz/run.sh FOLDER SECONDS TARGET ...
# What they learn is kept in build/fuzz/TARGET/corpus, what breaks a target in build/fuzz/TARGET.
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
programs=$(cd "$1" && pwd)
seconds=$2
shift 2
golden=$root/tests/golden
status=0
for target; do
    kept=$root/build/fuzz/$target
    mkdir -p "$kept/corpus"
    case $target in
        xml) more="$golden/xml $golden/badxml" ;;
        container) more=$golden/compiled ;;
        sir) more=$golden/sir ;;
        *) more= ;;
    esac
    echo "fuzz: $target for $seconds s"
    # shellcheck disable=SC2086 # folders, not one
    nice -n 10 "$programs/$target" -max_total_time="$seconds" -rss_limit_mb=2048 -timeout=30 -max_len=40000 \
        -artifact_prefix="$kept/" -print_final_stats=1 "$kept/corpus" "$root/fuzz/corpus/$target" $more \
        > "$kept/log" 2>&1 || { status=1; echo "fuzz: $target: found something, see $kept/log"; }
    grep -E 'number_of_executed_units|average_exec_per_sec|peak_rss_mb|SUMMARY|panicked' "$kept/log" || true
done
exit $status
