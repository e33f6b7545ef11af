#!/bin/sh
# Runs a source's cases:   run_cases.sh LIST PROGRAM SOURCE
# In brief rounds PROGRAM writes into LIST which of them ask for rounds (rounds.h). Full rounds run these alone: the
# others would do what they have done. Without a LIST, or with one that is older than PROGRAM, full rounds run all.
set -eu
if [ "${FJELL_TEST_ROUNDS:-}" = full ] && [ "$1" -nt "$2" ]; then
  if ! [ -s "$1" ]; then
    echo "none of the cases tries more in full rounds"
    exit 0
  fi
  exec "$2" --input-file "$1" -w NoTests -d yes
fi
mkdir -p "$(dirname "$1")"
# The source's name is a tag of its cases. It is an error if there are none.
FJELL_ROUNDS_LIST=$1 exec "$2" --filenames-as-tags "[#$3]" -w NoTests -d yes
