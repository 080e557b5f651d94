# Sourced by checks: says [GREP OPTIONS] PATTERN finds PATTERN in what a program prints, and reads to its end. `program |
# grep -q` does not: grep leaves at its first hit, and the program fails on the closed pipe whenever it prints more slowly.
says() { grep -q "$@" <<<"$(cat)"; }
