#!/usr/bin/env python3
"""Puts what fjell-lab and bench_cut measured into one small file, which the README's plots are drawn from,
and the part of measured.md beside it that has them.

plots.py FOLDER FILE    FOLDER: of speed.jsonl, triangles.jsonl, triangles-real.jsonl and jumps.json
"""
import datetime
import json
import os
import re
import sys

BEGIN, END = "<!-- by ./dev plots -->\n", "<!-- end -->"


def cases(folder, name):
    """What was measured of a recipe's cases: (method, cells a frame) -> numbers."""
    with open(os.path.join(folder, name + ".jsonl"), encoding="utf-8") as lines:
        all_lines = [json.loads(line) for line in lines]
    return {(line["case"]["method"], line["case"]["cells_a_frame"]): line["measured"] for line in all_lines}


def of_real_heights(folder, name):
    with open(os.path.join(folder, name + ".jsonl"), encoding="utf-8") as lines:
        return "landscape" not in lines.readline()


def machine():
    with open("/proc/cpuinfo", encoding="utf-8") as info:
        model = re.search(r"model name\s*: (.*)", info.read())
    return f"{os.cpu_count()} cores, {model[1] if model else 'of an unknown model'}"


def rounded(value):
    return float(f"{value:.3g}")


def speed_plot(folder):
    names = {"incremental-offscreen": "Fjell, factor 8", "incremental": "Fjell, all around", "lean": "recursion",
             "roam": "ROAM", "cdlod": "CDLOD, CPU part"}
    measured = cases(folder, "speed")
    speeds = sorted({speed for _, speed in measured})
    return {"name": "plot-speed", "title": "Update time over camera speed",
            "x_label": "camera speed, cells a frame", "y_label": "median update time, microseconds",
            "lines": [{"label": label,
                       "points": [[speed, rounded(measured[method, speed]["median_us"])] for speed in speeds]}
                      for method, label in names.items()]}


def triangles_plot(folder):
    names = {"incremental": "Fjell", "lean": "recursion", "roam": "ROAM", "cdlod": "CDLOD"}

    def group(name, heading):
        measured = {method: numbers for (method, _), numbers in cases(folder, name).items()}
        return {"heading": heading, "rows": [{"label": label, "value": rounded(measured[method]["equal_triangles"])}
                                             for method, label in names.items()]}

    groups = [group("triangles", "Synthetic mountains, 2 pixels")]
    if of_real_heights(folder, "triangles-real"):
        groups.append(group("triangles-real", "Puget Sound, 1 pixel"))
    return {"name": "plot-triangles", "title": "Triangles that the same true error takes",
            "x_label": "triangles in view", "groups": groups}


def jumps_plot(folder):
    with open(os.path.join(folder, "jumps.json"), encoding="utf-8") as file:
        counters = json.load(file)["benchmarks"][0]
    ranks = {"p50": "50%", "p90": "90%", "p99": "99%", "p999": "99.9%", "worst": "worst"}
    names = {"limited": "Fjell, limit 1 ms", "unlimited": "Fjell, no limit", "lean": "recursion"}
    if counters["limit_us"] != 1000:
        sys.exit("plots.py: jumps.json: another limit than 1 ms; say it in the plot's label")
    return {"name": "plot-jumps", "title": "Update time where the camera jumps",
            "x_label": "share of frames that take at most this long", "y_label": "update time, microseconds",
            "x_names": list(ranks.values()),
            "lines": [{"label": label, "points": [[i + 1, rounded(counters[f"{key}_{rank}_us"])]
                                                  for i, rank in enumerate(ranks)]} for key, label in names.items()]}


def written(value):
    return f"{value:,.0f}" if value >= 100 else f"{value:g}"


def table(head, rows):
    return [f"| {' | '.join(head)} | command |", "|---" * len(head) + "|---|",
            *(f"| {' | '.join(row)} | `./dev plots` |" for row in rows), ""]


def of_lines(plot, first, renamed=None):
    """A row for each x, a column for each line."""
    lines = [{**line, "label": (renamed or {}).get(line["label"], line["label"])} for line in plot["lines"]]
    names = plot.get("x_names") or [written(x) for x, _ in lines[0]["points"]]
    return table([first, *(line["label"] for line in lines)],
                 [[name, *(written(line["points"][i][1]) for line in lines)] for i, name in enumerate(names)])


def page(plots):
    """The part of docs/measured.md that is made: each plot with its values."""
    speed, triangles, jumps = plots["plots"][:3]
    measured = plots["measured"]
    return ["", f"Machine B: {measured['machine']}, on {measured['date']}.", "",
            "![Median update time over camera speed, on logarithmic axes, of Fjell, recursion, ROAM and CDLOD]"
            "(pictures/plot-speed.svg)",
            "Median update, in microseconds. Synthetic mountains of 4097 x 4097 samples, 60 m apart, 0.8 px, 100,000 "
            "vertices in view.", "",
            *of_lines(speed, "speed [cells a frame]"),
            "![Triangles in view that Fjell, recursion, ROAM and CDLOD take for the same true error]"
            "(pictures/plot-triangles.svg)",
            "Triangles in view at which the largest true error of eight cameras is so many pixels.", "",
            *table(["terrain", "method", "triangles"],
                   [[group["heading"], row["label"], written(row["value"])]
                    for group in triangles["groups"] for row in group["rows"]]),
            "![Update times of frames that jump: the median and rarer ones, of Fjell with and without a limit and of "
            "recursion](pictures/plot-jumps.svg)",
            "Updates, in microseconds: 10,000 frames that turn and fly 0.25 cells each, with a jump to a random place "
            "every 500, over the mountains of the first plot; the limit is 1 ms (`./dev plots`). So many frames take at "
            "most so long:", "",
            *of_lines(jumps, "frames", {"Fjell, limit 1 ms": "Fjell, with the limit"})]


def main():
    folder, path = sys.argv[1:]
    plots = {"measured": {"command": "./dev plots", "date": datetime.date.today().isoformat(),
                          "machine": machine()},
             "plots": [speed_plot(folder), triangles_plot(folder), jumps_plot(folder)]}
    with open(path, encoding="utf-8") as file:  # plots of other programs (array_meshes.py) stay
        names = [plot["name"] for plot in plots["plots"]]
        plots["plots"] += [plot for plot in json.load(file)["plots"] if plot["name"] not in names]
    text = json.dumps(plots, indent=1)
    with open(path + ".new", "w", encoding="utf-8") as file:
        file.write(text + "\n")
    os.replace(path + ".new", path)
    page_path = os.path.join(os.path.dirname(path), "measured.md")
    with open(page_path, encoding="utf-8") as file:
        before, rest = file.read().split(BEGIN)
    after = rest.split(END)[1]
    with open(page_path, "w", encoding="utf-8") as file:
        file.write(before + BEGIN + "\n".join(page(plots)) + END + after)


main()
