#!/usr/bin/env bash
# tools/bench on programs that are built: a table, JSON that says the same, and refusals. usage: table_check.sh BIN
set -euo pipefail
bin=$1
cd "$(dirname "$0")/../.."
source tests/support/says.sh
export TOUCHLINE_BENCH_FRAMES=2
only='^compensate/.*1080p'
tools/bench --bin "$bin" --quick --filter "$only" | says -E 'compensate +1080p .*OpenCV.*<= 1 ms: (yes|no)'
tools/bench --bin "$bin" --quick --filter "$only" --json | python3 -c '
import json, sys
report = json.load(sys.stdin)
rows = {(row["stage"], row["size"]): row for row in report["rows"]}
row = rows[("compensate", "1080p")]
assert row["ours"]["ms"] > 0 and row["ours"]["low_ms"] <= row["ours"]["ms"] <= row["ours"]["high_ms"], row
assert {"OpenCV filter2D, same kernel", "OpenCV 5x5 unsharp"} == {peer["peer"] for peer in row["peers"]}, row
assert row["targets"][0]["bound"] == 1 and not report["failures"], report
'
status=0
tools/bench --bin "$bin" --filter '(' >/dev/null 2>&1 || status=$?
[ "$status" = 2 ] || { echo "a bad expression must be refused with 2, not $status" >&2; exit 1; }
status=0
TOUCHLINE_RECORDING=/nowhere tools/bench --bin "$bin" --quick --filter "$only" >/dev/null 2>&1 || status=$?
[ "$status" = 1 ] || { echo "a missing recording must fail with 1, not $status" >&2; exit 1; }
