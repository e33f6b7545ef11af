"""What pip asks for a wheel (PEP 517): builds the module with CMake and puts it into one. Needs nothing but Python.

FJELL_PYTHON_BUILD: a build folder to build in, instead of one for this wheel alone.
"""

import base64
import hashlib
import os
import re
import subprocess
import sys
import sysconfig
import tempfile
import zipfile

SOURCE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


def _version():
    with open(os.path.join(SOURCE, "CMakeLists.txt")) as file:
        return re.search(r"project\(fjell VERSION (\S+)", file.read()).group(1)


def _metadata():
    with open(os.path.join(SOURCE, "pyproject.toml")) as file:
        description = re.search(r'^description = "(.*)"', file.read(), re.M).group(1)
    return (
        f"Metadata-Version: 2.1\nName: fjell\nVersion: {_version()}\nSummary: {description}\nLicense: MIT\n"
        "Requires-Python: >=3.9\nRequires-Dist: numpy\n"
    )


def _tag():
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    platform = re.sub(r"[-.]", "_", sysconfig.get_platform())
    return f"{python}-{python}-{platform}"


def _build(folder):
    subprocess.run(
        ["cmake", "-S", SOURCE, "-B", folder, "-DCMAKE_BUILD_TYPE=Release", "-DFJELL_PYTHON=ON", "-DFJELL_TESTS=OFF",
         "-DFJELL_BENCH=OFF", "-DCMAKE_UNITY_BUILD=ON", f"-DPython_EXECUTABLE={sys.executable}"],
        check=True, stdout=sys.stderr)


def _files(folder):
    """Names in the wheel, and what is in them."""
    package = os.path.join(folder, "python", "fjell")
    for name in sorted(os.listdir(package)):
        if name.endswith((".py", ".pyi", ".so", ".typed")):
            with open(os.path.join(package, name), "rb") as file:
                yield "fjell/" + name, file.read()


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    name = f"fjell-{_version()}"
    wheel = f"{name}-{_tag()}.whl"
    with tempfile.TemporaryDirectory() as own:
        folder = os.environ.get("FJELL_PYTHON_BUILD") or own
        if folder == own:
            _build(own)
        subprocess.run(["cmake", "--build", folder, "--target", "fjell_python", "--parallel"], check=True, stdout=sys.stderr)
        files = list(_files(folder))
    with open(os.path.join(SOURCE, "LICENSE"), "rb") as file:
        files.append((f"{name}.dist-info/LICENSE", file.read()))
    files.append((f"{name}.dist-info/METADATA", _metadata().encode()))
    files.append((f"{name}.dist-info/WHEEL", f"Wheel-Version: 1.0\nGenerator: fjell\nRoot-Is-Purelib: false\nTag: {_tag()}\n".encode()))
    record = ""
    for path, data in files:
        digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
        record += f"{path},sha256={digest},{len(data)}\n"
    files.append((f"{name}.dist-info/RECORD", (record + f"{name}.dist-info/RECORD,,\n").encode()))
    with zipfile.ZipFile(os.path.join(wheel_directory, wheel), "w", zipfile.ZIP_DEFLATED) as archive:
        for path, data in files:
            archive.writestr(zipfile.ZipInfo(path, (2020, 1, 1, 0, 0, 0)), data, zipfile.ZIP_DEFLATED)
    return wheel


def build_sdist(sdist_directory, config_settings=None):
    raise RuntimeError("fjell is built from its repository: pip install PATH_OF_THE_REPOSITORY")
