#!/usr/bin/env python3
"""Makes the pictures of the documents again, with the commands that stand beside them. ./dev pictures calls it.

docs/pictures.py BIN [NAME...]                   BIN: the folder of fjell-bake, fjell-fly and fjell-editor
docs/pictures.py BIN --tenth FOLDER [NAME...] [-- OPTIONS...]
                                                 a tenth as wide and high, as PNG, into FOLDER; with other options of fjell-fly

In a page, <!-- makes NAME [WIDTHxHEIGHT] [FRAME] --> is the line above a block of commands; or, without its end, above
commands that a reader need not see, with the end on a line of its own. The picture that its last command draws becomes
docs/pictures/NAME, of that size; of several frames it is the last, or the named one. What the command reads is made
first, by commands before it in the page. ./dev demo bakes the Earth. Other height fields and images that the page names
come from the folder FJELL_DATA; where they are not, the picture is skipped. A NAME stands for all pictures that begin
with it. Bakes are kept in the folder pictures beside BIN, and made again when their commands or fjell-bake are newer.
Exit codes: 0 done, 1 a command failed, 2 usage.
"""

import glob
import json
import os
import re
import shlex
import shutil
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
PAGES = ("docs/gallery.md", "docs/concepts.md", "docs/guides/first-picture.md", "docs/guides/baking.md", "docs/guides/light.md",
         "docs/guides/materials.md", "docs/guides/tuning.md")
PICTURES = os.path.join(ROOT, "docs", "pictures")
QUALITY = 84


class Missing(Exception):
    """A file that neither a command nor FJELL_DATA gives."""


def commands_of(page):
    """The commands of a page in order, as (command, words of the marker of its block if it is the last there)."""
    found, names, block, before, common = [], None, None, "", ""
    with open(os.path.join(ROOT, page), encoding="utf-8") as file:
        for line in file.read().splitlines():
            hidden = re.match(r"<!-- makes ([^>]+)$", line)
            if line.startswith("```") or line == "-->" or hidden:
                if block is None:
                    marker = hidden or re.match(r"<!-- makes (.+) -->$", before)
                    names, block = marker.group(1).split() if marker else [], []
                else:
                    lines = [part.split("  #")[0].strip() for part in "\n".join(block).replace("\\\n", " ").splitlines() if part.strip()]
                    if len(lines) == 1 and lines[0].startswith("--"):
                        common = lines[0]  # what "..." stands for
                    elif lines:
                        found += [(each, []) for each in lines[:-1]] + [(lines[-1], names)]
                    block = None
            elif block is not None:
                block.append(line)
            before = line
    return [(command.replace("...", common), names) for command, names in found]


def option(command, name):
    match = re.search(rf" {name}[ =](\S+)", command)
    return match.group(1) if match else None


def drawn_by(command):
    """Where a command puts its pictures: a folder or a file, or None."""
    at = re.search(r'"screenshot ([^" ]+)', command)
    if at:
        return at.group(1)
    at = option(command, "--render") or option(command, "--picture") or option(command, "--pictures") or option(command, "--screenshot")
    return at or (shlex.split(command)[-1] if command.startswith("docs/clip.sh") else None)


