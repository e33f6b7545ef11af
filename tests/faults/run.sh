#!/usr/bin/env bash
# Plants the faults of list.txt one after the other, builds the test program that must notice each, and says whether the
# cases named there fail; then whether they pass without any fault. By hand, in a tree that `./dev build` has built:
#   tests/faults/run.sh [WORD...]      only faults whose three lines hold one of the words
# Sources are put back as they were, also when this is interrupted. Exit code: 1 when a fault was missed.
set -uo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
readonly build=${FJELL_FAULTS_BUILD:-build/release}

planted=''
put_back() {
  [[ ! $planted ]] || mv -f "$planted.before-fault" "$planted"
  planted=''
}
trap put_back EXIT
trap 'exit 130' INT TERM

compiles() { ninja -C "$build" "$1" >"$build/fault.log" 2>&1; }
passes() { timeout 600 "$build/bin/$1" "${2//,/\\,}" -w NoTests >>"$build/fault.log" 2>&1; }

wanted() { # text words...
  local text=$1 word
  shift
  (($#)) || return 0
  for word in "$@"; do [[ $text != *"$word"* ]] || return 0; done
  return 1
}

noticed=0 wrong=0
declare -A asked
try() { # program cases code fault
  local file text files
  mapfile -t files < <(git grep -lF -e "$3" -- '*.cpp' '*.h' '*.c' ':!tests')
  if ((${#files[@]} != 1)); then
    printf 'LOST     %s: in %d files: %s\n' "$1" "${#files[@]}" "$3"
    return 1
  fi
  file=${files[0]}
  text=$(cat "$file"; printf x)
  if [[ ${text#*"$3"} == *"$3"* ]]; then
    printf 'LOST     %s: more than once in %s: %s\n' "$1" "$file" "$3"
    return 1
  fi
  asked["$1|$2"]=1
  cp -p "$file" "$file.before-fault"
  planted=$file
  text=${text/"$3"/"$4"}
  printf %s "${text%x}" >"$file"
  local result=noticed
  if ! compiles "$1"; then
    result='NO BUILD'
  elif passes "$1" "$2"; then
    result=MISSED
  fi
  put_back
  touch "$file"
  printf '%-8s %s "%s": %s\n' "$result" "$1" "$2" "$4"
  [[ $result == noticed ]]
}

while IFS= read -r line; do
  case $line in
    '= '*) read -r program cases <<<"${line#= }" ;;
    '- '*) code=${line#- } ;;
    '+ '*)
      wanted "$program $cases $code ${line#+ }" "$@" || continue
      if try "$program" "$cases" "$code" "${line#+ }"; then noticed=$((noticed + 1)); else wrong=$((wrong + 1)); fi
      ;;
  esac
done <tests/faults/list.txt

for pair in "${!asked[@]}"; do
  if ! compiles "${pair%%|*}" || ! passes "${pair%%|*}" "${pair#*|}"; then
    printf 'FAILS    %s "%s" without a fault\n' "${pair%%|*}" "${pair#*|}"
    wrong=$((wrong + 1))
  fi
done
printf '%d noticed, %d not\n' "$noticed" "$wrong"
((wrong == 0))
