#!/usr/bin/env bash
# Checks of the main path, through the real programs: tests/integration/replay_checks.sh CHECK BIN RECORDING
# Each check prints what it found wrong and exits 1.
set -uo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
check=$1 bin=$(realpath "$2") recording=$(realpath "$3")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

source "$root/tests/support/says.sh"
wrong() { echo "WRONG: $*" >&2; exit 1; }
replay() { "$root/tools/replay" "$@" --bin "$bin"; }
hub() { "$bin/touchline-hub" "$@"; }
# The frames of one camera in a session.
frames_of() { hub info --session "$1" --json | python3 -c 'import json,sys; d=json.load(sys.stdin); print([c["frames"] for c in d["cameras"] if c["id"]==sys.argv[1]][0])' "$2"; }
frames_in() { "$bin/touchline-edge" list --recording "$1" --json >/dev/null && ffprobe -v error -count_packets -select_streams v:0 -show_entries stream=nb_read_packets -of csv=p=0 "$1/$2/video.mkv"; }
digest() { (cd "$1" && find . -type f | sort | xargs sha256sum | sha256sum); }

# Every frame of every camera is in the session, and a second run exports the same bytes.
check_repeat() {
  local run
  for run in 1 2; do
    replay "$recording" "$work/s$run" || wrong "run $run ended with $?"
    hub verify --session "$work/s$run" --decode || wrong "session $run is not sound"
    for what in cameras mattes hull people; do
      hub export $what --session "$work/s$run" --out "$work/e$run/$what" || wrong "export $what of run $run"
    done
    head -n 3 "$recording/truth/virtual01/cameras.csv" > "$work/path.csv"
    hub render --session "$work/s$run" --path "$work/path.csv" --mode hull --size 640x360 --out "$work/e$run/r" || wrong "render of run $run"
  done
  for camera in $("$bin/touchline-edge" list --recording "$recording" --ids); do
    [ "$(frames_of "$work/s1" "$camera")" = "$(frames_in "$recording" "$camera")" ] ||
      wrong "$camera: $(frames_of "$work/s1" "$camera") of $(frames_in "$recording" "$camera") frames in the session"
  done
  [ "$(digest "$work/e1")" = "$(digest "$work/e2")" ] || wrong "two runs export different bytes"
  [ "$(find "$work/e1/r" -name '*.png' | wc -l)" = 2 ] || wrong "two rows of the path did not make two pictures"
}

# A plate goes from one run to the next; one that is damaged is named, and the run is complete without it.
check_plates() {
  replay "$recording" "$work/s1" --camera f1 --plates "$work/plates" > "$work/out" 2>&1 || wrong "the first run ended with $?"
  [ -s "$work/plates/f1.plate" ] || wrong "no plate was saved"
  grep -q 'plate goes on' "$work/out" && wrong "the first run went on from a plate"
  replay "$recording" "$work/s2" --camera f1 --plates "$work/plates" > "$work/out" 2>&1 || wrong "the second run ended with $?"
  says 'plate goes on from' < "$work/out" || wrong "the second run did not go on from the plate"
  printf x | dd of="$work/plates/f1.plate" bs=1 seek=40 conv=notrunc 2>/dev/null
  replay "$recording" "$work/s3" --camera f1 --plates "$work/plates" > "$work/out" 2>&1 || wrong "the third run ended with $?"
  says 'saved plate not used.*header' < "$work/out" || wrong "the damaged plate is not named"
  # A disk that does not write stops nothing.
  mkdir -p "$work/plates/f1.plate.part/in-the-way"
  replay "$recording" "$work/s4" --camera f1 --plates "$work/plates" > "$work/out" 2>&1 || wrong "the fourth run ended with $?"
  says 'f1.plate.*cannot be written' < "$work/out" || wrong "the disk that does not write is not named"
  [ "$(frames_of "$work/s4" f1)" = "$(frames_in "$recording" f1)" ] || wrong "f1 is not complete"
}