class Page:
    def __init__(self, name, binaries, options, tenth):
        self.commands, self.options, self.binaries, self.tenth = commands_of(name), options, binaries, tenth
        self.folder = os.path.join(os.path.dirname(binaries), "pictures", os.path.splitext(os.path.basename(name))[0])
        os.makedirs(self.folder, exist_ok=True)
        data = os.environ.get("FJELL_DATA", os.path.join(ROOT, "..", "shared", "data"))
        links = [os.path.join(ROOT, each) for each in ("content", "profiles", "docs", "build")]
        for path in links + glob.glob(os.path.join(data, "dem", "*")) + glob.glob(os.path.join(data, "textures", "*")):
            link = os.path.join(self.folder, os.path.basename(path))
            if not os.path.islink(link):
                os.symlink(os.path.abspath(path), link)

    def run(self, command):
        home = os.path.join(self.folder, "home")  # of an editor that has kept nothing yet
        shutil.rmtree(home, ignore_errors=True)
        shaders = os.path.join(os.path.dirname(self.binaries), "shaders")  # where Mesa finds what it has compiled
        env = {"MESA_SHADER_CACHE_DIR": shaders, **os.environ, "PATH": self.binaries + ":" + os.environ["PATH"]}
        env.update({f"XDG_{kind}_HOME": home for kind in ("CONFIG", "DATA", "STATE", "CACHE")})
        if command.startswith("fjell-editor") and "--headless" not in command:
            command = "xvfb-run -a -s '-screen 0 1920x1200x24' " + command
        result = subprocess.run(command, shell=True, cwd=self.folder, env=env, capture_output=True, text=True)
        allowed = (0, 1) if "--read-mb-s" in command or "few.toml" in command else (0,)  # 1: it ended before all was loaded
        if result.returncode not in allowed:
            sys.exit(f"{command}\n{result.stdout}{result.stderr}pictures: exit code {result.returncode}")

    def makes(self, path, before):
        """The index of the last command before another that makes a file, or None."""
        for i in range(before - 1, -1, -1):
            out = option(self.commands[i][0], "-o")
            if out == path:
                return i
        for i in range(before - 1, -1, -1):
            out = option(self.commands[i][0], "-o")
            if out and "." not in out and path.startswith(out + "."):
                return i
        return None

    def prepare(self, at):
        """Makes what command `at` reads; returns all that it depends on, as text."""
        command, history = self.commands[at][0], ""
        for token in shlex.split(command)[1:]:
            if token in (option(command, "-o"), drawn_by(command)) or "=" in token or " " in token:
                continue
            maker = self.makes(token, at)
            if maker is not None:
                history += self.bake(maker)
            elif token.endswith(".journal"):
                history += self.lay(token, at)
            elif re.search(r"\.(fjell|png|tif|jpg|dem|r32)$", token) and not os.path.exists(os.path.join(self.folder, token)):
                raise Missing(token)
        return history

    def lay(self, journal, before):
        """Runs the commands that lay roads and rivers into a journal, in order."""
        history = ""
        for i in range(before):
            words = shlex.split(self.commands[i][0])
            if words[:2] in (["fjell-bake", "rivers"], ["fjell-bake", "roads"]) and words[2] + ".journal" == journal:
                history += self.prepare(i) + self.commands[i][0] + "\n"
                print("   ", self.commands[i][0], flush=True)
                self.run(self.commands[i][0])
        return history

    def bake(self, at):
        command = self.commands[at][0]
        if not option(command, "-o"):
            raise Missing(shlex.split(command)[-1])
        if self.tenth and command.startswith("fjell-bake materials"):
            command += " --size 256"  # small pictures show coarse mips, and all of them would take most of the time
        history = self.prepare(at) + command + "\n"
        stamp = os.path.join(self.folder, option(command, "-o") + ".command")
        read = [os.path.join(self.binaries, shlex.split(command)[0])] + [os.path.join(ROOT, word) for word in shlex.split(command)]
        fresh = os.path.exists(stamp) and all(os.path.getmtime(path) < os.path.getmtime(stamp) for path in read if os.path.isfile(path))
        if fresh:
            with open(stamp, encoding="utf-8") as file:
                fresh = file.read() == history
        if not fresh:
            print("   ", command, flush=True)
            if os.path.exists(stamp):
                os.remove(stamp)
            if option(command, "--pictures"):
                os.makedirs(os.path.join(self.folder, option(command, "--pictures")), exist_ok=True)
            self.run(command)
            with open(stamp, "w", encoding="utf-8") as file:
                file.write(history)
        return history

    def kept(self, picture):
        """A copy that the next run does not replace."""
        self.copies = getattr(self, "copies", 0) + 1
        copy = os.path.join(self.folder, f"kept-{self.copies}.png")
        shutil.copy(picture, copy)
        return copy

    def draw(self, at, change=lambda command: command):
        """Runs the drawing command `at`; returns its pictures."""
        self.prepare(at)
        command = change(self.commands[at][0])
        if self.tenth:
            command = re.sub(r"--size (\d+)x(\d+)", lambda size: f"--size {int(size[1]) // 10}x{int(size[2]) // 10}", command)
        for name, value in zip(self.options[::2], self.options[1::2]):
            command, there = re.subn(rf" {name} \S+", f" {name} {value}", command) if name != "--light" else (command, 0)
            command += "" if there else f" {name} {value}"
        where = os.path.join(self.folder, drawn_by(command))
        if os.path.isdir(where):
            shutil.rmtree(where)
        elif os.path.exists(where):
            os.remove(where)
        print("   ", command, flush=True)
        self.run(command)
        return sorted(glob.glob(os.path.join(where, "*.png"))) if os.path.isdir(where) else [where]


def profile(page, name, **changes):
    """A profile beside the page's pictures: the laptop's with some keys changed."""
    with open(os.path.join(ROOT, "profiles", "laptop.toml"), encoding="utf-8") as file:
        text = file.read()
    for key, value in changes.items():
        text, found = re.subn(rf"(?m)^{key} = .*$", f"{key} = {value}", text)
        assert found == 1, key
    with open(os.path.join(page.folder, name), "w", encoding="utf-8") as file:
        file.write(text)


# --- pictures that are put together --------------------------------------------------------------------------------------

def budgets(page, at, out):
    """One view with room for three numbers of vertices, side by side."""
    parts = []
    for vertices in (1500, 6000, 24000):
        profile(page, "mine.toml", vertices=vertices, triangles=3 * vertices)
        parts.append(page.kept(page.draw(at)[-1]))
    convert(parts + ["+append"], out)


def heights(page, at, out):
    """The field of heights itself."""
    page.bake(at)
    field = os.path.join(page.folder, option(page.commands[at][0], "-o"))
    convert([field, "-quiet", "-auto-level", "-resize", "480x480"], out)


def stream(page, at, out):
    """Five frames of a flight that streams, denser at its begin, side by side."""
    frames = page.draw(at)
    convert([frames[i] for i in (0, 1, 3, 8, len(frames) - 1)] + ["-resize", "50%", "+append"], out)


