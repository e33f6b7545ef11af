#!/usr/bin/env python3
"""Puts what fjell-lab and bench_cut measured into one small file, which the README's plots are drawn from.

plots.py FOLDER FILE    FOLDER: of speed.jsonl, triangles.jsonl, triangles-real.jsonl and jumps.json
"""
import datetime
import json
import os
import re
import sys


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


def main():
    folder, path = sys.argv[1:]
    plots = {"measured": {"command": "./dev plots", "date": datetime.date.today().isoformat(),
                          "machine": machine()},
             "plots": [speed_plot(folder), triangles_plot(folder), jumps_plot(folder)]}
    text = json.dumps(plots, indent=1)
    with open(path + ".new", "w", encoding="utf-8") as file:
        file.write(text + "\n")
    os.replace(path + ".new", path)


main()
