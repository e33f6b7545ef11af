#!/usr/bin/env bash
# What a frame costs in each host of content/hosts, beside fjell-fly's: one table, and OUT/hosts.csv.
#   hosts.sh BUILD OUT [ROUNDS [FRAMES]]
# BUILD: a tree with the libraries, fjell-bake and fly_times. Each host is built as its guide says, with optimisation; one
# whose packages are missing is left out. All fly the same views over the same pack (content/hosts/times), one program
# after the other, ROUNDS times: so a busy machine is busy for all of them. The figures are medians of the rounds.
set -euo pipefail
source=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
build=$1 out=$2 rounds=${3:-3} frames=${4:-240}
bin=$build/bin pack=$out/hills.fjell views=$out/views.txt
mkdir -p "$out"

[[ -e $pack ]] || "$bin/fjell-bake" "$source/content/terrain/hills.json" -o "$pack" --spacing 1 --tile 256 --quiet
"$bin/fly_times" "$pack" --write "$source/content/paths/straight.json" "$frames" >"$views"
cmake --install "$build" --prefix "$out/installed" --component fjell >"$out/install.log"

made=()
for host in game c_loop vulkan ogre physics server; do
  if cmake -S "$source/content/hosts/$host" -B "$out/$host" -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH="$out/installed" \
    >"$out/$host.log" 2>&1 && cmake --build "$out/$host" -j 2 >>"$out/$host.log" 2>&1 && [[ -x $out/$host/$host ]]; then
    made+=("$host")
  else
    echo "left out: $host, which is not built: see $out/$host.log"
  fi
done

measure() { # NAME REFERENCE COMMAND...: a line NAME REFERENCE VERTICES, then PART MEAN MEDIAN P99 for each part
  local display=() line
  if [[ $1 == c_loop || $1 == ogre ]] && [[ -z ${DISPLAY:-} ]]; then display=(xvfb-run -a); fi
  if line=$("${display[@]}" "${@:3}" 2>"$out/$1.err"); then
    sed -nE "s/^times of [0-9]+ frames, ([0-9]+) vertices, mean.median.p99 us:/$1 $2 \1/; T; s,/, ,g; p" <<<"$line" >>"$out/rounds.txt"
  else
    echo "left out: $1, which says: $(tail -n 1 "$out/$1.err")"
  fi
}
: >"$out/rounds.txt"
for ((round = 0; round < rounds; ++round)); do
  measure fjell-fly - "$bin/fly_times" "$pack" --times "$views"
  measure fjell-fly,streaming - "$bin/fly_times" "$pack" --stream "$views"
  for host in "${made[@]}"; do # the host in C does not stream
    measure "$host" "$([[ $host == c_loop ]] && echo fjell-fly || echo fjell-fly,streaming)" "$out/$host/$host" "$pack" --times "$views"
  done
done

LC_ALL=C awk -v csv="$out/hosts.csv" '
  function median(list,   all, n, i, j, swap) { # of the rounds
    n = split(list, all, " ")
    for (i = 1; i <= n; ++i) for (j = i + 1; j <= n; ++j) if (all[j] + 0 < all[i] + 0) { swap = all[i]; all[i] = all[j]; all[j] = swap }
    return all[int((n + 1) / 2)] + 0
  }
  {
    if (!($1 in reference)) { reference[$1] = $2; host[++hosts] = $1; vertices[$1] = $3 }
    for (i = 4; i + 3 <= NF; i += 4) {
      key = $1 SUBSEP $i
      if (!(key in mean)) parts[$1] = parts[$1] " " $i
      mean[key] = mean[key] " " $(i + 1); middle[key] = middle[key] " " $(i + 2); late[key] = late[key] " " $(i + 3)
    }
  }
  END {
    print "host,part,mean_us,median_us,p99_us,median_beside_fjell_fly" >csv
    printf "%-20s %8s  %-8s %9s %9s %9s  %s\n", "host", "vertices", "part", "mean us", "median us", "p99 us", "beside fjell-fly"
    for (h = 1; h <= hosts; ++h) {
      n = split(parts[host[h]], part, " ")
      for (p = 1; p <= n; ++p) {
        key = host[h] SUBSEP part[p]; its = reference[host[h]] SUBSEP part[p]
        ratio = (its in middle) && median(middle[its]) > 0 ? sprintf("%.2f", median(middle[key]) / median(middle[its])) : ""
        printf "%-20s %8s  %-8s %9.1f %9.1f %9.1f  %s\n", (p == 1 ? host[h] : ""), (p == 1 && vertices[host[h]] != 0 ? vertices[host[h]] : ""),
          part[p], median(mean[key]), median(middle[key]), median(late[key]), ratio
        gsub(",", " ", host[h])
        printf "%s,%s,%s,%s,%s,%s\n", host[h], part[p], median(mean[key]), median(middle[key]), median(late[key]), ratio >csv
        gsub(" ", ",", host[h])
      }
    }
  }' "$out/rounds.txt"
