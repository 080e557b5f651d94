#!/usr/bin/env bash
# Checks of tools/import on small videos of every kind: tests/integration/import_checks.sh BIN
# Prints what it found wrong and exits 1.
set -uo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
bin=$(realpath "$1")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1

source "$root/tests/support/says.sh"
wrong() { echo "WRONG: $*" >&2; exit 1; }
import() { "$root/tools/import" "$@"; }
video() { ffmpeg -nostdin -v error -y -f lavfi -i testsrc2=size="$1":rate="$2":duration=0.8 "${@:3}" || wrong "no test video ${*: -1}"; }
has() { grep -qxF -- "$2" "$1/recording.toml" || { cat "$1/recording.toml"; wrong "$1: no line '$2'"; }; }
lacks() { grep -q -- "$2" "$1/recording.toml" && { cat "$1/recording.toml"; wrong "$1: has '$2'"; }; return 0; }
# refused CODE WORD ARGS...: import ends with CODE and names WORD, and leaves nothing behind.
refused() {
  local code=$1 word=$2
  shift 2
  import "$@" > said 2>&1
  [ $? = "$code" ] || { cat said; wrong "import $*: not exit code $code"; }
  grep -q -- "$word" said || { cat said; wrong "import $*: does not say '$word'"; }
  [ -z "$(find . -maxdepth 1 -name '*.new-*')" ] || wrong "import $*: left something behind"
}
listed() { "$bin/touchline-edge" list --recording "$1" --json || wrong "$1 does not load"; }

video 320x180 30000/1001 -pix_fmt yuv420p -c:v mpeg4 plain.mp4
video 352x288 25 -vf "tinterlace=mode=interleave_top,setfield=tff,setsar=16/11" -pix_fmt yuv420p -c:v mpeg2video -flags +ilme+ildct wide.mpg
video 320x180 25 -vf "select='not(eq(n,4))*not(eq(n,5))'" -vsync vfr -c:v ffv1 uneven.mkv
mkdir stills && for k in 3 1 2; do video 64x48 1 -frames:v 1 "stills/n$k.jpg"; done
echo "no video" > text.mp4

import plain.mp4 one --sport soccer > /dev/null || wrong "plain.mp4 is refused"
has one 'frame_rate = "30000/1001"'; has one 'width = 320'; has one 'sport = "soccer"'; has one 'side = "main"'; has one 'role = "match"'
lacks one pitch; lacks one scan; lacks one survey
[ -L one/m1/video.mp4 ] || wrong "the video is not linked"
[ ! -e one/m1/timing.csv ] || wrong "an even video has a timing.csv"
listed one > /dev/null

import wide.mpg stills plain.mp4 many --side reverse --side left --role fixed --id a --copy --length 104 --width 67.5 --sport soccer > /dev/null || wrong "many videos are refused"
has many 'scan = "tff"'; has many 'width = 512'; has many 'height = 288'; has many 'id = "a"'; has many 'id = "f1"'; has many 'id = "f2"'
has many 'side = "reverse"'; has many 'length_m = 104.0'; has many 'width_m = 67.5'
[ "$(grep -c 'side = "left"' many/recording.toml)" = 2 ] || wrong "the last side does not serve the videos after it"
[ "$(ffprobe -v error -count_packets -show_entries stream=nb_read_packets -of csv=p=0 many/f1/video.mkv)" = 3 ] || wrong "three stills are not three frames"
[ ! -L many/f2/video.mp4 ] || wrong "--copy linked"
listed many | says '"frame_rate":"30000/1001"' || wrong "a camera lost its own rate"

import uneven.mkv gap > /dev/null || wrong "uneven.mkv is refused"
[ "$(sed -n 6p gap/m1/timing.csv | cut -d, -f1,2)" = 4,240000000 ] || { cat gap/m1/timing.csv; wrong "frame 4 is not at its own time"; }
listed gap > /dev/null
"$bin/touchline-edge" check --recording gap --camera m1 | says 'pass *video' || wrong "the video of gap is not read"

refused 2 'holds no video' text.mp4 bad
refused 2 'no such file' missing.mp4 bad
refused 2 'already there' plain.mp4 one
refused 2 'is no recording' plain.mp4 stills --force
refused 2 '--side is one of' plain.mp4 bad --side north
refused 2 usage plain.mp4
import plain.mp4 one --force --sport rugby > /dev/null && has one 'sport = "rugby"' || wrong "--force does not replace a recording"
import --help | says example || wrong "no example in --help"
exit 0