# An edge that is killed is named; the others are complete.
check_killed_edge() {
  "$root/tools/replay" "$recording" "$work/s" --camera f1 --camera m2 --bin "$bin" > "$work/out" 2>&1 &
  local replaying=$!
  # Killed as soon as it works: its log says so once it has looked at its stills.
  grep -qm1 'surveyed' < <(tail -n +1 -F --pid="$replaying" "$work/s.log/m2.log" 2>/dev/null) ||
    { cat "$work/out"; wrong "the replay ended before the edge was killed"; }
  pkill -KILL -f "touchline-edge run .*--camera m2 .*--tag replay-$replaying-" || wrong "no edge of m2 to kill"
  wait "$replaying"
  [ $? = 1 ] || { cat "$work/out"; wrong "the exit code of a replay with a killed edge is not 1"; }
  grep -q 'm2.*killed' "$work/out" || { cat "$work/out"; wrong "the killed edge is not named"; }
  [ "$(frames_of "$work/s" f1)" = "$(frames_in "$recording" f1)" ] || wrong "f1 is not complete"
  hub info --session "$work/s" | says 'TROUBLE *m2' || wrong "the session does not name m2"
}

# A copy of the recording that a check may spoil; the videos are links.
copy() {
  mkdir -p "$work/r"
  cp -r "$recording/recording.toml" "$work/r/"
  for camera in $("$bin/touchline-edge" list --recording "$recording" --ids); do
    mkdir -p "$work/r/$camera"
    ln -s "$recording/$camera/video.mkv" "$work/r/$camera/video.mkv"
    [ -d "$recording/$camera/survey" ] && ln -s "$recording/$camera/survey" "$work/r/$camera/survey"
  done
  return 0
}

# replay of the spoilt copy ends with code $1 and says something that matches $2.
refuses() {
  local code=$1 pattern=$2
  shift 2
  replay "$work/r" "$work/s" "$@" > "$work/out" 2>&1
  local got=$?
  [ "$got" = "$code" ] || { cat "$work/out"; wrong "exit code $got instead of $code"; }
  grep -Eq "$pattern" "$work/out" || { cat "$work/out"; wrong "nothing says '$pattern'"; }
}

check_unknown_key() {
  copy
  sed -i 's/^width_m/widht_m/' "$work/r/recording.toml"
  refuses 2 'recording.toml:[0-9]+.*widht_m'
}

check_missing_video() {
  copy
  rm "$work/r/f1/video.mkv"
  refuses 2 'f1/video.mkv'
}

check_truncated_video() {
  copy
  rm "$work/r/f1/video.mkv"
  head -c $(($(stat -Lc %s "$recording/f1/video.mkv") * 6 / 10)) "$recording/f1/video.mkv" > "$work/r/f1/video.mkv"
  refuses 1 'f1/video.mkv.*frame' --camera f1 --camera f2
  [ "$(frames_of "$work/s" f2)" = "$(frames_in "$recording" f2)" ] || wrong "f2 is not complete"
  [ "$(frames_of "$work/s" f1)" -ge 1 ] || wrong "the whole frames of f1 are not in the session"
}

check_wrong_pitch() {
  copy
  sed -i 's/^length_m.*/length_m = 92.0/; s/^width_m.*/width_m = 60.0/' "$work/r/recording.toml"
  refuses 1 '(m2|f1).*(length_m|width_m|pitch)' --camera m2
  [ "$(frames_of "$work/s" m2)" = "$(frames_in "$recording" m2)" ] || wrong "frames of m2 were lost"
}

check_no_lines() {
  copy
  rm "$work/r/f1/video.mkv"
  ffmpeg -v error -f lavfi -i "color=0x2f7a2f:s=1920x1080:r=25,noise=alls=6" -frames:v 5 -pix_fmt yuv422p10le -c:v libx264 -preset ultrafast "$work/r/f1/video.mkv"
  refuses 1 'f1.*line' --camera f1
  [ "$(frames_of "$work/s" f1)" = 5 ] || wrong "the frames without lines are not in the session"
}

