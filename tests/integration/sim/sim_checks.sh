#!/usr/bin/env bash
# Checks of touchline-sim as a program: sim_checks.sh CHECK PROGRAM. Each prints what it found wrong and exits 1.
set -uo pipefail
cd "$(dirname "$0")/../../.."
check=$1 sim=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
source tests/support/says.sh
wrong() { echo "WRONG: $*" >&2; exit 1; }
small=(--size 320x180 --frames 3 --cameras m1,f1)

# An interrupted run leaves nothing behind and says so.
check_ends() {
  "$sim" tests/data/scenes/penalty.toml "$work/r" --size 640x360 --frames 2000 --cameras m1 2> "$work/log" &
  local running=$!
  for _ in $(seq 300); do
    compgen -G "$work/r.unfinished.*/m1/survey/02.jpg" > /dev/null && break
    kill -0 $running 2> /dev/null || { cat "$work/log"; wrong "it ended before it was interrupted"; }
    sleep 0.1
  done
  kill -INT $running
  wait $running
  [ $? = 1 ] || wrong "the exit code of an interrupted run is not 1"
  grep -q 'stopped' "$work/log" || wrong "nothing says that it was stopped"
  [ -z "$(find "$work" -mindepth 1 -maxdepth 1 -not -name log)" ] || wrong "something was left: $(ls "$work")"
}

# Bad arguments and scenes are refused with code 2, a file and a line.
check_refuses() {
  local code
  sed 's/^frames = 50/framse = 50/' tests/data/scenes/penalty.toml > "$work/bad.toml"
  "$sim" "$work/bad.toml" "$work/r" 2> "$work/log"; code=$?
  [ $code = 2 ] || wrong "an unknown key ends with $code"
  grep -Eq 'bad.toml:[0-9]+.*framse' "$work/log" || wrong "the unknown key is not named: $(cat "$work/log")"
  "$sim" tests/data/scenes/penalty.toml "$work/r" --cameras m1,x9 2> "$work/log"; code=$?
  [ $code = 2 ] && grep -q x9 "$work/log" || wrong "an unknown camera ends with $code"
  "$sim" tests/data/scenes/penalty.toml "$work/r" --size big 2> /dev/null; code=$?
  [ $code = 2 ] || wrong "a bad size ends with $code"
  "$sim" --help | says Example || wrong "--help has no example"
  [ ! -e "$work/r" ] || wrong "a refused run made a folder"
}

# The same bytes at any number of threads.
check_threads() {
  "$sim" tests/data/scenes/penalty.toml "$work/a" "${small[@]}" --threads 1 || wrong "run a ended with $?"
  "$sim" tests/data/scenes/penalty.toml "$work/b" "${small[@]}" --threads 3 || wrong "run b ended with $?"
  diff -r "$work/a" "$work/b" || wrong "one and three threads make different recordings"
}

case "$check" in ends|refuses|threads) "check_$check" ;; *) wrong "no check $check" ;; esac
