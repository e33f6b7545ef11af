#!/usr/bin/env python3
"""Prints what gpu_flights measured as the tables of docs/measured.md.

gpu.py GPU_JSON
"""
import json
import sys

COMMAND = "`./dev gpu`"


def three(value):
    """Three digits, or a dash where nothing was measured."""
    if value is None:
        return "-"
    rounded = float(f"{value:.3g}")
    return f"{rounded:,.0f}" if rounded >= 100 or rounded == int(rounded) else f"{rounded:g}"


def middle(row, key):
    return None if row[key] is None else row[key]["p50"]


def late(row, key):
    return None if row[key] is None else row[key]["p99"]


def table(heads, rows):
    print("| " + " | ".join(heads + ["command"]) + " |")
    print("|" + "---|" * (len(heads) + 1))
    for row in rows:
        print("| " + " | ".join(row + [COMMAND]) + " |")
    print()


def size_of(row):
    return f"{row['width']} x {row['height']}"


def flights(found):
    rows = [row for row in found["flights"] if row["usual"]]
    print(f"Flights of {found['frames']} frames, with physical air, shadows and detail. Medians, but for the column p99.\n")
    table(["scene", "picture", "triangles drawn", "update [us]", "update, p99 [us]", "upload, CPU [us]",
           "upload, GPU [us]", "uploaded [bytes]", "draw, GPU [us]", "frame [ms]", "draw calls", "draws"],
          [[row["scene"], size_of(row), three(row["triangles"]), three(middle(row, "update_us")),
            three(late(row, "update_us")), three(middle(row, "upload_us")), three(middle(row, "upload_gpu_us")),
            three(middle(row, "uploaded_bytes")), three(middle(row, "draw_gpu_us")), three(middle(row, "frame_ms")),
            str(row["draw"]["calls"]), three(row["draw"]["draws"])] for row in rows])


def light(found):
    key, unit = ("draw_gpu_us", "draw, GPU [us]") if found["timers"] else ("frame_ms", "frame [ms]")
    scenes = list(dict.fromkeys(row["scene"] for row in found["flights"]))
    settings = list(dict.fromkeys((size_of(row), row["setting"]) for row in found["flights"]))
    at = {(row["scene"], size_of(row), row["setting"]): row for row in found["flights"]}
    print("What light and material cost. Each row adds to the one above it.\n")
    table(["picture", "light"] + [f"{scene}: {unit}" for scene in scenes],
          [[size, setting] + [three(middle(at[scene, size, setting], key)) for scene in scenes]
           for size, setting in settings])


def patches(found):
    names = {"cut": "Fjell's mesh", "cdlod": "CDLOD's patches"}
    print("The same ground as a mesh and as patches, with a shader that does next to nothing.\n")
    table(["drawn as", "held equal", "true error [px]", "triangles", "draws", "on the GPU [bytes]", "draw, GPU [us]",
           "frame [ms]", "draw a triangle [ns]"],
          [[names[row["method"]], "true error" if row["asked"] == "error" else "triangles",
            three(row["true_error_px"]), three(row["triangles"]), three(row["draws"]),
            three(row["mesh_bytes"] + row["height_bytes"]), three(row["draw_us"]), three(row["frame_ms"]),
            three(None if row["draw_us"] is None else row["draw_us"] * 1e3 / row["triangles"])]
           for row in found["patches"]])


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        found = json.load(file)
    clock = "" if found["timers"] else " Its timer queries tell nothing, so times are those of a whole frame."
    print(f"{found['device']}, on {found['date']}; {found['terrain']}.{clock}\n")
    flights(found)
    light(found)
    patches(found)


main()