def morph(page, at, out):
    """Five frames without and with morphing, in two rows."""
    rows = []
    for extra in ("", " --morph error"):
        rows += ["("] + [page.kept(drawn) for drawn in page.draw(at, change=lambda command: command + extra)] + ["+append", ")"]
    convert(rows + ["-append"], out)


def materials(page, at, out):
    """Ten materials under a low sun: their colours, shaded by their heights."""
    page.bake(at)
    pictures = []
    for name in ("rock", "scree", "gravel", "soil", "sand", "grass", "dry_grass", "forest_floor", "snow", "ice"):
        path = os.path.join(page.folder, "swatches", name)
        pictures += ["(", path + "-albedo.png", "(", path + "-height.png", "-shade", "315x45", "-auto-level", ")", "-compose", "SoftLight",
                     "-composite", "-resize", "256x256", ")"]
    convert(["("] + pictures[:5 * 14] + ["+append", ")", "("] + pictures[5 * 14:] + ["+append", ")", "-append"], out)


def parts(page, at, out):
    """The editor's window with numbers on its parts, which its dump tells."""
    picture = page.draw(at)[-1]
    with open(os.path.join(page.folder, "editor.json"), encoding="utf-8") as file:
        state = json.load(file)
    marks, view = state["marks"], state["interface"]["view_px"]
    right = lambda name: (marks[name][0] + marks[name][2], marks[name][1] + marks[name][3] / 2)
    places = [right("menu.help"), right("panel.light"), right("group.view.picture"), right("group.view.overlays"),
              right("map.overview"), right("group.view.position"), (marks["handle.left-column"][0] + 5, view[1] + 0.62 * view[3]),
              (view[0] + 0.5 * view[2], view[1] + 0.6 * view[3]), right("status.threshold"), right("status.triangles")]
    drawing = []
    for number, (x, y) in enumerate(places, 1):
        radius = 11 if number < 9 else 8
        if number < 3 or number > 8:  # beside the text; the others lie on their parts
            x += radius + 2
        drawing += ["-fill", "#d55e00", "-stroke", "white", "-strokewidth", "1.5", "-draw", f"circle {x:.0f},{y:.0f} {x + radius:.0f},{y:.0f}",
                    "-fill", "white", "-stroke", "none", "-font", "DejaVu-Sans-Bold", "-pointsize", str(radius + (3 if number < 10 else 1)), "-gravity", "northwest",
                    "-annotate", f"+{x - radius * len(str(number)) * 0.42:.0f}+{y - 0.72 * radius:.0f}", str(number)]
    convert([picture, *drawing], out)


COMPOSED = {"editor-parts.jpg": parts, "budgets-wire.jpg": budgets, "first-heights.jpg": heights, "stream.jpg": stream, "morph.jpg": morph,
            "materials.jpg": materials}


def convert(arguments, out):
    subprocess.run(["convert", *arguments, "-strip", "-interlace", "none", "-sampling-factor", "4:2:0", "-quality", str(QUALITY), out], check=True)


def make(page, at, names, folder):
    name = names[0]
    size = next((word for word in names[1:] if "x" in word), None)
    frame = next((f"frame_{int(word):05}.png" for word in names[1:] if word.isdigit()), "")
    out = os.path.join(folder, name)
    picture = lambda: [drawn for drawn in page.draw(at) if drawn.endswith(frame)][-1]
    if page.tenth:
        shutil.copy(picture(), os.path.splitext(out)[0] + ".png")
    elif name in COMPOSED:
        COMPOSED[name](page, at, out)
    elif name.endswith(".webp"):
        shutil.copy(picture(), out)
    else:
        convert([picture()] + (["-filter", "Lanczos", "-resize", size + "!"] if size else []), out)


def main(arguments):
    if not arguments or not os.path.exists(os.path.join(arguments[0], "fjell-fly")):
        sys.exit(__doc__)
    binaries, wanted, options, folder = os.path.abspath(arguments[0]), arguments[1:], [], PICTURES
    if "--" in wanted:
        options, wanted = wanted[wanted.index("--") + 1:], wanted[:wanted.index("--")]
    tenth = wanted[:1] == ["--tenth"]
    if tenth:
        folder, wanted = os.path.abspath(wanted[1]), wanted[2:]
    made, skipped = 0, 0
    for name in PAGES:
        page = Page(name, binaries, options, tenth)
        profile(page, "few.toml", page_slots=400, map_mb=2)
        for at, (_, names) in enumerate(page.commands):
            if not names or (wanted and not any(names[0].startswith(each) for each in wanted)):
                continue
            print(names[0], flush=True)
            try:
                make(page, at, names, folder)
                made += 1
            except Missing as missing:
                print(f"    skipped: there is no {missing}; ./dev demo bakes the Earth, FJELL_DATA names the folder of other height fields", flush=True)
                skipped += 1
    print(f"pictures: {made} made, {skipped} skipped")
    return 0 if made or skipped else 2


sys.exit(main(sys.argv[1:]))