# A camera whose side was stated wrongly is solved as its mirror image, and named because it disagrees about people.
check_wrong_side() {
  copy
  sed -i '/^id = "m3"/,/^video/ s/^side = .*/side = "left"/' "$work/r/recording.toml"
  replay "$work/r" "$work/s" --camera m1 --camera m3 --camera f1 > "$work/out" 2>&1 || { cat "$work/out"; wrong "the replay failed"; }
  says 'm3.*TROUBLE.*state side = "right"' < "$work/out" || { cat "$work/out"; wrong "the replay does not name m3"; }
  hub verify --session "$work/s" > "$work/verify" || wrong "the session is not sound"
  says '^TROUBLE m3:.*state side = "right"' < "$work/verify" || { cat "$work/verify"; wrong "verify does not name m3"; }
  [ "$(grep -c '^TROUBLE' "$work/verify")" = 1 ] || { cat "$work/verify"; wrong "another camera is named"; }
}

# A second unit that claims a camera's id is turned away and named on both sides; the first goes on.
check_duplicate_id() {
  local domain=$((10 + RANDOM % 80)) tag=duplicate-$$
  copy
  hub run --recording "$work/r" --camera f1 --session "$work/s" --profile replay --domain "$domain" --tag "$tag" 2> "$work/hub" &
  local hub_pid=$!
  "$bin/touchline-edge" run --recording "$work/r" --camera f1 --pace real --profile replay --domain "$domain" --tag "$tag" 2> "$work/first" &
  local first=$!
  "$bin/touchline-edge" run --recording "$work/r" --camera f1 --pace real --profile replay --domain "$domain" --tag "$tag" 2> "$work/second" &
  local second=$!
  wait "$first"; local a=$?
  wait "$second"; local b=$?
  wait "$hub_pid"; local h=$?
  cat "$work/hub" "$work/first" "$work/second"
  [ $(((a == 0) + (b == 0))) = 1 ] || wrong "exit codes $a and $b: exactly one of the two should work"
  [ "$h" = 1 ] || wrong "the hub's exit code is $h, not 1"
  grep -q 'f1' "$work/hub" || wrong "the hub does not name f1"
  cat "$work/first" "$work/second" | says -E 'f1.*(already|another|second)' || wrong "the unit turned away does not say why"
  [ "$(frames_of "$work/s" f1)" = "$(frames_in "$recording" f1)" ] || wrong "f1 is not complete"
}

# A full disk ends the session with a clear error; what was written is readable.
check_full_disk() {
  (ulimit -f 600; trap '' XFSZ; replay "$recording" "$work/s" --camera f1 > "$work/out" 2>&1)
  [ $? = 1 ] || { cat "$work/out"; wrong "the exit code with a full disk is not 1"; }
  grep -Eqi 's/.*(space|large|disk|full|written)' "$work/out" || { cat "$work/out"; wrong "nothing names the full disk"; }
  hub verify --session "$work/s" || wrong "what was written is not readable"
  hub info --session "$work/s" | says 'NOT FINISHED' || wrong "nothing says that the session is unfinished"
}

# A hub that is killed leaves a session that can be read.
check_killed_hub() {
  "$root/tools/replay" "$recording" "$work/s" --camera f1 --camera f2 --bin "$bin" > "$work/out" 2>&1 &
  local replaying=$!
  # The edge of f2 is held before its first frame, so that the hub cannot finish before it is killed.
  until pkill -STOP -f "touchline-edge run .*--camera f2 .*--tag replay-$replaying-"; do
    kill -0 "$replaying" 2>/dev/null || { cat "$work/out"; wrong "the replay ended before an edge could be held"; }
  done
  until [ "$(frames_of "$work/s" f1 2>/dev/null)" -ge 1 ] 2>/dev/null; do
    kill -0 "$replaying" 2>/dev/null || { cat "$work/out"; wrong "the replay ended before the hub was killed"; }
  done
  pkill -KILL -f "touchline-hub run .*--tag replay-$replaying-" || wrong "no hub to kill"
  pkill -CONT -f "touchline-edge run .*--camera f2 .*--tag replay-$replaying-"
  wait "$replaying"
  [ $? = 1 ] || { cat "$work/out"; wrong "the exit code of a replay with a killed hub is not 1"; }
  hub verify --session "$work/s" || wrong "the session is not readable"
  hub info --session "$work/s" | says 'NOT FINISHED' || wrong "nothing says that the session is unfinished"
}

"check_$check" && echo "$check: ok"
